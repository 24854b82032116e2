#version 460
// Test shader: what scene/previous.glsl says of every row. Reads: scene. Writes: rows.
#extension GL_GOOGLE_include_directive : require
#include "scene/previous.glsl"

layout(local_size_x = 64) in;
struct Row {
    uint instance_before, instance_now, emitter_now, emitter_kind, emitter_instance;
    float emitter_intensity;
    vec3 place, place_before;
    uint emitter_count, emitter_before_count, instance_before_count;
    float lit_before;
};
layout(set = 1, binding = 0, scalar) writeonly buffer Rows { Row v[]; } rows;
layout(push_constant) uniform Push { uint count, instance_rows; } push;

vec3 origin_of(Affine a) { return vec3(a.row0.w, a.row1.w, a.row2.w); }

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    Row row = Row(instance_before(i), instance_now(i), emitter_now(i), kNone, kNone, 0.0, vec3(0.0), vec3(0.0), scene.header.emitter_count, scene.header.emitter_before_count,
                  scene.header.instance_before_count, lit_before(i));
    if (i < push.instance_rows) {
        row.place = origin_of(scene_instance(i).world_from_object);
        row.place_before = origin_of(placement_before(i));
    }
    if (i < scene.header.emitter_count) {
        const Emitter emitter = scene_emitter(i);
        row.emitter_kind = emitter.kind;
        row.emitter_instance = emitter.instance;
        row.emitter_intensity = emitter.intensity.x;
    }
    rows.v[i] = row;
}
