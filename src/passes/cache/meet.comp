#version 460
// What the updates' paths met: light that arrives, diffuse surfaces where they end in the cache, as the last frame left it, and lobes by
// which they go on.
// Reads: scene, view, hits. Reads and writes: cache (new cells and longer lives where rays end), lists, rays, paths, found.
// variants: LAYERS
#extension GL_GOOGLE_include_directive : require
#include "cache/update.glsl"
#include "scene/cache.glsl"
#include "scene/cache_share.glsl"

layout(local_size_x = kCacheGroup) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ViewBlock { ViewData data; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer CacheLists { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer CacheRays { WavefrontRay v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer CachePaths { CachePath v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer CacheHits { WavefrontHit v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer CacheUpdates { CacheUpdate v[]; };
layout(push_constant, scalar) uniform Push {
    ViewBlock view;
    Cache cache;
    CacheLists lists;
    CacheRays rays;
    CachePaths paths;
    CacheHits hits;
    CacheUpdates found;
    uint round;  // rays that the paths have traced, but for this one
    uint rounds;
} push;

shared uint on_count, first_place;

// Where an update stands.
struct Progress {
    CacheSource source;
    CacheUpdate update;
    PathState path;
    uint scatterings;
    uint next_number;
};

vec4 numbers(inout Progress p) {
    const uint which = kCacheOfRounds + push.round * kCacheRoundNumbers + p.next_number;
    p.next_number += 1u;
    return cache_numbers(push.cache, p.source, which);
}

// Light that the path's ray brings from a light that N light samples offer with light_pdf.
void arrive(inout Progress p, vec3 radiance, float light_pdf) {
    if (max_component(radiance) <= 0.0) return;
    if (p.scatterings != 0u) {
        p.update.found += kPi * p.path.throughput * radiance;  // no light sample was drawn where it was scattered last
        return;
    }
    const vec3 value = p.path.throughput * radiance * (kPi * p.path.pdf);
    const float target = luminance(value), weight = target * cache_inverse_density(push.cache.v.candidates, light_pdf, p.path.pdf);
    if (!(weight > 0.0)) return;
    p.update.sum += weight;
    if (numbers(p).x * p.update.sum >= weight) return;
    p.update.value = value;
    p.update.target = target;
    p.update.bits |= kCacheSeen;
}

void arrive_sky(inout Progress p) {
    if (kLayers) p.path.throughput *= medium_transmittance(medium_there(p.path.media), kInfinity);
    const vec3 d = p.path.ray.direction_ws;
    if (scene.header.environment.emitter != kNone) arrive(p, environment_radiance(d), pdf_light_environment(d));
    for (uint i = 0u; i < scene.header.sun_count; ++i) {
        const uint emitter = UintArray(scene.header.suns).v[i];
        const Emitter sun = scene_emitter(emitter);
        if (in_sun(sun, d)) arrive(p, sun_radiance(sun), pdf_light_sun(emitter, sun));
    }
}

// The diffuse part of a hit ends in the cache. A cell that is not steady yet gives what its own update finds in this frame, if there is
// one: young and changed cells are lit by paths, not by each other's past.
void end_in_cache(inout Progress p, uint index, Surface s, vec3 share, float u) {
    // What lights a cell is as coarse as it, and coarser the farther it is.
    const CachePoint at = cache_point(s, -p.path.ray.direction_ws, max(s.t, p.source.cell_size / push.cache.v.cell_scale), u);
    const CacheAnswer answer = cache_consult(push.cache, at, p.source.life);
    // Of a place that nobody knows yet, or that found no room: as bright as here. No light comes by this to where there was none. Dark, if what is known here is of before
    // a light was switched; what others know is of before, too, if they are not updated in this frame: then the sample is provisional.
    const bool known = answer.count > 0.0;
    CacheAnswer here = cache_read(push.cache, CacheWords(push.cache.v.updates).v[index]);
    if (push.cache.v.forgets != 0u) here.irradiance = vec3(0.0);
    const vec3 light = share * (known ? answer.irradiance : here.irradiance) / push.cache.v.exposure;
    uint link = kCacheNoSlot;
    if (answer.count < float(kCacheSteady) && answer.slot != kCacheNoSlot && p.update.link == kCacheNoSlot) link = cache_update_of(push.cache, answer.slot);
    if (link == kCacheNoSlot) {
        p.update.found += light;
        if (push.cache.v.forgets != 0u || (!known && here.count < 1.0)) p.update.bits |= kCacheUnknown;
    } else {
        p.update.link = link;
        p.update.share = share;
        p.update.otherwise = light;
    }
}

// False: the path ends here.
bool meet_surface(inout Progress p, uint index, Surface s, MediumBoundary boundary) {
    const Shading shading = make_shading(push.view.data, p.path, s, boundary);
    const vec4 u_bsdf = numbers(p), u = numbers(p);
    const BsdfSample drawn = sample_bsdf(shading.bsdf, shading.outgoing, u_bsdf.x, u_bsdf.yz);
    // From the second surface on all lobes count as diffuse ones, but for glass.
    const bool last = p.scatterings != 0u && may_end_in_cache(shading);
    const vec3 share = p.path.throughput * reflected_share(shading, drawn, last);
    if (max_component(share) > 0.0) end_in_cache(p, index, s, share, u.x);
    const vec3 wi_ws = shading.frame * drawn.wi;
    if (last || push.round + 1u == push.rounds || drawn.lobe == kLobeNone || !sides_agree(shading, drawn.wi, wi_ws)) return false;
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

bool meet(inout Progress p, uint index, WavefrontHit met) {
    if (met.instance_bits == kHitMiss) {
        arrive_sky(p);
        return false;
    }
    Surface s = fetch_surface(Hit(met.instance_bits, met.geometry, met.primitive, 0u, 0.0), p.path.ray, kNoCone);
    s.integer_offset = (push.view.data.flags & kViewIntegerOffset) != 0u;
    if (kLayers) p.path.throughput *= medium_transmittance(medium_there(p.path.media), s.t);
    if (s.emission != vec3(0.0)) {
        const uint emitter = surface_emitter(s);
        arrive(p, s.emission, emitter == kNone ? 0.0 : pdf_light(emitter, s, p.path.travelled + s.t, p.path.ray.direction_ws));
    }
    MediumBoundary boundary = MediumBoundary(p.path.media, true, s.scattering.ior);
    if (kLayers && s.scattering.transmission > 0.0 && !s.scattering.thin) boundary = cross_boundary(p.path.media, s.material, s.front_facing);
    const bool more = push.round + 1u < push.rounds;
    if (!boundary.real) {
        pass_surface(p.path, s);
        p.path.media = boundary.beyond;
        return more;
    }
    if (kLayers && is_pane(s.scattering) && pass_pane(push.view.data, p.path, s)) return more;
    return meet_surface(p, index, s, boundary);
}

PathState take_path(uint index) {
    const WavefrontRay ray = push.rays.v[index];
    const CachePath kept = push.paths.v[index];
    PathState path;
    path.ray = Ray(ray.origin_ws, 0.0, ray.direction_ws, kInfinity, ray.alpha_key);
    path.throughput = kept.throughput;
    path.pdf = kept.pdf;
    path.travelled = kept.travelled;
    path.radiance_scale = kept.radiance_scale;
    path.path_class = PathClass(1u, false, vec3(0.0));
    path.cone = kNoCone;
    path.media = MediumStack(kept.media);
    return path;
}

void keep_path(uint index, PathState path, uint scatterings) {
    push.rays.v[index] = WavefrontRay(path.ray.origin_ws, path.ray.alpha_key, path.ray.direction_ws, scatterings);
    push.paths.v[index] = CachePath(path.throughput, path.pdf, path.media.materials, path.travelled, path.radiance_scale);
}

// True: the path has a next ray.
bool step_on(uint index) {
    Progress p;
    p.source = cache_source(push.cache, index);
    p.update = push.found.v[index];
    p.path = take_path(index);
    p.scatterings = push.rays.v[index].bits;
    p.next_number = 0u;
    const WavefrontHit met = push.hits.v[index];
    const bool goes_on = meet(p, index, met);
    push.found.v[index] = p.update;
    if (!goes_on) return false;
    keep_path(index, p.path, p.scatterings);
    return true;
}

void main() {
    const uint i = cache_invocation();
    if (gl_LocalInvocationIndex == 0u) on_count = 0u;
    barrier();
    bool goes_on = false;
    uint index = 0u, place = 0u;
    if (i < push.cache.v.path_count[push.round]) {
        index = push.round == 0u ? i : push.lists.v[cache_path_at(push.cache, push.round, i)];
        goes_on = step_on(index);
        if (goes_on) place = atomicAdd(on_count, 1u);
    }
    barrier();
    if (gl_LocalInvocationIndex == 0u && on_count != 0u) first_place = atomicAdd(push.cache.v.path_count[push.round + 1u], on_count);
    barrier();
    if (goes_on) push.lists.v[cache_path_at(push.cache, push.round + 1u, first_place + place)] = index;
}
