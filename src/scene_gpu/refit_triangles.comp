#version 460
// Triangles of deformed meshes' bottom levels (shared/refit.h), at their positions of now. Reads: jobs, chunks, parts and the geometry
// behind them, plan. Writes: triangles.
#extension GL_GOOGLE_include_directive : require
#include "lib/bvh_nodes.glsl"
#include "shared/refit.h"

layout(local_size_x = 64) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Jobs { RefitJob v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Chunks { WorkChunk v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer Parts { RefitPart v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Plan { RefitTriangle v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Positions { vec3 v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Indices { uvec3 v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) writeonly buffer Triangles { BvhTriangle v[]; };
layout(push_constant, scalar) uniform Push {
    Jobs jobs;
    Chunks chunks;
    Parts parts;
    Plan plan;
    Triangles triangles;
    uint chunk_count;
} push;

void main() {
    const uint group = gl_WorkGroupID.y * kWorkGroups + gl_WorkGroupID.x;
    if (group >= push.chunk_count) return;
    const WorkChunk chunk = push.chunks.v[group];
    const RefitJob job = push.jobs.v[chunk.job];
    const uint i = chunk.first + gl_LocalInvocationIndex;
    if (i >= job.triangle_count) return;
    const RefitTriangle plan = push.plan.v[job.plan_triangle + i];
    const RefitPart part = push.parts.v[job.part + plan.geometry];
    const uvec3 index = Indices(part.indices).v[plan.primitive];
    Positions positions = Positions(part.positions);
    Triangles(row_address(uint64_t(push.triangles), job.triangle + i, 48u)).v[0] =
        BvhTriangle(positions.v[index.x], positions.v[index.y], positions.v[index.z], plan.rest, plan.geometry, plan.primitive);
}
