#version 460
// Vertices of deformed meshes: morph targets, then the skin; normals by the cofactors of the blended joints (scene/deform.cpp does the same
// on the host). Reads: jobs, chunks, targets, palette, and the meshes at rest behind the jobs. Writes: the deformed arrays behind them.
#extension GL_GOOGLE_include_directive : require
#include "lib/affine.glsl"
#include "lib/geometry.glsl"
#include "shared/deform.h"

layout(local_size_x = 64) in;
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer Jobs { DeformJob v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Chunks { WorkChunk v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer Targets { ActiveTarget v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Palette { Affine v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Vectors { vec3 v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Influences { JointInfluence v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer RestAttributes { VertexAttributes v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Positions { vec3 v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Attributes { VertexAttributes v[]; };
layout(push_constant, scalar) uniform Push {
    Jobs jobs;
    Chunks chunks;
    Targets targets;
    Palette palette;
    uint chunk_count;
} push;

vec3 unit_or(vec3 v, vec3 otherwise) { return dot(v, v) > 0.0 ? precise_normalize(v) : otherwise; }
vec3 delta(uint64_t vectors, uint vertex, float weight) { return vectors == 0ul ? vec3(0.0) : weight * Vectors(vectors).v[vertex]; }

void morph(DeformJob job, uint vertex, inout vec3 position, inout vec3 normal, inout vec3 tangent) {
    vec3 n = normal, t = tangent;
    for (uint i = job.target; i < job.target + job.target_count; ++i) {
        const ActiveTarget target = push.targets.v[i];
        position += delta(target.positions, vertex, target.weight);
        n += delta(target.normals, vertex, target.weight);
        t += delta(target.tangents, vertex, target.weight);
    }
    normal = unit_or(n, normal);
    tangent = unit_or(t, tangent);
}

Affine blended_joints(DeformJob job, uint vertex) {
    Affine sum = Affine(vec4(0.0), vec4(0.0), vec4(0.0));
    for (uint i = vertex * job.influence_count; i < (vertex + 1u) * job.influence_count; ++i) {
        const JointInfluence influence = Influences(job.influences).v[i];
        if (influence.weight == 0.0) continue;
        const Affine joint = push.palette.v[job.joint + influence.joint];
        sum = Affine(sum.row0 + influence.weight * joint.row0, sum.row1 + influence.weight * joint.row1, sum.row2 + influence.weight * joint.row2);
    }
    return sum;
}

void skin(Affine m, inout vec3 position, inout vec3 normal, inout vec3 tangent) {
    vec3 ignored;
    position = transform_point_precise(m, position, vec3(0.0), ignored);
    const vec3 row0 = m.row0.xyz, row1 = m.row1.xyz, row2 = m.row2.xyz;
    const vec3 n = vec3(dot(cross(row1, row2), normal), dot(cross(row2, row0), normal), dot(cross(row0, row1), normal));
    normal = unit_or(n, vec3(0.0));
    tangent = unit_or(transform_vector(m, tangent), vec3(0.0));
}

void main() {
    const uint group = gl_WorkGroupID.y * kWorkGroups + gl_WorkGroupID.x;
    if (group >= push.chunk_count) return;
    const WorkChunk chunk = push.chunks.v[group];
    const DeformJob job = push.jobs.v[chunk.job];
    const uint vertex = chunk.first + gl_LocalInvocationIndex;
    if (vertex >= job.vertex_count) return;
    vec3 position = Vectors(job.rest_positions).v[vertex];
    VertexAttributes attributes = RestAttributes(job.rest_attributes).v[vertex];
    vec3 tangent = attributes.tangent.xyz;
    if (job.target_count != 0u) morph(job, vertex, position, attributes.normal, tangent);
    if (job.influence_count != 0u) skin(blended_joints(job, vertex), position, attributes.normal, tangent);
    attributes.tangent.xyz = tangent;
    Positions(job.positions).v[vertex] = position;
    Attributes(job.attributes).v[vertex] = attributes;
}
