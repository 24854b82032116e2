// Light selection and sampling. A light id is (emitter, triangle); every density below includes the probability of the choice.
//     LightPick   pick_light(x, n, u)          which light
//     LightSample sample_light(pick, x, u)     a point or direction on it
//     float       pdf_light(...)               density with which the same light would have been sampled (MIS)
#ifndef PARHELION_SCENE_LIGHTS_GLSL
#define PARHELION_SCENE_LIGHTS_GLSL
#include "scene/alpha.glsl"
#include "scene/environment.glsl"
#include "scene/surface.glsl"

struct LightPick {
    uint emitter;       // kNone: there is no light
    uint triangle;
    float probability;  // of this emitter and triangle together
};

struct LightSample {
    vec3 wi;            // from the shaded point to the light, unit
    vec3 target_ws;     // point to which the light must be visible (finite lights)
    vec3 radiance;      // nits arriving along wi if visible; for delta lights irradiance on a facing surface, lux
    float pdf;          // per solid angle; for delta lights the probability of the choice
    bool infinite;
    bool is_delta;
};

const LightSample kNoLightSample = LightSample(vec3(0.0), vec3(0.0), vec3(0.0), 0.0, false, false);

// With which pick_light() returns this light.
float pick_probability(uint emitter, uint triangle) {
    const Emitter e = scene_emitter(emitter);
    float probability = alias_pmf(scene.header.emitter_table, emitter);
    if (e.kind == kEmitterMesh) probability *= alias_pmf(scene.header.triangle_tables + uint64_t(e.triangle_table) * 12ul, triangle);
    return probability;
}

// x_ws and n_ws are not used yet: emitters are chosen by their share of the emitted flux, infinite ones by a set share.
LightPick pick_light(vec3 x_ws, vec3 n_ws, vec4 u) {
    LightPick pick = LightPick(kNone, 0u, 0.0);
    if (scene.header.emitter_count == 0u) return pick;
    pick.emitter = sample_alias(scene.header.emitter_table, scene.header.emitter_count, u.xy);
    pick.probability = alias_pmf(scene.header.emitter_table, pick.emitter);
    const Emitter emitter = scene_emitter(pick.emitter);
    if (emitter.kind == kEmitterMesh) {
        const uint64_t table = scene.header.triangle_tables + uint64_t(emitter.triangle_table) * 12ul;
        pick.triangle = sample_alias(table, emitter.triangle_count, u.zw);
        pick.probability *= alias_pmf(table, pick.triangle);
    }
    return pick;
}

// Density per area of choosing a point on a triangle of an emissive mesh.
float pdf_light_area(uint emitter, uint triangle, float double_area_ws) {
    const uint64_t table = scene.header.triangle_tables + uint64_t(scene_emitter(emitter).triangle_table) * 12ul;
    return alias_pmf(scene.header.emitter_table, emitter) * alias_pmf(table, triangle) * 2.0 / max(double_area_ws, 1e-30);
}

// Density per solid angle with which a light hit by a ray (a surface s, `distance` metres along wi from the shaded point) would have
// been sampled.
float pdf_light(uint emitter, Surface s, float distance, vec3 wi) {
    const float cosine = abs(dot(s.n_geometric_ws, wi));
    return cosine > 0.0 ? pdf_light_area(emitter, s.primitive, s.double_area_ws) * distance * distance / cosine : 0.0;
}
float pdf_light_environment(vec3 wi) {
    return alias_pmf(scene.header.emitter_table, scene.header.environment.emitter) * pdf_environment_solid_angle(wi);
}
// A sun: a directional light whose disk has an extent. Illuminance E on a surface that faces a disk of radiance L and angular
// radius a is pi sin^2(a) L.
vec3 sun_radiance(Emitter sun) { return sun.intensity / (kPi * sun.opening * (2.0 - sun.opening)); }
// 1 - cos of the angle to the disk's middle, by the chord: as small as the sun's is, the cosine alone would have no digits left.
bool in_sun(Emitter sun, vec3 d) {
    const vec3 chord = d + sun.direction_ws;
    return dot(chord, chord) <= 2.0 * sun.opening;
}
float pdf_light_sun(uint emitter, Emitter sun) { return alias_pmf(scene.header.emitter_table, emitter) * pdf_cone_solid_angle(sun.opening); }

uint surface_emitter(Surface s) {
    return UintArray(scene.header.geometry_emitters).v[scene_instance(s.instance).emitter_base + s.geometry];
}

// A point of an emissive triangle, chosen uniformly.
struct LightPoint {
    vec3 position_ws, position_error;
    vec3 normal;  // twice the triangle's area long, on the front side
    float double_area_ws;
    vec3 weights;
};

LightPoint point_on_mesh(LightPick pick, Instance instance, Geometry geometry, vec2 u) {
    LightPoint point;
    const uvec3 index = IndexArray(geometry.indices).v[pick.triangle];
    PositionArray positions = PositionArray(geometry.positions);
    vec3 e0, e1, e2;
    const vec3 p0 = transform_point_precise(instance.world_from_object, positions.v[index.x], vec3(0.0), e0);
    const vec3 p1 = transform_point_precise(instance.world_from_object, positions.v[index.y], vec3(0.0), e1);
    const vec3 p2 = transform_point_precise(instance.world_from_object, positions.v[index.z], vec3(0.0), e2);
    const vec2 barycentrics = sample_triangle(u);
    point.weights = vec3(1.0 - barycentrics.x - barycentrics.y, barycentrics);
    point.position_ws = interpolate(point.weights, p0, p1, p2);
    point.position_error = 1e-6 * max_component(abs(p0) + abs(p1) + abs(p2)) + max(e0, max(e1, e2));
    point.normal = cross(p1 - p0, p2 - p0) * ((instance.flags & kInstanceFlipsFacing) != 0u ? -1.0 : 1.0);
    point.double_area_ws = length(point.normal);
    return point;
}

// Nits of the point along w (unit, to it); without a direction (0) what shines below a clear coat.
vec3 radiance_on_mesh(LightPick pick, LightPoint point, Instance instance, Geometry geometry, Material material, vec3 w) {
    const uvec3 index = IndexArray(geometry.indices).v[pick.triangle];
    const vec3 weights = point.weights;
    AttributeArray attributes = AttributeArray(geometry.attributes);
    const VertexAttributes a0 = attributes.v[index.x], a1 = attributes.v[index.y], a2 = attributes.v[index.z];
    const TexturePoint at = TexturePoint(interpolate(weights, a0.uv0, a1.uv0, a2.uv0), interpolate(weights, a0.uv1, a1.uv1, a2.uv1), kFullResolution);
    vec3 radiance = material.emission * fetch_texture(material.emissive_texture, at).rgb;
    if (kLayers && (material.flags & kMaterialCoated) != 0u && w != vec3(0.0))
        radiance *= emission_through_coat(material, at, vertex_normal(instance, interpolate(weights, a0.normal, a1.normal, a2.normal), point.normal / point.double_area_ws), w);
    if ((geometry.flags & kAlphaModeMask) != kAlphaOpaque) {
        const float alpha = fetch_alpha(geometry, pick.triangle, weights.yz);
        radiance *= (geometry.flags & kAlphaModeMask) == kAlphaBlend ? alpha : float(alpha >= material.alpha_cutoff);
    }
    return radiance;
}

LightSample sample_mesh_light(LightPick pick, Emitter emitter, vec3 x_ws, vec2 u) {
    LightSample result = kNoLightSample;
    const Instance instance = scene_instance(emitter.instance);
    const Geometry geometry = scene_geometry(emitter.geometry);
    const Material material = scene_material(geometry.material);
    const LightPoint point = point_on_mesh(pick, instance, geometry, u);
    const vec3 to_light = point.position_ws - x_ws;
    const float distance_squared = dot(to_light, to_light);
    if (point.double_area_ws <= 0.0 || distance_squared <= 0.0) return result;
    result.wi = to_light * inversesqrt(distance_squared);
    const float cosine = -dot(point.normal, result.wi) / point.double_area_ws;
    if (cosine <= 0.0 && (material.flags & kMaterialDoubleSided) == 0u) return result;
    if (abs(cosine) < 1e-7) return result;
    result.radiance = radiance_on_mesh(pick, point, instance, geometry, material, result.wi);
    result.target_ws = offset_origin(point.position_ws, point.position_error, point.normal / point.double_area_ws, -result.wi);
    result.pdf = pick.probability * 2.0 / point.double_area_ws * distance_squared / abs(cosine);
    return result;
}

LightSample sample_sun(LightPick pick, Emitter sun, vec2 u) {
    LightSample result = kNoLightSample;
    result.infinite = true;
    result.wi = normalize(make_frame(-sun.direction_ws) * sample_cone(u, sun.opening));
    result.radiance = sun_radiance(sun);
    result.pdf = pick.probability * pdf_cone_solid_angle(sun.opening);
    return result;
}

// Point and spot: intensity over squared distance; the spot's cone as KHR_lights_punctual defines it.
LightSample sample_punctual_light(LightPick pick, Emitter emitter, vec3 x_ws) {
    LightSample result = kNoLightSample;
    result.is_delta = true;
    result.pdf = pick.probability;
    if (emitter.kind == kEmitterDirectional) {
        result.infinite = true;
        result.wi = -emitter.direction_ws;
        result.radiance = emitter.intensity;
        return result;
    }
    const vec3 to_light = emitter.position_ws - x_ws;
    const float distance_squared = max(dot(to_light, to_light), 1e-12);
    result.wi = to_light * inversesqrt(distance_squared);
    result.target_ws = emitter.position_ws;
    result.radiance = emitter.intensity / distance_squared;
    if (emitter.kind == kEmitterSpot) {
        const float scale = 1.0 / max(0.001, emitter.cos_inner - emitter.cos_outer);
        const float fall = clamp((dot(emitter.direction_ws, -result.wi) - emitter.cos_outer) * scale, 0.0, 1.0);
        result.radiance *= fall * fall;
    }
    return result;
}

LightSample sample_light(LightPick pick, vec3 x_ws, vec4 u) {
    if (pick.emitter == kNone) return kNoLightSample;
    const Emitter emitter = scene_emitter(pick.emitter);
    if (emitter.kind == kEmitterMesh) return sample_mesh_light(pick, emitter, x_ws, u.xy);
    if (emitter.kind == kEmitterDirectional && emitter.opening > 0.0) return sample_sun(pick, emitter, u.xy);
    if (emitter.kind != kEmitterEnvironment) return sample_punctual_light(pick, emitter, x_ws);
    LightSample result = kNoLightSample;
    result.infinite = true;
    result.wi = sample_environment(u, result.pdf);
    result.pdf *= pick.probability;
    result.radiance = environment_radiance(result.wi);
    return result;
}
#endif
