#version 460
// The corners of one geometry of one instance: gl_InstanceIndex is its row of the table of what is drawn, three vertices are a triangle.
// Reads: scene, view, drawn, counts. Writes: nothing but what the fragment shader takes.
#extension GL_GOOGLE_include_directive : require
#include "gbuffer/visible.glsl"

layout(location = 0) flat out uvec3 ids;  // instance bits of Hit, geometry, primitive

void main() {
    const DrawnGeometry row = push.drawn.v[gl_InstanceIndex];
    const uint primitive = uint(gl_VertexIndex) / 3u;
    const Affine world_from_object = scene_instance(row.instance).world_from_object;
    const uint flags = scene_instance(row.instance).flags, corner = front_corner(flags, uint(gl_VertexIndex) % 3u);
    const Geometry geometry = scene_geometry(scene_instance(row.instance).geometry_base + row.geometry);
    const uvec3 index = IndexArray(geometry.indices).v[primitive];
    const vec3 position = PositionArray(geometry.positions).v[corner == 0u ? index.x : corner == 1u ? index.y : index.z];
    vec3 ignored;
    const vec3 position_ws = transform_point_precise(world_from_object, position, vec3(0.0), ignored);
    ids = uvec3(row.instance | (flags & kInstanceDeforms) << 30, row.geometry, primitive);
    const Camera camera = push.view.data.camera;
    gl_Position = to_clip(camera, to_view(camera, position_ws), uintBitsToFloat(push.counts.data.far_bits));
    gl_Position.xy -= 2.0 * push.view.data.jitter / vec2(push.view.data.width, push.view.data.height) * gl_Position.w;  // pixels look beside their centres
}
