#version 460
// Chooses the cells that this frame updates, each by a random number of its key and the frame against the share of its class, keeps
// their claims as they are now, and begins the path of each.
// Reads and writes: cache. Writes: rays, paths.
#extension GL_GOOGLE_include_directive : require
#include "cache/update.glsl"
#include "lib/geometry.glsl"

#include "lib/warp.glsl"
#include "shared/scene.h"

layout(local_size_x = kCacheGroup) in;
layout(buffer_reference, scalar, buffer_reference_align = 16) writeonly buffer CacheRays { WavefrontRay v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer CachePaths { CachePath v[]; };
layout(push_constant, scalar) uniform Push {
    Cache cache;
    CacheRays rays;
    CachePaths paths;
} push;

shared uint chosen_count, first_place;

// One direction of the hemisphere, by the cosine.
void begin_path(uint update, CacheSource source) {
    const vec3 wi = sample_cosine_hemisphere(cache_numbers(push.cache, source, kCacheOfDirection).xy);
    push.rays.v[update] = WavefrontRay(source.origin_ws, cache_alpha_key(push.cache, source, kRayPath), normalize(make_frame(source.n) * wi), 0u);
    push.paths.v[update] = CachePath(vec3(1.0), pdf_cosine_hemisphere_solid_angle(wi.z), uvec4(kNone), 0.0, 1.0);
}

void main() {
    const uint i = cache_invocation();
    if (gl_LocalInvocationIndex == 0u) chosen_count = 0u;
    barrier();
    uint slot = kCacheNoSlot, place = 0u;
    uint64_t key = kCacheNoKey;
    if (i < push.cache.v.live) {
        slot = CacheWords(push.cache.v.lists[push.cache.v.list]).v[i];
        key = CacheWords64(push.cache.v.keys).v[slot];
        const float u = uint_to_unit_float(cache_random(key, push.cache.v.frame_index, push.cache.v.seed, kCacheForChoice).x);
        if (u < push.cache.v.class_share[cache_slot_class(push.cache, slot, key)]) place = atomicAdd(chosen_count, 1u);
        else slot = kCacheNoSlot;
    }
    barrier();
    if (gl_LocalInvocationIndex == 0u) first_place = atomicAdd(push.cache.v.update_count, chosen_count);
    barrier();
    if (slot == kCacheNoSlot || first_place + place >= push.cache.v.update_capacity) return;
    const uint update = first_place + place;
    cache_note_update(push.cache, slot, update);
    // Rays of the update will claim this very cell anew while others start from it.
    const uint64_t claim = CacheWords64(push.cache.v.claims).v[slot];
    CacheWords64(push.cache.v.kept).v[update] = claim;
    begin_path(update, cache_source(key, claim));
}
