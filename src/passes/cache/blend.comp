#version 460
// Blends what the update's rays found into the cells that asked: running means that forget the faster, the more surely their light has
// changed. Boissé and others 2022, "GI-1.0: A Fast Scalable Two-Level Radiance Caching Scheme for Real-Time Global Illumination", after
// document 004; that a change must stand out of the cell's own noise is ours.
// Reads and writes: cache. Reads: found, passing.
#extension GL_GOOGLE_include_directive : require
#include "cache/update.glsl"

layout(local_size_x = kCacheGroup) in;
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer CacheUpdates { CacheUpdate v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer CachePassing { vec4 v[]; };
layout(push_constant, scalar) uniform Push {
    Cache cache;
    CacheUpdates found;
    CachePassing passing;
} push;

// The count at which a mean stops growing steadier: a trend shortens it to a few samples, not to one.
float count_limit(CacheMoments moments) {
    const float kShortest = 4.0, most = float(push.cache.v.most_samples);
    return mix(most, min(kShortest, most), sqrt(sqrt(cache_trend(moments))));
}

// Of means of which each sample lacks light: they are replaced by the first whole one.
const float kUnknownRate = 0.25;

shared uint shadow_count;

// What an update's own rays found.
vec3 found_by(uint index, CacheUpdate update) {
    if (update.target <= 0.0) return update.found;
    const vec3 passing = (update.bits & kCacheSeen) != 0u ? vec3(1.0) : push.passing.v[index].rgb;
    return update.found + passing * update.value * (update.sum / update.target);
}

// The same with what those found that it is linked to, along their chain.
vec3 chained(uint index, out bool unknown) {
    CacheUpdate update = push.found.v[index];
    vec3 sum = found_by(index, update), share = update.share, otherwise = update.otherwise;
    uint link = update.link, bits = update.bits;
    for (uint i = 1u; i < push.cache.v.chain && link != kCacheNoSlot; ++i) {
        update = push.found.v[link];
        sum += share * found_by(link, update);
        otherwise = share * update.otherwise;
        share *= update.share;
        link = update.link;
        bits |= update.bits;
    }
    unknown = (bits & kCacheUnknown) != 0u;
    return link == kCacheNoSlot ? sum : sum + otherwise;
}

void count_shadow_rays(uint traced) {
    if (gl_LocalInvocationIndex == 0u) shadow_count = 0u;
    barrier();
    if (traced != 0u) atomicAdd(shadow_count, traced);
    barrier();
    if (gl_LocalInvocationIndex == 0u) atomicAdd(push.cache.v.shadow_rays, shadow_count);
}

void blend(uint i) {
    const uint slot = CacheWords(push.cache.v.updates).v[i];
    bool unknown;
    const vec3 found = chained(i, unknown) * push.cache.v.exposure;
    const vec3 before = cache_unpack_irradiance(CacheWords64(push.cache.v.irradiance).v[slot]);
    CacheMoments moments = cache_unpack_moments(CacheWords(push.cache.v.moments).v[slot]);

    const uvec4 random = cache_random(CacheWords64(push.cache.v.keys).v[slot], push.cache.v.frame_index, push.cache.v.seed, kCacheForRounding);
    // Cells light each other: a plain mean would keep the darkness that they began with for long. This one grows by half a sample with each,
    // so that the newer half counts for three quarters, at a third more variance.
    const float limit = max(count_limit(moments), 1.0), worth = cache_worth(moments.count);
    const bool first = moments.count == 0u || (moments.count == 1u && (!unknown || push.cache.v.forgets != 0u));
    const float rate = first ? 1.0 : moments.count == 1u ? kUnknownRate : 1.0 / min(worth + 0.5, limit);
    const vec3 after = mix(before, found, rate);
    const float mean_before = luminance(before), mean = luminance(after), sampled = luminance(found);
    if (moments.count > 0u) moments.change = mix(moments.change, clamp((sampled - mean_before) / max(mean_before, 1e-20), -4.0, 4.0), kCacheChangeRate);
    const float square = mix((1.0 + moments.spread) * mean_before * mean_before, sampled * sampled, rate);
    moments.spread = first ? 1.0 : max(square / max(mean * mean, 1e-30) - 1.0, 0.0);
    if (unknown) moments.count = max(moments.count, 1u);
    else moments.count = first ? 2u : min(moments.count + (random.z >> 31), uint(limit + 0.5) + 1u);

    CacheWords64(push.cache.v.irradiance).v[slot] = cache_pack_irradiance(after);
    CacheWords(push.cache.v.moments).v[slot] = cache_pack_moments(moments, vec2(uint_to_unit_float(random.x), uint_to_unit_float(random.y)));
}

void main() {
    const uint i = cache_invocation();
    const bool exists = i < push.cache.v.update_count;
    count_shadow_rays(exists ? uint(push.passing.v[i].w) : 0u);
    if (exists) blend(i);
}
