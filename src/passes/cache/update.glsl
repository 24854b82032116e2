// What the passes of an update have in common: one sample of the irradiance at a cell. Light by resampled importance sampling, what comes
// by way of other surfaces by one ray that ends in the cache. One choice among all candidates for direct light, N points of lights and the
// one direction that the ray takes: Talbot, Cline, Egbert 2005, "Importance Resampling for Global Illumination", their weights by the
// balance heuristic (Veach and Guibas 1995), so that each light is counted once whichever way finds it.
#ifndef PARHELION_CACHE_UPDATE_GLSL
#define PARHELION_CACHE_UPDATE_GLSL
#include "cache/cells.glsl"
#include "lib/color.glsl"

// Updates whose paths have a ray in a round: even rounds in one half of the list, odd ones in the other.
uint cache_path_at(Cache cache, uint round, uint i) { return (round & 1u) * cache.v.update_capacity + i; }

// Where an update's rays start, and what its random numbers are of.
struct CacheSource {
    uint64_t key;
    vec3 origin_ws, n;
    uint life;
    float cell_size;
};
CacheSource cache_source(uint64_t key, uint64_t claim) {
    CacheSource source;
    source.key = key;
    const uint level = cache_key_level(key);
    cache_unpack_point(claim & kCachePointMask, cache_corner(cache_key_cell(key), cache_key_normal(key)), level, source.origin_ws, source.n);
    source.life = cache_claim_life(claim);
    source.cell_size = cache_level_size(level);
    return source;
}
CacheSource cache_source(Cache cache, uint update) {
    return cache_source(CacheWords64(cache.v.keys).v[CacheWords(cache.v.updates).v[update]], CacheWords64(cache.v.kept).v[update]);
}
uint cache_alpha_key(Cache cache, CacheSource source, uint kind) { return hash_combine(hash_combine(uint(source.key), cache.v.frame_index), kind); }

// Numbers of an update: those of its direction, of each candidate, of each round of its path.
const uint kCacheOfDirection = 0u, kCacheOfCandidates = 1u, kCacheOfRounds = 4096u, kCacheRoundNumbers = 64u;
vec4 cache_numbers(Cache cache, CacheSource source, uint which) {
    const uvec4 h = cache_random(source.key, cache.v.frame_index, cache.v.seed, kCacheForPaths + which);
    return vec4(uint_to_unit_float(h.x), uint_to_unit_float(h.y), uint_to_unit_float(h.z), uint_to_unit_float(h.w));
}

// One over the sum over techniques of how often each offers a candidate.
float cache_inverse_density(uint candidates, float light_pdf, float direction_pdf) { return 1.0 / max(float(candidates) * light_pdf + direction_pdf, 1e-30); }
#endif
