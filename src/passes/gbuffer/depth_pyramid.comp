#version 460
// Six levels of the depth pyramid from the depth buffer, or with FROM_LEVEL from the pyramid's own level `from`. A work group takes a square
// of 64 x 64, an invocation 4 x 4 of them. Greene, Kass, Miller 1993, "Hierarchical Z-Buffer Visibility"; reversed depth: the farthest is the least.
// Reads: depth or pyramid, counts. Writes: pyramid.
// variants: FROM_LEVEL
#extension GL_GOOGLE_include_directive : require
#include "gbuffer/depth_pyramid.glsl"
#include "shared/raster.h"

layout(local_size_x = 16, local_size_y = 16) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Counts { RasterCounts data; };
#ifdef FROM_LEVEL
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Pyramid { float v[]; };
#else
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Pyramid { float v[]; };
layout(set = 1, binding = 0) uniform sampler2D depth;
#endif
layout(push_constant, scalar) uniform Push {
    Pyramid pyramid;
    Counts counts;
    uint width, height;
    uint from;  // level; 0: the depth buffer
} push;

shared float farthest[16][16];

float load(uvec2 at, uvec2 size) {
    at = min(at, size - 1u);
#ifdef FROM_LEVEL
    return push.pyramid.v[pyramid_offset(uvec2(push.width, push.height), push.from) + at.y * size.x + at.x];
#else
    return texelFetch(depth, ivec2(at), 0).x;
#endif
}

void store(uint level, uvec2 at, float value) {
    const uvec2 size = pyramid_size(uvec2(push.width, push.height), level);
    if (at.x < size.x && at.y < size.y) push.pyramid.v[pyramid_offset(uvec2(push.width, push.height), level) + at.y * size.x + at.x] = value;
}

void main() {
    const uvec2 picture = uvec2(push.width, push.height), size = pyramid_size(picture, push.from);
    const uvec2 id = gl_LocalInvocationID.xy, at = gl_GlobalInvocationID.xy;
    if (push.from == 0u && at == uvec2(0u)) push.pyramid.v[0] = uintBitsToFloat(push.counts.data.far_bits);
    float all = 1.0;
    for (uint i = 0u; i < 4u; ++i) {
        const uvec2 cell = 2u * at + uvec2(i & 1u, i >> 1), corner = 2u * cell;
        const float four = min(min(load(corner, size), load(corner + uvec2(1u, 0u), size)), min(load(corner + uvec2(0u, 1u), size), load(corner + uvec2(1u), size)));
        store(push.from + 1u, cell, four);
        all = min(all, four);
    }
    store(push.from + 2u, at, all);
    farthest[id.y][id.x] = all;
    for (uint k = 1u; k <= 4u; ++k) {
        barrier();
        const uvec2 cell = id << 1;
        const bool mine = max(id.x, id.y) < (16u >> k);
        if (mine) all = min(min(farthest[cell.y][cell.x], farthest[cell.y][cell.x + 1u]), min(farthest[cell.y + 1u][cell.x], farthest[cell.y + 1u][cell.x + 1u]));
        barrier();
        if (mine) {
            farthest[id.y][id.x] = all;
            store(push.from + 2u + k, gl_WorkGroupID.xy * (16u >> k) + id, all);
        }
    }
}
