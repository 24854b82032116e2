// What the world cache keeps of a cell, packed: claims (life and representative point), irradiance, moments. Also compiled as C++
// (shared/functions.h).
#ifndef PARHELION_LIB_CACHE_CELL_GLSL
#define PARHELION_LIB_CACHE_CELL_GLSL
#include "lib/cache_key.glsl"
SHARED_BEGIN
#ifdef __cplusplus
using glm::exp2;
using glm::log2;
#endif

// A claim, and what an atomic minimum of claims decides: the longer life wins, then a point of this frame before an older one, then
// the smaller number that the point's bits are mixed to, with another salt each frame: one point of all that came, with equal chances,
// whatever their order.
//     63 - life 6 | old 1 | point 57: normal 10 + 10, two tangential coordinates 11 + 11, one along the normal 15
SHARED_CONST uint64_t kCacheNoClaim = 0xFFFFFFFFFFFFFFFFul;
SHARED_CONST uint kCachePointBits = 57u;
SHARED_CONST uint64_t kCachePointMask = 0x01FFFFFFFFFFFFFFul;
SHARED_CONST uint64_t kCacheNoPoint = 0xFFFFFFFFFFFFFFFFul;
SHARED_CONST uint64_t kCacheOldPoint = 0x0200000000000000ul;
// Points lie within the cell but for jitter and the height at which the cell was looked up.
SHARED_CONST float kCachePointFrom = -1.25f;  // in cells, from the cell's corner
SHARED_CONST float kCachePointRange = 3.5f;

SHARED_FN uint cache_claim_life(uint64_t claim) { return kCacheMostLife - uint(claim >> 58); }
SHARED_FN uint64_t cache_salt(uint frame_index) { return ((uint64_t(pcg_hash(frame_index)) << 32) | uint64_t(pcg_hash(~frame_index))) & kCachePointMask; }
SHARED_FN uint64_t cache_claim(uint life, uint64_t point, uint64_t salt) {
    return (uint64_t(kCacheMostLife - min(life, kCacheMostLife)) << 58) | cache_mix(point ^ salt, kCachePointBits, 29u);
}
// The same point with another life, as a claim that any new one of that life replaces.
SHARED_FN uint64_t cache_old_claim(uint64_t claim, uint life, uint64_t salt) {
    const uint64_t bits = claim & kCachePointMask;
    const uint64_t point = (claim & kCacheOldPoint) != uint64_t(0) ? bits : cache_unmix(bits, kCachePointBits, 29u) ^ salt;
    return (uint64_t(kCacheMostLife - life) << 58) | kCacheOldPoint | point;
}

SHARED_FN uint cache_steps(float x, uint most) { return uint(min(max(x, 0.0f), float(most))); }

// A normal as two numbers from 0 to 1022, 511 in the middle.
SHARED_FN vec3 cache_packed_normal(uint nx, uint ny) { return cache_from_octahedral(vec2((float(nx) - 511.0f) * (1.0f / 511.0f), (float(ny) - 511.0f) * (1.0f / 511.0f))); }
SHARED_FN int cache_main_axis(uint nx, uint ny) { return cache_nearest_axis(int(nx) - 511, int(ny) - 511, 511); }

// `corner`: cache_corner of the point's cell. `origin_ws` already lies above the surface by its rounding errors; `back_ws` is the way from there to
// where the path came from, which is free. Tangential coordinates are rounded along it, so that the point does not slide into a wall beside
// it; whoever has come less than a step that way, as from the very foot of that wall, may not speak for the cell: kCacheNoPoint. The point
// slides in its plane, and along the normal it is rounded outwards.
SHARED_FN uint64_t cache_pack_point(vec3 origin_ws, vec3 n, vec3 back_ws, vec3 corner, uint level) {
    const vec2 o = cache_octahedral(n);
    const uint nx = cache_steps(o.x * 511.0f + 511.5f, 1022u), ny = cache_steps(o.y * 511.0f + 511.5f, 1022u);
    const int a = cache_main_axis(nx, ny), b = a == 2 ? 0 : a + 1, c = b == 2 ? 0 : b + 1;
    const float inverse_size = 1.0f / cache_level_size(level);
    SHARED_PRECISE const vec3 local = origin_ws * inverse_size - corner;
    const float step = kCachePointRange / 2048.0f;
    if (min(abs(back_ws[b]), abs(back_ws[c])) * inverse_size < step) return kCacheNoPoint;
    const float tb = (local[b] - kCachePointFrom) / step, tc = (local[c] - kCachePointFrom) / step;
    const uint sb = cache_steps(back_ws[b] > 0.0f ? ceil(tb) : floor(tb), 2047u), sc = cache_steps(back_ws[c] > 0.0f ? ceil(tc) : floor(tc), 2047u);
    const float slide = (n[b] * (float(sb) - tb) + n[c] * (float(sc) - tc)) * step / n[a];
    const float ta = (local[a] - slide - kCachePointFrom) * (32768.0f / kCachePointRange);
    const uint sa = cache_steps(n[a] > 0.0f ? ceil(ta) : floor(ta), 32767u);
    return (((uint64_t(nx) << 10 | uint64_t(ny)) << 11 | uint64_t(sb)) << 11 | uint64_t(sc)) << 15 | uint64_t(sa);
}
SHARED_FN void cache_unpack_point(uint64_t point, vec3 corner, uint level, SHARED_INOUT(vec3) origin_ws, SHARED_INOUT(vec3) n) {
    const uint sa = uint(point) & 32767u, sc = uint(point >> 15) & 2047u, sb = uint(point >> 26) & 2047u;
    const uint ny = uint(point >> 37) & 1023u, nx = uint(point >> 47) & 1023u;
    n = cache_packed_normal(nx, ny);
    const int a = cache_main_axis(nx, ny), b = a == 2 ? 0 : a + 1, c = b == 2 ? 0 : b + 1;
    vec3 local = vec3(kCachePointFrom);
    local[a] += float(sa) * (kCachePointRange / 32768.0f);
    local[b] += float(sb) * (kCachePointRange / 2048.0f);
    local[c] += float(sc) * (kCachePointRange / 2048.0f);
    origin_ws = (corner + local) * cache_level_size(level);
}

// Three channels with 18 bits and a common exponent: running means of hundreds of samples do not stall.
SHARED_FN uint64_t cache_pack_irradiance(vec3 e) {
    const float largest = max(e.x, max(e.y, e.z));
    if (!(largest > 0.0f)) return uint64_t(0);
    const int exponent = min(max(cache_exponent(largest) + 1, -100), 127);
    const float scale = uintBitsToFloat(uint(18 - exponent + 127) << 23);
    const uint most = (1u << 18) - 1u;
    const uint64_t r = uint64_t(cache_steps(e.x * scale + 0.5f, most)), g = uint64_t(cache_steps(e.y * scale + 0.5f, most)), b = uint64_t(cache_steps(e.z * scale + 0.5f, most));
    return (uint64_t(uint(exponent + 128)) << 54) | (r << 36) | (g << 18) | b;
}
SHARED_FN vec3 cache_unpack_irradiance(uint64_t packed) {
    const uint most = (1u << 18) - 1u;
    const int exponent = int(uint(packed >> 54) & 255u) - 128;
    if (packed == uint64_t(0)) return vec3(0.0f);
    const float scale = uintBitsToFloat(uint(exponent - 18 + 127) << 23);
    return vec3(float(uint(packed >> 36) & most), float(uint(packed >> 18) & most), float(uint(packed) & most)) * scale;
}

// Moments: count 8 | age 6 | spread 9 | change 9. Both last are of the luminance and relative to its mean, so that no change of
// exposure touches them.
SHARED_CONST uint kCacheAgeShift = 8u, kCacheCountMask = 255u;
struct CacheMoments {
    uint count;    // 0: nothing is known; 1: samples to which light was missing, or of before a light was switched; then one more than what the mean is worth in samples,
                   // of which each but the first adds a half, up to a limit
    uint age;      // frames since birth, up to kCacheOldest
    float spread;  // second moment over the mean's square, less 1: a sample's relative variance
    float change;  // running mean of (sample - mean) / mean
};
// What a mean is worth, in samples.
SHARED_FN float cache_worth(uint count) { return count < 2u ? 0.25f * float(count) : float(count - 1u); }
// Code of a number in [0, 2^8): steps of a 24th of an octave from 2^-12 on; u rounds it at random, so that small steps are not lost.
SHARED_FN uint cache_log_code(float x, uint most, float steps, float u) {
    if (!(x > 2.4414e-4f)) return 0u;
    return cache_steps(1.0f + (log2(x) + 12.0f) * steps + u, most);
}
SHARED_FN float cache_from_log_code(uint code, float steps) { return code == 0u ? 0.0f : exp2((float(code) - 1.0f) / steps - 12.0f); }
SHARED_FN uint cache_pack_moments(CacheMoments m, vec2 u) {
    const uint spread = cache_log_code(m.spread, 511u, 24.0f, u.x), change = cache_log_code(abs(m.change), 255u, 12.0f, u.y);
    return min(m.count, kCacheMostSamples) | (min(m.age, kCacheOldest) << kCacheAgeShift) | (spread << 14) | (change << 23) | (m.change < 0.0f ? 0x80000000u : 0u);
}
SHARED_FN CacheMoments cache_unpack_moments(uint packed) {
    CacheMoments m;
    m.count = packed & kCacheCountMask;
    m.age = (packed >> kCacheAgeShift) & kCacheOldest;
    m.spread = cache_from_log_code((packed >> 14) & 511u, 24.0f);
    m.change = cache_from_log_code((packed >> 23) & 255u, 12.0f) * ((packed & 0x80000000u) != 0u ? -1.0f : 1.0f);
    return m;
}

SHARED_END
#endif
