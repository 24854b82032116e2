#version 460
// Chooses one out of several light samples for the cell of each update. Eight invocations a cell.
// Reads: scene, cache. Writes: found, light_rays.
#extension GL_GOOGLE_include_directive : require
#define CACHE_ACCESS readonly
#include "cache/update.glsl"
#include "scene/lights.glsl"

layout(local_size_x = kCacheGroup) in;
layout(buffer_reference, scalar, buffer_reference_align = 16) writeonly buffer CacheUpdates { CacheUpdate v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) writeonly buffer CacheShadowRays { WavefrontShadowRay v[]; };
layout(push_constant, scalar) uniform Push {
    Cache cache;
    CacheUpdates found;
    CacheShadowRays light_rays;
} push;

shared float lane_sum[kCacheGroup];

// The candidate that was chosen so far.
struct Choice {
    vec3 value;
    float target, sum;
    WavefrontShadowRay ray;
};

void offer(inout Choice choice, CacheSource source, uint candidate) {
    const uint first = kCacheOfCandidates + 3u * candidate;
    const vec4 u_pick = cache_numbers(push.cache, source, first), u_light = cache_numbers(push.cache, source, first + 1u);
    const LightSample light = sample_light(pick_light(source.origin_ws, source.n, u_pick), source.origin_ws, u_light);
    const float cosine = dot(light.wi, source.n);
    if (light.pdf <= 0.0 || cosine <= 0.0) return;
    const vec3 value = light.radiance * cosine;
    const float target = luminance(value);
    const float weight = target * cache_inverse_density(push.cache.v.candidates, light.pdf, light.is_delta ? 0.0 : pdf_cosine_hemisphere_solid_angle(cosine));
    if (!(weight > 0.0)) return;
    choice.sum += weight;
    if (cache_numbers(push.cache, source, first + 2u).x * choice.sum >= weight) return;
    choice.value = value;
    choice.target = target;
    const vec3 to_target = light.target_ws - source.origin_ws;
    choice.ray.origin_ws = source.origin_ws;
    choice.ray.alpha_key = cache_alpha_key(push.cache, source, kRayShadow);
    choice.ray.t_max = light.infinite ? kInfinity : length(to_target) * (1.0 - 4e-7);
    choice.ray.direction_ws = light.infinite ? light.wi : normalize(to_target);
}

void main() {
    const uint here = gl_LocalInvocationIndex, lane = here % kCacheLanes, i = cache_invocation(), update = i / kCacheLanes;
    const bool exists = update < push.cache.v.update_count;
    CacheSource source;
    Choice choice;
    choice.value = vec3(0.0);
    choice.target = choice.sum = 0.0;
    if (exists) {
        source = cache_source(push.cache, update);
        for (uint candidate = lane; candidate < push.cache.v.candidates; candidate += kCacheLanes) offer(choice, source, candidate);
    }
    lane_sum[here] = choice.sum;
    barrier();
    if (!exists) return;
    // Of the invocations' choices one, by their sums: the one in whose part of the whole a number falls.
    float before = 0.0, sum = 0.0;
    for (uint other = 0u; other < kCacheLanes; ++other) {
        if (other == lane) before = sum;
        sum += lane_sum[here - lane + other];
    }
    const float at = cache_numbers(push.cache, source, kCacheOfDirection).z * sum;
    const bool chosen = choice.sum > 0.0 && at >= before && at < before + choice.sum;
    if (chosen || (lane == 0u && !(sum > 0.0)))
        push.found.v[update] = CacheUpdate(vec3(0.0), kCacheNoSlot, vec3(0.0), sum, vec3(0.0), choice.target, choice.value, 0u);
    if (chosen) push.light_rays.v[update] = choice.ray;
}
