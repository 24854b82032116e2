// The irradiance at a point of the world cache, one sample: light by resampled importance sampling, what comes by way of other surfaces
// by one ray that ends in the cache. One choice among all candidates for direct light, N points of lights and the one direction that the
// ray takes: Talbot, Cline, Egbert 2005, "Importance Resampling for Global Illumination", their weights by the balance heuristic (Veach
// and Guibas 1995), so that each light is counted once whichever way finds it.
#ifndef PARHELION_SCENE_CACHE_LIGHT_GLSL
#define PARHELION_SCENE_CACHE_LIGHT_GLSL
#include "scene/cache.glsl"
#include "scene/trace_light.glsl"
#include "scene/vertex.glsl"

const uint kCacheVertices = 4u;     // of a path that are lit by lights, before it must end in the cache
const uint kCacheScatterings = 4u;  // of a ray by lobes that are not diffuse, before it is given up

struct CacheSeed {
    uint64_t key;
    uint frame_index, seed, next;
};
vec4 cache_numbers(inout CacheSeed s) {
    const uvec4 h = cache_random(s.key, s.frame_index, s.seed, kCacheForPaths + s.next);
    s.next += 1u;
    return vec4(uint_to_unit_float(h.x), uint_to_unit_float(h.y), uint_to_unit_float(h.z), uint_to_unit_float(h.w));
}

// The candidate that was chosen so far.
struct CacheChoice {
    vec3 value;    // radiance times cosine
    float target;  // its luminance: what it was chosen by
    float sum;     // of all candidates' weights
    Ray ray;       // that must be free; t_max < 0: it is known to be
};

// inverse_density: one over the sum over techniques of how often each offers this candidate.
void cache_offer(inout CacheChoice choice, vec3 value, float inverse_density, Ray ray, float u) {
    const float target = luminance(value), weight = target * inverse_density;
    if (!(weight > 0.0)) return;
    choice.sum += weight;
    if (u * choice.sum >= weight) return;
    choice.value = value;
    choice.target = target;
    choice.ray = ray;
}
void cache_offer_seen(inout CacheChoice choice, vec3 value, float inverse_density, float u) {
    Ray none;
    none.t_max = -1.0;
    cache_offer(choice, value, inverse_density, none, u);
}

float cache_inverse_density(uint candidates, float light_pdf, float direction_pdf) { return 1.0 / max(float(candidates) * light_pdf + direction_pdf, 1e-30); }

void cache_offer_light(inout CacheChoice choice, vec3 origin_ws, vec3 n, uint candidates, uint alpha_key, inout CacheSeed seed) {
    const vec4 u_pick = cache_numbers(seed), u_light = cache_numbers(seed);
    const float u = cache_numbers(seed).x;
    const LightSample light = sample_light(pick_light(origin_ws, n, u_pick), origin_ws, u_light);
    const float cosine = dot(light.wi, n);
    if (light.pdf <= 0.0 || cosine <= 0.0) return;
    Ray ray = Ray(origin_ws, 0.0, light.wi, kInfinity, alpha_key);
    if (!light.infinite) {
        const vec3 to_target = light.target_ws - origin_ws;
        ray.t_max = length(to_target) * (1.0 - 4e-7);
        ray.direction_ws = normalize(to_target);
    }
    cache_offer(choice, light.radiance * cosine, cache_inverse_density(candidates, light.pdf, light.is_delta ? 0.0 : pdf_cosine_hemisphere_solid_angle(cosine)), ray, u);
}

// Where a path stands that began at a cell.
struct CachePath {
    PathState path;
    float cosine;     // of its first direction
    float way;        // metres since then
    uint scatterings;
    vec3 found;       // irradiance that it brought so far, without what is left to the choice
    float steady;     // what an answer of the cache must be worth to end it
    bool unknown;     // it met a diffuse surface of which the cache knows less:
    vec3 next_origin_ws, next_n, next_share;
};

// Light that the path's ray brings from a light that N light samples offer with light_pdf.
void cache_arrive(inout CachePath p, inout CacheChoice choice, vec3 radiance, uint candidates, float light_pdf, inout CacheSeed seed) {
    if (max_component(radiance) <= 0.0) return;
    if (p.scatterings == 0u) cache_offer_seen(choice, p.path.throughput * radiance * p.cosine, cache_inverse_density(candidates, light_pdf, p.path.pdf), cache_numbers(seed).x);
    else p.found += kPi * p.path.throughput * radiance;  // no light sample was drawn where it was scattered last
}

void cache_arrive_sky(inout CachePath p, inout CacheChoice choice, uint candidates, inout CacheSeed seed) {
    if (kLayers) p.path.throughput *= medium_transmittance(medium_there(p.path.media), kInfinity);
    const vec3 d = p.path.ray.direction_ws;
    if (scene.header.environment.emitter != kNone) cache_arrive(p, choice, environment_radiance(d), candidates, pdf_light_environment(d), seed);
    for (uint i = 0u; i < scene.header.sun_count; ++i) {
        const uint emitter = UintArray(scene.header.suns).v[i];
        const Emitter sun = scene_emitter(emitter);
        if (in_sun(sun, d)) cache_arrive(p, choice, sun_radiance(sun), candidates, pdf_light_sun(emitter, sun), seed);
    }
}

// What of the irradiance at a surface leaves it towards wo, as radiance times pi. Exact where light comes alike from everywhere; of
// layered surfaces one sample of it.
vec3 cache_diffuse_albedo(Shading shading, BsdfSample drawn) {
#ifdef LAYERS
    if (is_layered(shading.bsdf) || has_glass(shading.bsdf)) return drawn.weight.diffuse;
#endif
    return diffuse_albedo(shading.bsdf.base, glossy_table(shading.bsdf.base, shading.wo.z, shading.bsdf.tables));
}

// The diffuse part of a hit ends in the cache, or waits for a vertex of its own; false if the rest of it is given up.
bool cache_meet(Cache cache, ViewData view, inout CachePath p, Surface s, MediumBoundary boundary, float cell_size, uint life, inout CacheSeed seed) {
    const Shading shading = make_shading(view, p.path, s, boundary);
    const vec4 u_bsdf = cache_numbers(seed), u = cache_numbers(seed);
    const BsdfSample drawn = sample_bsdf(shading.bsdf, shading.wo, u_bsdf.x, u_bsdf.yz);
    const vec3 share = p.path.throughput * cache_diffuse_albedo(shading, drawn), wo_ws = -p.path.ray.direction_ws;
    if (max_component(share) > 0.0) {
        // What lights a cell is as coarse as it, and coarser the farther it is.
        const CachePoint at = cache_point(s, wo_ws, max(s.t, cell_size / cache.v.cell_scale), u.x);
        const CacheAnswer answer = cache_consult(cache, at, life);
        if (answer.count >= p.steady || p.unknown) p.found += share * answer.irradiance / cache.v.exposure;
        else {
            p.unknown = true;
            p.next_origin_ws = at.origin_ws;
            p.next_n = at.n_geometric_ws;
            p.next_share = share;
        }
    }
    const vec3 wi_ws = shading.frame * drawn.wi;
    if (drawn.lobe == kLobeNone || p.scatterings >= kCacheScatterings || !sides_agree(shading, drawn.wi, wi_ws)) return false;
    p.path.throughput *= drawn.weight.specular + drawn.weight.transmission;
    const float survival = min(max_component(p.path.throughput), 1.0);
    if (u.y >= survival) return false;
    p.path.throughput /= survival;
    p.scatterings += 1u;
    p.path.travelled = 0.0;
    p.path.ray = spawn_ray(s, normalize(wi_ws), kInfinity, p.path.ray.alpha_key + 1u);
    if (kLayers) p.path.media = media_behind(p.path, shading, drawn.wi);
    return true;
}

// Follows the path until its last ray has ended.
void cache_follow(Cache cache, ViewData view, inout CachePath p, inout CacheChoice choice, float cell_size, uint life, inout CacheSeed seed) {
    const uint kMostRays = 32u;  // panes and boundaries that are none cost a ray, and no scattering
    for (uint i = 0u; i < kMostRays; ++i) {
        note_ray(p.path.ray, kRayPath);
        const Hit hit = trace_closest(p.path.ray);
        if (is_miss(hit)) {
            cache_arrive_sky(p, choice, cache.v.candidates, seed);
            return;
        }
        Surface s = fetch_surface(hit, p.path.ray, kNoCone);
        s.integer_offset = (view.flags & kViewIntegerOffset) != 0u;
        if (kLayers) p.path.throughput *= medium_transmittance(medium_there(p.path.media), s.t);
        p.way += s.t;
        if (s.emission != vec3(0.0)) {
            const uint emitter = surface_emitter(s);
            const float light_pdf = emitter == kNone ? 0.0 : pdf_light(emitter, s, p.path.travelled + s.t, p.path.ray.direction_ws);
            cache_arrive(p, choice, s.emission, cache.v.candidates, light_pdf, seed);
        }
        MediumBoundary boundary = MediumBoundary(p.path.media, true, s.scattering.ior);
        if (kLayers && s.scattering.transmission > 0.0 && !s.scattering.thin) boundary = cross_boundary(p.path.media, s.material, s.front_facing);
        if (!boundary.real) {
            pass_surface(p.path, s);
            p.path.media = boundary.beyond;
            continue;
        }
        if (kLayers && is_pane(s.scattering) && pass_pane(view, p.path, s)) continue;
        if (!cache_meet(cache, view, p, s, boundary, cell_size, life, seed)) return;
    }
}

// Irradiance at a point, nits times steradians before exposure. A path goes on, lit at each vertex like at the first, while it meets
// surfaces that the cache does not know well: cells that light each other come to rest soon, after their birth and after a change.
vec3 cache_sample_irradiance(Cache cache, ViewData view, vec3 origin_ws, vec3 n, float cell_size, uint life, inout CacheSeed seed) {
    vec3 sum = vec3(0.0), share = vec3(1.0);
    for (uint vertex = 0u; vertex < kCacheVertices; ++vertex) {
        const uint key = hash_combine(hash_combine(uint(seed.key), seed.frame_index), vertex);
        CacheChoice choice;
        choice.sum = 0.0;
        for (uint i = 0u; i < cache.v.candidates; ++i) cache_offer_light(choice, origin_ws, n, cache.v.candidates, hash_combine(key, kRayShadow), seed);
        const vec3 wi = sample_cosine_hemisphere(cache_numbers(seed).xy);
        CachePath p;
        p.path.ray = Ray(origin_ws, 0.0, normalize(make_frame(n) * wi), kInfinity, hash_combine(key, kRayPath));
        p.path.throughput = vec3(1.0);
        p.path.pdf = pdf_cosine_hemisphere_solid_angle(wi.z);
        p.path.travelled = 0.0;
        p.path.radiance_scale = 1.0;
        p.path.path_class = PathClass(1u, false, vec3(0.0));
        p.path.cone = kNoCone;
        p.path.media = make_medium_stack();
        p.cosine = wi.z;
        p.way = 0.0;
        p.scatterings = 0u;
        p.found = vec3(0.0);
        p.steady = vertex + 1u < kCacheVertices ? float(kCacheSteady) : 0.0;
        p.unknown = false;
        cache_follow(cache, view, p, choice, cell_size, life, seed);
        sum += share * p.found;
        if (choice.sum > 0.0) {
            const vec3 passing = choice.ray.t_max < 0.0 ? vec3(1.0) : trace_light(view, choice.ray);
            sum += share * passing * choice.value * (choice.sum / choice.target);
        }
        if (!p.unknown) break;
        origin_ws = p.next_origin_ws;
        n = p.next_n;
        share *= p.next_share;
    }
    return sum;
}
#endif
