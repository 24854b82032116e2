#version 460
// Blends what the update's rays found into the cells that asked: running means that forget the faster, the more surely their light has
// changed. Boissé and others 2022, "GI-1.0: A Fast Scalable Two-Level Radiance Caching Scheme for Real-Time Global Illumination", after
// document 004; that a change must stand out of the cell's own noise is ours.
// Reads and writes: cache.
#extension GL_GOOGLE_include_directive : require
#include "cache/cells.glsl"
#include "lib/color.glsl"

layout(local_size_x = kCacheGroup) in;
layout(push_constant, scalar) uniform Push {
    Cache cache;
} push;

// The count at which a mean stops growing steadier: a trend shortens it to a few samples, not to one.
float count_limit(CacheMoments moments) {
    const float kShortest = 4.0, most = float(push.cache.v.most_samples);
    return mix(most, min(kShortest, most), sqrt(sqrt(cache_trend(moments))));
}

void main() {
    const uint i = cache_invocation();
    if (i >= push.cache.v.update_count) return;
    const uint slot = CacheWords(push.cache.v.updates).v[i];
    const vec3 found = CacheSamples(push.cache.v.samples).v[i];
    const vec3 before = cache_unpack_irradiance(CacheWords64(push.cache.v.irradiance).v[slot]);
    CacheMoments moments = cache_unpack_moments(CacheWords(push.cache.v.moments).v[slot]);

    const uvec4 random = cache_random(CacheWords64(push.cache.v.keys).v[slot], push.cache.v.frame_index, push.cache.v.seed, kCacheForRounding);
    // Cells light each other: a plain mean would keep the darkness that they began with for long. This one grows by half a sample with each,
    // so that the newer half counts for three quarters, at a third more variance.
    const float limit = max(count_limit(moments), 1.0), rate = moments.count == 0u ? 1.0 : 1.0 / min(float(moments.count) + 0.5, limit);
    const vec3 after = mix(before, found, rate);
    const float mean_before = luminance(before), mean = luminance(after), sampled = luminance(found);
    if (moments.count > 0u) moments.change = mix(moments.change, clamp((sampled - mean_before) / max(mean_before, 1e-20), -4.0, 4.0), kCacheChangeRate);
    const float square = mix((1.0 + moments.spread) * mean_before * mean_before, sampled * sampled, rate);
    moments.spread = moments.count == 0u ? 1.0 : max(square / max(mean * mean, 1e-30) - 1.0, 0.0);
    moments.count = moments.count == 0u ? 1u : min(moments.count + (random.z >> 31), uint(limit + 0.5));

    CacheWords64(push.cache.v.irradiance).v[slot] = cache_pack_irradiance(after);
    CacheWords(push.cache.v.moments).v[slot] = cache_pack_moments(moments, vec2(uint_to_unit_float(random.x), uint_to_unit_float(random.y)));
}
