#version 460
// How loosely boxes fit around a deformed mesh: of each cluster of 64 triangles in a row, which import has put beside each other, the area of the
// box around them and the area of the triangles themselves. What is torn apart has large boxes around little.
// Reads: jobs, chunks and the geometry behind them. Writes: areas, of each chunk both.
#extension GL_GOOGLE_include_directive : require
#include "shared/refit.h"

layout(local_size_x = 64) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Positions { vec3 v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Indices { uvec3 v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer Jobs { DecayJob v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Chunks { WorkChunk v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Areas { vec2 v[]; };
layout(push_constant, scalar) uniform Push {
    Jobs jobs;
    Chunks chunks;
    Areas areas;
    uint chunk_count;
} push;

shared vec3 low[64], high[64];
shared float area[64];

void main() {
    const uint group = gl_WorkGroupID.y * kWorkGroups + gl_WorkGroupID.x, lane = gl_LocalInvocationIndex;
    if (group >= push.chunk_count) return;
    const WorkChunk chunk = push.chunks.v[group];
    const DecayJob job = push.jobs.v[chunk.job];
    const uint triangle = min(chunk.first + lane, job.triangle_count - 1u);  // the last one again: boxes do not mind
    const uvec3 index = Indices(job.indices).v[triangle];
    Positions positions = Positions(job.positions);
    const vec3 a = positions.v[index.x], b = positions.v[index.y], c = positions.v[index.z];
    low[lane] = min(a, min(b, c));
    high[lane] = max(a, max(b, c));
    area[lane] = chunk.first + lane < job.triangle_count ? 0.5 * length(cross(b - a, c - a)) : 0.0;
    for (uint step = 32u; step != 0u; step >>= 1) {
        barrier();
        if (lane >= step) continue;
        low[lane] = min(low[lane], low[lane + step]);
        high[lane] = max(high[lane], high[lane + step]);
        area[lane] += area[lane + step];
    }
    if (lane != 0u) return;
    const vec3 extent = high[0] - low[0];
    push.areas.v[group] = vec2(2.0 * dot(extent, extent.yzx), area[0]);
}
