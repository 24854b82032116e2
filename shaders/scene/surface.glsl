// The canonical surface: what a hit means. Traversal decides only which triangle; t, barycentrics and position are recomputed
// here by one precise function, so the same triangle is the same surface, bit for bit, in every way to trace.
#ifndef PARHELION_SCENE_SURFACE_GLSL
#define PARHELION_SCENE_SURFACE_GLSL
#include "lib/affine.glsl"
#include "lib/bsdf.glsl"
#include "lib/geometry.glsl"
#include "lib/ray_triangle.glsl"
#include "scene/previous.glsl"
#include "scene/proxy.glsl"
#include "scene/ray.glsl"

struct Surface {
    vec3 position_ws;
    vec3 position_error;  // absolute rounding error bounds of position_ws
    float t;
    vec2 barycentrics;
    vec3 n_geometric_ws;  // unit, on the front side (counter-clockwise in object space, as glTF)
    vec3 n_shading_ws;    // unit, interpolated and normal mapped, on the front side
    bool front_facing;    // the ray came from the front side
    BsdfParameters scattering;  // its eta is left to the path, which knows in which volume the ray is
    vec3 n_coat_ws;       // unit, the clear coat's shading normal, on the front side (LAYERS)
    vec3 emission;        // nits towards the ray's origin
    uint instance, geometry, primitive, material;  // geometry: of the mesh
    bool integer_offset;  // rays leave it by offset_origin_integer()
    float double_area_ws; // twice the triangle's area, square metres
    float extent_ws;      // the longer of its edges at the first corner, metres
};

vec3 interpolate(vec3 weights, vec3 a, vec3 b, vec3 c) {
    precise const vec3 v = (weights.x * a + weights.y * b) + weights.z * c;
    return v;
}
vec2 interpolate(vec3 weights, vec2 a, vec2 b, vec2 c) {
    precise const vec2 v = (weights.x * a + weights.y * b) + weights.z * c;
    return v;
}

// Where textures are read.
struct TexturePoint {
    vec2 uv0, uv1;
    TextureFootprint footprint;
};
vec4 fetch_texture(TextureRef ref, TexturePoint at) { return fetch_texture(ref, at.uv0, at.uv1, at.footprint, vec4(1.0)); }

// Tangent-space normal from a normal map: xy scaled, z rebuilt. Falls back to the vertex normal where tangents degenerate.
vec3 apply_normal_map(TextureRef map, float map_scale, TexturePoint at, vec3 n, vec4 tangent) {
    if (map.texture == kNone || dot(tangent.xyz, tangent.xyz) < 1e-6) return n;
    precise const vec2 xy = (fetch_texture(map, at).xy * 2.0 - 1.0) * map_scale;
    precise const vec3 along = tangent.xyz - n * precise_dot(n, tangent.xyz);
    precise const vec3 t = precise_normalize(along);
    precise const vec3 b = precise_cross(n, t) * tangent.w;
    precise const float z = sqrt(max(0.0, 1.0 - (xy.x * xy.x + xy.y * xy.y)));
    precise const vec3 bent = (xy.x * t + xy.y * b) + z * n;
    return precise_normalize(bent);
}

float double_area_uv(vec2 a, vec2 b, vec2 c) {
    const vec2 e1 = b - a, e2 = c - a;
    return abs(e1.x * e2.y - e1.y * e2.x);
}

// The parts of the material that only scenes with LAYERS have.
void fetch_layers(Material material, TexturePoint at, vec3 n_vertex_ws, vec4 tangent_ws, inout Surface s) {
    s.n_coat_ws = n_vertex_ws;
    s.scattering.transmission = 0.0;
    s.scattering.thin = (material.flags & kMaterialThin) != 0u;
    s.scattering.eta = material.ior;
    s.scattering.inside = false;
    s.scattering.coat = 0.0;
    s.scattering.sheen_color = vec3(0.0);
    // Index 0 stands for a surface that reflects everything.
    if ((material.flags & kMaterialTransmits) != 0u && material.ior > 0.0) s.scattering.transmission = material.transmission * fetch_texture(material.transmission_texture, at).r;
    if ((material.flags & kMaterialCoated) != 0u) {
        s.scattering.coat = material.coat * fetch_texture(material.coat_texture, at).r;
        s.scattering.coat_roughness = material.coat_roughness * fetch_texture(material.coat_roughness_texture, at).g;
        s.n_coat_ws = apply_normal_map(material.coat_normal_texture, material.coat_normal_scale, at, n_vertex_ws, tangent_ws);
    }
    if ((material.flags & kMaterialSheen) != 0u) {
        s.scattering.sheen_color = material.sheen_color * fetch_texture(material.sheen_color_texture, at).rgb;
        s.scattering.sheen_roughness = material.sheen_roughness * fetch_texture(material.sheen_roughness_texture, at).a;
    }
}

// Share of the emission below a clear coat that gets out towards w, both normals unit (KHR_materials_clearcoat). By the interpolated
// normal, without the coat's normal map, so that a point of a light and a ray that meets it agree.
float emission_through_coat(Material material, TexturePoint at, vec3 n_vertex_ws, vec3 w) {
    if (!kLayers || (material.flags & kMaterialCoated) == 0u) return 1.0;
    return 1.0 - material.coat * fetch_texture(material.coat_texture, at).r * fresnel_schlick(vec3(kCoatF0), 1.0, abs(dot(n_vertex_ws, w))).x;
}

// Unit, from an interpolated one in object space.
vec3 vertex_normal(Instance instance, vec3 n_object, vec3 n_geometric_ws, bool before) {
    precise const vec3 n_world = before ? transform_normal_by_cofactors(instance.world_from_object_before, n_object) : transform_normal(instance.object_from_world, n_object);
    precise const vec3 n = precise_dot(n_world, n_world) > 0.0 ? precise_normalize(n_world) : n_geometric_ws;
    return n;
}

vec3 vertex_normal(Instance instance, vec3 n_object, vec3 n_geometric_ws) { return vertex_normal(instance, n_object, n_geometric_ws, false); }

// As the scene stands (kNow) or stood a frame ago (kBefore), by rows of this frame. `cone` is the ray's: how finely textures are read. Nothing
// else of the surface depends on it.
Surface fetch_surface_at(Hit hit, Ray ray, RayCone cone, uint moment) {
    precise Surface s;
    s.instance = hit_instance(hit);
    s.geometry = hit.geometry;
    s.primitive = hit.primitive;
    const Instance instance = scene_instance(s.instance);
    const bool before = moment == kBefore && scene.header.moving != 0u;
    Affine world_from_object = instance.world_from_object;
    if (before) world_from_object = instance.world_from_object_before;
    const Geometry geometry = scene_geometry((before ? instance.geometry_base_before : instance.geometry_base) + hit.geometry);
    Material material = scene_material(geometry.material);
    material.flags &= ~ABSENT_MATERIAL_FLAGS;
    s.material = geometry.material;
    s.integer_offset = false;

    const uvec3 index = IndexArray(geometry.indices).v[hit.primitive];
    PositionArray positions = PositionArray(geometry.positions);
    vec3 e0, e1, e2;
    precise const vec3 p0 = transform_point_precise(world_from_object, positions.v[index.x], vec3(0.0), e0);
    precise const vec3 p1 = transform_point_precise(world_from_object, positions.v[index.y], vec3(0.0), e1);
    precise const vec3 p2 = transform_point_precise(world_from_object, positions.v[index.z], vec3(0.0), e2);
    intersect_canonical(ray.origin_ws, ray.direction_ws, p0, p1, p2, s.t, s.barycentrics);
    precise const vec3 weights = vec3(1.0 - s.barycentrics.x - s.barycentrics.y, s.barycentrics);
    precise const vec3 position = weights.x * p0 + weights.y * p1 + weights.z * p2;
    s.position_ws = position;
    // Interpolation adds seven roundings (Pharr et al. 2016, 3.9.4) on top of the transformed vertices' own errors.
    const float kGamma7 = 7.0 * 5.9604645e-8 / (1.0 - 7.0 * 5.9604645e-8);
    s.position_error = kGamma7 * (weights.x * abs(p0) + weights.y * abs(p1) + weights.z * abs(p2)) + max(e0, max(e1, e2));
    // Whoever traces the next ray sees the triangle with roundings of its own, of the size of its largest coordinates in any axis,
    // even where this point is exact (a plane through the origin).
    s.position_error += 5e-7 * max_component(max(abs(position), max(abs(p0 - position), max(abs(p1 - position), abs(p2 - position)))));

    // A mirroring transform turns the order of the corners over; the front side stays the front side.
    const float winding = (instance.flags & kInstanceFlipsFacing) != 0u ? -1.0 : 1.0;
    precise const vec3 e1_ws = p1 - p0, e2_ws = p2 - p0;
    precise const vec3 normal = precise_cross(e1_ws, e2_ws) * winding;
    s.double_area_ws = sqrt(precise_dot(normal, normal));
    s.extent_ws = sqrt(max(precise_dot(e1_ws, e1_ws), precise_dot(e2_ws, e2_ws)));
    s.n_geometric_ws = s.double_area_ws > 0.0 ? normal / s.double_area_ws : -ray.direction_ws;
    s.front_facing = precise_dot(s.n_geometric_ws, ray.direction_ws) < 0.0;
    // What is opaque is left on the side from where it is seen.
    const float height = proxy_height(geometry, hit.primitive, s.front_facing, world_from_object, s.n_geometric_ws);
    if (height > 0.0) s.position_error += height * abs(s.n_geometric_ws);

    AttributeArray attributes = AttributeArray(geometry.attributes);
    const VertexAttributes a0 = attributes.v[index.x], a1 = attributes.v[index.y], a2 = attributes.v[index.z];
    const vec2 uv0 = interpolate(weights, a0.uv0, a1.uv0, a2.uv0), uv1 = interpolate(weights, a0.uv1, a1.uv1, a2.uv1);
    TextureFootprint footprint = kFullResolution;
    if (has_cone(cone)) {
        const float width = cone_width(cone, s.t), cosine = dot(s.n_geometric_ws, ray.direction_ws);
        footprint = TextureFootprint(true, vec2(cone_level(double_area_uv(a0.uv0, a1.uv0, a2.uv0), s.double_area_ws, width, cosine),
                                                cone_level(double_area_uv(a0.uv1, a1.uv1, a2.uv1), s.double_area_ws, width, cosine)));
    }
    s.n_shading_ws = vertex_normal(instance, interpolate(weights, a0.normal, a1.normal, a2.normal), s.n_geometric_ws, before);
    const vec3 tangent = transform_vector(world_from_object, interpolate(weights, a0.tangent.xyz, a1.tangent.xyz, a2.tangent.xyz));
    const TexturePoint at = TexturePoint(uv0, uv1, footprint);
    const vec3 n_vertex_ws = s.n_shading_ws;
    const vec4 tangent_ws = vec4(tangent, a0.tangent.w * winding);
    s.n_shading_ws = apply_normal_map(material.normal_texture, material.normal_scale, at, n_vertex_ws, tangent_ws);

    const vec3 vertex_color = interpolate(weights, unpackUnorm4x8(a0.color).rgb, unpackUnorm4x8(a1.color).rgb, unpackUnorm4x8(a2.color).rgb);
    s.scattering.base_color = material.base_color.rgb * vertex_color * fetch_texture(material.base_color_texture, at).rgb;
    const vec4 metal_rough = fetch_texture(material.metal_rough_texture, at);
    s.scattering.metallic = clamp(material.metallic * metal_rough.b, 0.0, 1.0);
    s.scattering.roughness = clamp(material.roughness * metal_rough.g, 0.0, 1.0);
    s.scattering.ior = material.ior;
    s.scattering.specular = material.specular * fetch_texture(material.specular_texture, at).a;
    s.scattering.specular_color = material.specular_color * fetch_texture(material.specular_color_texture, at).rgb;
    if (kLayers) fetch_layers(material, at, n_vertex_ws, tangent_ws, s);
    const bool emits = s.front_facing || (material.flags & kMaterialDoubleSided) != 0u;
    s.emission = emits ? material.emission * fetch_texture(material.emissive_texture, at).rgb * emission_through_coat(material, at, n_vertex_ws, ray.direction_ws) : vec3(0.0);
    if ((material.flags & kMaterialUnlit) != 0u) {  // shown as it is, not lit (KHR_materials_unlit); no light to sample, paths that meet it see it
        s.emission = s.scattering.base_color;
        s.scattering.base_color = vec3(0.0);
        s.scattering.specular = 0.0;
        s.scattering.metallic = 0.0;
    }
    return s;
}

Surface fetch_surface(Hit hit, Ray ray, RayCone cone) { return fetch_surface_at(hit, ray, cone, kNow); }

// A ray from the surface towards w that cannot meet the surface itself (with integer_offset: seldom).
Ray spawn_ray(Surface s, vec3 w, float t_max, uint alpha_key) {
    const vec3 origin = s.integer_offset ? offset_origin_integer(s.position_ws, s.n_geometric_ws, w) : offset_origin(s.position_ws, s.position_error, s.n_geometric_ws, w);
    return Ray(origin, 0.0, w, t_max, alpha_key);
}
#endif
