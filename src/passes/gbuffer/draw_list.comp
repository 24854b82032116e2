#version 460
// The list of draws of one pass, kind by kind, in order of rows: the same list whatever runs first, so that which of two triangles of equal
// depth is seen does not change from run to run. Reads: drawn, scene, bits. Writes: draws (gpu::Draw by row of the pass), counts.
#extension GL_GOOGLE_include_directive : require
#include "scene/scene.glsl"
#include "shared/raster.h"

layout(local_size_x = kRasterGroup) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer DrawnArray { DrawnGeometry v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Bits { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Draws { uvec4 v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Counts { RasterCounts data; };
layout(push_constant, scalar) uniform Push {
    DrawnArray drawn;
    Bits bits;
    Draws draws;
    Counts counts;
    uint row_count;    // a multiple of kRasterGroup
    uint second_pass;  // 0 or 1
    uint begin[3];     // first rows of the kinds; multiples of kRasterGroup
} push;

shared uint sum;

uint word(uint index) { return push.bits.v[push.second_pass * (push.row_count >> 5) + index]; }

void main() {
    const uint row = gl_GlobalInvocationID.x, group_row = gl_WorkGroupID.x * kRasterGroup;
    const uint kind = group_row >= push.begin[2] ? 2u : group_row >= push.begin[1] ? 1u : 0u, first = push.begin[kind];
    if (gl_LocalInvocationID.x == 0u) sum = 0u;
    barrier();
    uint mine = 0u;
    for (uint w = (first >> 5) + gl_LocalInvocationID.x; w < group_row >> 5; w += kRasterGroup) mine += bitCount(word(w));
    if (mine != 0u) atomicAdd(sum, mine);
    barrier();
    uint before = sum;
    if ((row >> 5) != (group_row >> 5)) before += bitCount(word(group_row >> 5));
    const uint own = word(row >> 5), bit = 1u << (row & 31u);
    const uint place = before + bitCount(own & (bit - 1u));
    if ((own & bit) != 0u) {
        const DrawnGeometry item = push.drawn.v[row];
        const uint triangles = scene_geometry(scene_instance(item.instance).geometry_base + item.geometry).triangle_count;
        push.draws.v[push.second_pass * push.row_count + first + place] = uvec4(3u * triangles, 1u, 0u, row);
    }
    const uint end = kind == 2u ? push.row_count : push.begin[kind + 1u];
    if (row + 1u == end) push.counts.data.drawn[push.second_pass * kRasterKindCount + kind] = place + uint((own & bit) != 0u);
}
