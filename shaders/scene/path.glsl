// The path tracer's loop body, one place for every renderer: emission and its MIS weight, next event estimation, BSDF sample.
// Document 002, with its defects mended: shadow rays are traced by the caller of the hit, the sampler is fixed per pixel,
// emission is weighted whatever surface was passed, ray origins move by error bounds.
#ifndef PARHELION_SCENE_PATH_GLSL
#define PARHELION_SCENE_PATH_GLSL
#include "lib/mis.glsl"
#include "lib/sampler.glsl"
#include "scene/camera.glsl"
#include "scene/lights.glsl"

const uint kLightSamplingMis = 0u;
const uint kLightSamplingOnly = 1u;
const uint kBsdfSamplingOnly = 2u;

// Random numbers of alpha tests: which ray asks.
const uint kRayPath = 0u;
const uint kRayShadow = 1u;

// Radiance by path class (docs/path-space.md); their sum is the beauty.
struct PathRadiance {
    vec3 emission, direct_diffuse, direct_specular, indirect_diffuse, indirect_specular, transmission;
};
PathRadiance make_path_radiance() { return PathRadiance(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0)); }
vec3 total(PathRadiance r) {
    return r.emission + r.direct_diffuse + r.direct_specular + r.indirect_diffuse + r.indirect_specular + r.transmission;
}

// First-hit values that are averaged over the pixel.
struct FirstHit {
    vec3 albedo, normal_ws, emission;
    float roughness;
};

struct PathState {
    Ray ray;
    vec3 throughput;
    float pdf;          // of the last BSDF sample per solid angle; < 0: the light could not have been sampled (camera ray)
    uint bounce;        // scatterings so far
    vec3 first_diffuse; // share of the throughput that the first scattering's diffuse lobe has; the rest is the specular one's
    bool transmitted;   // the first scattering went through the surface
    RayCone cone;       // how finely textures are read; of the ray
    PathRadiance radiance;
};

void add_indirect(inout PathState path, vec3 value) {
    path.radiance.indirect_diffuse += path.first_diffuse * value;
    path.radiance.indirect_specular += (1.0 - path.first_diffuse) * value;
}

// Adds radiance that arrives over the last BSDF sample (or straight from the camera) to its class.
void add_arriving(inout PathState path, vec3 value) {
    if (path.bounce == 0u) path.radiance.emission += value;
    else if (path.transmitted) path.radiance.transmission += value;
    else if (path.bounce == 1u) {
        path.radiance.direct_diffuse += path.first_diffuse * value;
        path.radiance.direct_specular += (1.0 - path.first_diffuse) * value;
    } else add_indirect(path, value);
}

// Adds light-sampled radiance, split by lobe at the current surface.
void add_sampled(inout PathState path, BsdfValue value) {
    if (path.transmitted) path.radiance.transmission += total(value);
    else if (path.bounce == 0u) {
        path.radiance.direct_diffuse += value.diffuse;
        path.radiance.direct_specular += value.specular;
        path.radiance.transmission += value.transmission;
    } else add_indirect(path, total(value));
}

// MIS weight of light reached by the last BSDF sample, which light sampling would have found with light_pdf.
float arriving_weight(PathState path, uint mode, float light_pdf) {
    if (path.pdf < 0.0 || light_pdf <= 0.0) return 1.0;
    if (mode == kLightSamplingOnly) return 0.0;
    return mode == kBsdfSamplingOnly ? 1.0 : mis_power_heuristic(path.pdf, light_pdf);
}

void add_environment(inout PathState path, uint mode) {
    const uint emitter = scene.header.environment.emitter;
    if (emitter == kNone) return;
    const float weight = path.pdf < 0.0 ? 1.0 : arriving_weight(path, mode, pdf_light_environment(path.ray.direction_ws));
    add_arriving(path, path.throughput * weight * environment_radiance(path.ray.direction_ws));
}

// The disks of suns that the ray meets.
void add_suns(inout PathState path, uint mode) {
    for (uint i = 0u; i < scene.header.sun_count; ++i) {
        const uint emitter = UintArray(scene.header.suns).v[i];
        const Emitter sun = scene_emitter(emitter);
        if (in_sun(sun, path.ray.direction_ws)) add_arriving(path, path.throughput * arriving_weight(path, mode, pdf_light_sun(emitter, sun)) * sun_radiance(sun));
    }
}

void add_emission(inout PathState path, Surface s, uint mode) {
    if (s.emission == vec3(0.0)) return;
    const uint emitter = surface_emitter(s);
    const float light_pdf = emitter == kNone || path.pdf < 0.0 ? 0.0 : pdf_light(emitter, s, path.ray.direction_ws);
    add_arriving(path, path.throughput * arriving_weight(path, mode, light_pdf) * s.emission);
}

// One light sample at the surface: its ray, and what it adds if the ray is free.
struct NextEvent {
    Ray ray;
    BsdfValue value;  // throughput included
    bool exists;
};

NextEvent sample_next_event(PathState path, Surface s, Bsdf bsdf, mat3 frame, vec3 wo, uint mode, vec4 u_pick, vec4 u_light, uint alpha_key) {
    NextEvent event;
    event.exists = false;
    const LightPick pick = pick_light(s.position_ws, s.n_geometric_ws, u_pick);
    const LightSample light = sample_light(pick, s.position_ws, u_light);
    if (light.pdf <= 0.0 || (mode == kBsdfSamplingOnly && !light.is_delta)) return event;  // no ray can hit a delta light
    const vec3 wi = light.wi * frame;
    const bool same_side = dot(light.wi, s.n_geometric_ws) * dot(path.ray.direction_ws, s.n_geometric_ws) < 0.0;
    if (!same_side) return event;
    const BsdfValue value = eval_bsdf(bsdf, wo, wi);
    float weight = 1.0;
    if (!light.is_delta && mode == kLightSamplingMis) weight = mis_power_heuristic(light.pdf, pdf_bsdf_solid_angle(bsdf, wo, wi));
    const vec3 arriving = path.throughput * light.radiance * (weight / light.pdf);
    event.value = BsdfValue(arriving * value.diffuse, arriving * value.specular, arriving * value.transmission);
    event.exists = max_component(total(event.value)) > 0.0;
    if (!event.exists) return event;
    event.ray = spawn_ray(s, light.wi, kInfinity, alpha_key);
    if (!light.infinite) {
        const vec3 to_target = light.target_ws - event.ray.origin_ws;
        event.ray.t_max = length(to_target) * (1.0 - 4e-7);
        event.ray.direction_ws = normalize(to_target);
    }
    return event;
}

// The variant RAY_CONES reads textures as finely as the path sees them (texture.lod=cone); without it cones cost nothing.
#ifdef RAY_CONES
RayCone first_cone(ViewData view) { return RayCone(view.pixel_width, view.pixel_spread); }
RayCone next_cone(RayCone cone, float t, uint lobe, Bsdf bsdf) { return scatter_cone(cone, t, lobe == kLobeDiffuse ? kWidestSpread : lobe_spread(bsdf.alpha)); }
#else
RayCone first_cone(ViewData view) { return kNoCone; }
RayCone next_cone(RayCone cone, float t, uint lobe, Bsdf bsdf) { return kNoCone; }
#endif

// Continues the path by the BSDF; false: it ends here.
bool scatter(inout PathState path, Surface s, Bsdf bsdf, mat3 frame, vec3 wo, float u_lobe, vec2 u, uint alpha_key) {
    const BsdfSample next = sample_bsdf(bsdf, wo, u_lobe, u);
    if (next.lobe == kLobeNone) return false;
    const vec3 wi_ws = frame * next.wi;
    // A direction that the shading normal allows but the real surface does not carries nothing.
    if (dot(wi_ws, s.n_geometric_ws) * dot(path.ray.direction_ws, s.n_geometric_ws) >= 0.0) return false;
    const vec3 weight = total(next.weight);
    if (path.bounce == 0u) {
        path.first_diffuse = next.weight.diffuse / max(weight, vec3(1e-30));
        path.transmitted = next.wi.z < 0.0;
    }
    path.throughput *= weight;
    path.pdf = next.pdf;
    path.bounce += 1u;
    path.ray = spawn_ray(s, normalize(wi_ws), kInfinity, alpha_key);
    path.cone = next_cone(path.cone, s.t, next.lobe, bsdf);
    return max_component(path.throughput) > 0.0;
}

// Russian roulette with survival in [0.05, 0.95] by the largest throughput; false: the path ends.
bool survive_roulette(inout PathState path, float u) {
    const float survival = clamp(max_component(path.throughput), 0.05, 0.95);
    if (u >= survival) return false;
    path.throughput /= survival;
    return true;
}

// Told of every ray before it is traced; the pass that includes this file defines it, to count or keep them.
void note_ray(Ray ray, uint kind);

// Both normals on the side of wo.
vec3 shading_normal(ViewData view, vec3 n_shading, vec3 n_geometric, vec3 wo) {
    return (view.flags & kViewNormalCorrection) != 0u ? bend_normal(n_shading, n_geometric, wo) : n_shading;
}

// One sample of one pixel.
PathRadiance trace_path(ViewData view, uvec2 pixel, uint sample_index, inout FirstHit first) {
    PathSampler samples = make_sampler(pixel, sample_index, view.seed, view.sampler_kind, scene.header.sobol, scene.header.blue_noise);
    PathState path;
    path.ray = sample_camera_ray(view, pixel, samples, hash_ray(pixel, sample_index, view.seed, 0u, kRayPath));
    path.throughput = vec3(1.0);
    path.pdf = -1.0;
    path.bounce = 0u;
    path.first_diffuse = vec3(0.0);
    path.transmitted = false;
    path.cone = first_cone(view);
    path.radiance = make_path_radiance();
    while (true) {
        note_ray(path.ray, kRayPath);
        const Hit hit = trace_closest(path.ray);
        if (is_miss(hit)) {
            add_environment(path, view.light_sampling);
            add_suns(path, view.light_sampling);
            if (path.bounce == 0u) first.emission = path.radiance.emission;
            break;
        }
        Surface s = fetch_surface(hit, path.ray, path.cone);
        s.integer_offset = (view.flags & kViewIntegerOffset) != 0u;
        add_emission(path, s, view.light_sampling);
        if (path.bounce == 0u) first = FirstHit(s.scattering.base_color, s.n_shading_ws * (s.front_facing ? 1.0 : -1.0), s.emission, s.scattering.roughness);
        if (path.bounce >= view.max_bounces) break;

        start_bounce(samples, path.bounce + 1u);
        const vec4 u_pick = vec4(next_2d(samples), next_2d(samples));
        const vec4 u_light = vec4(next_2d(samples), next_2d(samples));
        const float u_lobe = next_1d(samples);
        const vec2 u_direction = next_2d(samples);
        const float u_roulette = next_1d(samples);
        if (path.bounce >= view.roulette_start && !survive_roulette(path, u_roulette)) break;

        const float side = s.front_facing ? 1.0 : -1.0;
        const vec3 n = shading_normal(view, side * s.n_shading_ws, side * s.n_geometric_ws, -path.ray.direction_ws);
        const mat3 frame = make_frame(n);
        const vec3 wo = -path.ray.direction_ws * frame;
        const Bsdf bsdf = make_bsdf(s.scattering, vec3(0.0, 0.0, 1.0), (view.flags & kViewEnergyCompensation) != 0u, scene.header.bsdf_tables);
        const NextEvent event = sample_next_event(path, s, bsdf, frame, wo, view.light_sampling, u_pick, u_light,
                                                  hash_ray(pixel, sample_index, view.seed, path.bounce, kRayShadow));
        if (event.exists) {
            note_ray(event.ray, kRayShadow);
            if (trace_visible(event.ray, kNow)) add_sampled(path, event.value);
        }
        if (!scatter(path, s, bsdf, frame, wo, u_lobe, u_direction, hash_ray(pixel, sample_index, view.seed, path.bounce + 1u, kRayPath))) break;
    }
    return path.radiance;
}
#endif
