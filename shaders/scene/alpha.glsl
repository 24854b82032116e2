// Does a candidate hit count? One function for any-hit shaders, ray queries and our own traversal.
// The answer depends only on (ray, instance, geometry, primitive): asked twice it is the same, and two rays never share it.
#ifndef PARHELION_SCENE_ALPHA_GLSL
#define PARHELION_SCENE_ALPHA_GLSL
#include "lib/hash.glsl"
#include "scene/scene.glsl"

// Opacity at barycentrics (weights of vertex 1 and 2): base colour alpha x texture x vertex colour.
float fetch_alpha(Geometry geometry, uint primitive, vec2 barycentrics) {
    const Material material = scene_material(geometry.material);
    const uvec3 index = IndexArray(geometry.indices).v[primitive];
    const vec3 weights = vec3(1.0 - barycentrics.x - barycentrics.y, barycentrics);
    AttributeArray attributes = AttributeArray(geometry.attributes);
    const vec2 uv0 = weights.x * attributes.v[index.x].uv0 + weights.y * attributes.v[index.y].uv0 + weights.z * attributes.v[index.z].uv0;
    const vec2 uv1 = weights.x * attributes.v[index.x].uv1 + weights.y * attributes.v[index.y].uv1 + weights.z * attributes.v[index.z].uv1;
    const float vertex_alpha = weights.x * unpackUnorm4x8(attributes.v[index.x].color).w +
                               weights.y * unpackUnorm4x8(attributes.v[index.y].color).w +
                               weights.z * unpackUnorm4x8(attributes.v[index.z].color).w;
    return material.base_color.w * vertex_alpha * fetch_texture(material.base_color_texture, uv0, uv1, vec4(1.0)).w;
}

// `alpha_key`: hash of (pixel, sample, bounce, ray kind).
bool accept_hit(uint alpha_key, uint instance, uint geometry_of_mesh, uint primitive, vec2 barycentrics, bool front_facing) {
    const Geometry geometry = scene_geometry(scene_instance(instance).geometry_base + geometry_of_mesh);
    if (!front_facing && scene.header.culling != 0u && (geometry.flags & (kMaterialDoubleSided | kMaterialTransmits)) == 0u) return false;
    const uint mode = geometry.flags & kAlphaModeMask;
    if (mode == kAlphaOpaque) return true;
    const float alpha = fetch_alpha(geometry, primitive, barycentrics);
    if (mode == kAlphaMask) return alpha >= scene_material(geometry.material).alpha_cutoff;
    return hash_alpha(alpha_key, instance, geometry_of_mesh, primitive) < alpha;
}
#endif
