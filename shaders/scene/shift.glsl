// What a reservoir's sample brings to a surface: the reconnection of a path at the point after its first surface (Ouyang et al. 2021), or the
// same light seen from elsewhere. A contribution is taken in the measure of the sample's kind (shared/reservoir.h), so points carry their
// geometry term and nothing else changes from surface to surface.
#ifndef PARHELION_SCENE_SHIFT_GLSL
#define PARHELION_SCENE_SHIFT_GLSL
#include "lib/reservoir.glsl"
#include "scene/receiver.glsl"

struct Shifted {
    BsdfValue value;  // nits, times the sample's measure, without what hides it
    Ray ray;          // has to be free for it,
    bool passes;      // but for panes
};

const Shifted kNothingShifted = Shifted(kNoBsdfValue, Ray(vec3(0.0), 0.0, vec3(0.0, 0.0, 1.0), 0.0, 0u), false);

float target_of(Shifted shifted) { return luminance(total(shifted.value)); }

bool was_drawn_as_light(uint kind) { return kind == kSampleLight || kind == kSampleSky; }

// A sample that was drawn as a light. `density`: of it in the measure of its kind.
LightSample light_of(LightSampleRef y, vec3 x_ws, out float density) {
    if (y.kind == kSampleLight) {
        density = pick_probability(y.reference, y.number);
        return sample_light(LightPick(y.reference, y.number, density), x_ws, vec4(unpack_place(y.place), 0.0, 0.0));
    }
    LightSample light = kNoLightSample;
    light.infinite = true;
    light.wi = y.direction;
    light.radiance = environment_radiance(light.wi);
    light.pdf = density = pdf_light_environment(light.wi);
    return light;
}

// The way to a point, and the normal of its triangle, twice its area long. False: it is too near.
bool find_point(LightSampleRef y, vec3 from_ws, uint moment, out vec3 way, out vec3 normal) {
    const Instance instance = scene_instance(y.reference);
    const Geometry geometry = scene_geometry((moment == kBefore ? geometry_base_before(y.reference) : instance.geometry_base) + y.geometry);
    const uvec3 index = IndexArray(geometry.indices).v[y.number];
    PositionArray positions = PositionArray(geometry.positions);
    Affine placement = instance.world_from_object;
    if (moment == kBefore) placement = placement_before(y.reference);
    vec3 ignored;
    const vec3 p0 = transform_point_precise(placement, positions.v[index.x], vec3(0.0), ignored);
    const vec3 p1 = transform_point_precise(placement, positions.v[index.y], vec3(0.0), ignored);
    const vec3 p2 = transform_point_precise(placement, positions.v[index.z], vec3(0.0), ignored);
    const vec2 b = unpack_barycentrics(y.place);
    way = interpolate(vec3(1.0 - b.x - b.y, b), p0, p1, p2) - from_ws;
    const vec3 e1 = p1 - p0, e2 = p2 - p0;
    normal = cross(e1, e2);
    return !is_too_near(dot(way, way), sqrt(max(dot(e1, e1), dot(e2, e2))));
}

// Radiance that leaves a point towards where the path's ray came from.
vec3 leaving_point(ViewData view, LightSampleRef y, PathState path, Surface s) {
    if (y.kind == kSampleEmitter) return arriving_emission(path, s, view.light_sampling);
    if (s.front_facing != ((y.flags & kSampleFront) != 0u)) return vec3(0.0);
    if (y.kind == kSampleRadiosity) return y.radiance;
    const Shading there = make_shading(view, path, s, MediumBoundary(path.media, true, s.scattering.ior));
    const vec3 wi = y.direction * there.frame;
    if (!sides_agree(there, wi, y.direction)) return vec3(0.0);
    BsdfValue value = shared_value(evaluate_bsdf(there.bsdf, there.outgoing, wi).value, is_rough(s));
    if ((y.flags & kSampleGlossy) != 0u) value.diffuse = vec3(0.0);
    return total(value) * y.radiance;
}

// The same, times its geometry term; the ray ends there.
vec3 arriving_from_point(ViewData view, LightSampleRef y, PathState path, float squared_distance, uint moment, inout Ray ray) {
    const Surface s = fetch_surface_at(Hit(y.reference, y.geometry, y.number, 0u, 0.0), ray, kNoCone, moment);
    const vec3 target = offset_origin(s.position_ws, s.position_error, s.n_geometric_ws, -ray.direction_ws), way = target - ray.origin_ws;
    const vec3 radiance = leaving_point(view, y, path, s) * (abs(dot(s.n_geometric_ws, ray.direction_ws)) / squared_distance);
    ray.t_max = length(way) * (1.0 - 4e-7);
    ray.direction_ws = normalize(way);
    return radiance;
}

// The share of its light that a sample had at that moment. What a path found behind its second vertex counts as it is now, and so do
// suns that it met.
float shone(LightSampleRef y, uint moment) {
    if (moment == kNow) return 1.0;
    if (was_drawn_as_light(y.kind)) return lit_before(y.reference);
    if (y.kind == kSampleOutside) return lit_before(scene.header.environment.emitter);
    if (y.kind != kSampleEmitter) return 1.0;
    return lit_before(UintArray(scene.header.geometry_emitters).v[scene_instance(y.reference).emitter_base + y.geometry]);
}

// The key of each ray that a pixel sends to a sample in a frame: that of the ray by which its own path would have found it. What is blended so hides
// a sample from a pixel in all steps of the frame or in none. Were it drawn anew in each, a sample that half of the rays meet would be weighed as
// seen and then be hidden half of the time.
uint sample_ray_key(PathKey key, uint kind) {
    const bool of_lights = kind == kSampleLight || kind == kSampleSky;
    return of_lights ? alpha_key(key, 0u, kRayShadow) : alpha_key(key, 1u, kRayPath);
}

// The sample at a surface, as the scene stands or stood.
Shifted shift(ViewData view, LightSampleRef y, Receiver to, uint moment, uint alpha_key) {
    Shifted result = kNothingShifted;
    if (y.kind == kSampleNone) return result;
    LightSample light;
    vec3 wi_ws = y.direction;
    float density = 1.0, squared_distance = 1.0;
    result.passes = was_drawn_as_light(y.kind);
    if (result.passes) {
        light = light_of(y, to.shading.s.position_ws, density);
        if (light.pdf <= 0.0 || density <= 0.0) return result;
        wi_ws = light.wi;
    } else if (y.kind != kSampleOutside) {
        vec3 way, normal;
        if (!find_point(y, to.shading.s.position_ws, moment, way, normal)) return result;
        squared_distance = dot(way, way);
        wi_ws = way * inversesqrt(squared_distance);
    }
    const vec3 wi = wi_ws * to.shading.frame;
    if (!sides_agree(to.shading, wi, wi_ws)) return result;
    const BsdfTerms terms = evaluate_bsdf(to.shading.bsdf, to.shading.outgoing, wi);
    const BsdfValue value = shared_value(terms.value, to.rough);
    if (max_component(total(value)) <= 0.0) return result;
    PathState path = to.path;
    path.pdf = terms.pdf * to.bsdf_share;
    result.ray = path.ray = spawn_ray(to.shading.s, wi_ws, kInfinity, alpha_key);
    vec3 arriving;
    if (result.passes) {
        arriving = light.radiance * (light_sample_weight(view.light_sampling, light, path.pdf) * density / light.pdf);
        result.ray = light_sample_ray(to.shading.s, light, alpha_key);
    } else if (y.kind == kSampleOutside) arriving = arriving_environment(path, view.light_sampling) + arriving_suns(path, view.light_sampling);
    else arriving = arriving_from_point(view, y, path, squared_distance, moment, result.ray);
    result.value = scale(value, arriving * shone(y, moment));
    return result;
}
#endif
