// Keys of the world cache: which cell a point belongs to, as 63 bits that say it exactly, mixed so that any of them serve as a hash.
// Also compiled as C++ (shared/functions.h).
//     level   size 2^(level - kCacheUnitLevel) metres
//     key     cell (14 bits an axis), level (5), normal (7), owner (9), mixed by a bijection: equal keys are equal cells
//     cells   are flat: along the axis nearest to their normal a quarter as long, so that parallel faces keep apart
// No two cells share a key but where owners collide in 9 bits.
#ifndef PARHELION_LIB_CACHE_KEY_GLSL
#define PARHELION_LIB_CACHE_KEY_GLSL
#include "lib/hash.glsl"
#include "shared/cache.h"
SHARED_BEGIN
#ifdef __cplusplus
using glm::ivec3;
using glm::sqrt;
#endif

SHARED_CONST uint kCacheUnitLevel = 15u;  // of cells of one metre
SHARED_CONST uint kCacheLevels = 32u;
SHARED_CONST int kCacheAxisBits = 14;
SHARED_CONST uint kCacheNormalSteps = 5u;  // of the octahedral square on either side of 0: 11 x 11 codes, axes in the middle of theirs
SHARED_CONST uint kCacheKeyBits = 63u;
SHARED_CONST uint64_t kCacheNoKey = 0xFFFFFFFFFFFFFFFFul;
// Flips bits of the normal's code, so that what would be mixed to kCacheNoKey has a code that no normal has.
SHARED_CONST uint64_t kCacheKeySalt = 0x0008800000000000ul;
SHARED_CONST uint64_t kCacheNewborn = 0x8000000000000000ul;  // of a key: its cell came in this frame and is not read yet

// A bijection of numbers of `bits` bits that mixes them: MurmurHash3's finaliser (Appleby 2011) kept within them. `shift` is at least
// half of `bits`, so that one step undoes another.
SHARED_FN uint64_t cache_mix(uint64_t v, uint bits, uint shift) {
    const uint64_t mask = (uint64_t(1) << bits) - uint64_t(1);
    v = v ^ (v >> shift);
    v = (v * 0xff51afd7ed558ccdul) & mask;
    v = v ^ (v >> shift);
    v = (v * 0xc4ceb9fe1a85ec53ul) & mask;
    return v ^ (v >> shift);
}
SHARED_FN uint64_t cache_unmix(uint64_t v, uint bits, uint shift) {
    const uint64_t mask = (uint64_t(1) << bits) - uint64_t(1);
    v = v ^ (v >> shift);
    v = (v * 0x9cb4b2f8129337dbul) & mask;
    v = v ^ (v >> shift);
    v = (v * 0x4f74430c22a54005ul) & mask;
    return v ^ (v >> shift);
}

SHARED_FN int cache_exponent(float x) { return int((floatBitsToUint(x) >> 23) & 0xFFu) - 127; }
SHARED_FN float cache_level_size(uint level) { return uintBitsToFloat((level + 127u - kCacheUnitLevel) << 23); }

SHARED_FN float cache_sign(float x) { return x < 0.0f ? -1.0f : 1.0f; }
// The octahedral map. Meyer et al. 2010, "On Floating-Point Normal Vectors".
SHARED_FN vec2 cache_octahedral(vec3 n) {
    const float scale = 1.0f / (abs(n.x) + abs(n.y) + abs(n.z));
    const float x = n.x * scale, y = n.y * scale;
    if (n.z >= 0.0f) return vec2(x, y);
    return vec2((1.0f - abs(y)) * cache_sign(x), (1.0f - abs(x)) * cache_sign(y));
}
SHARED_FN vec3 cache_from_octahedral(vec2 o) {
    vec3 n = vec3(o.x, o.y, 1.0f - abs(o.x) - abs(o.y));
    if (n.z < 0.0f) n = vec3((1.0f - abs(o.y)) * cache_sign(o.x), (1.0f - abs(o.x)) * cache_sign(o.y), n.z);
    return n * (1.0f / sqrt(dot(n, n)));
}

SHARED_FN uint cache_normal_code(vec3 n) {
    const vec2 o = cache_octahedral(n);
    const int steps = int(kCacheNormalSteps);
    int x = int(floor(o.x * float(steps) + 0.5f)), y = int(floor(o.y * float(steps) + 0.5f));
    // On the square's rim two points are one direction.
    if (abs(x) == steps && y < 0) y = -y;
    if (abs(y) == steps && x < 0) x = -x;
    return uint(y + steps) * (2u * kCacheNormalSteps + 1u) + uint(x + steps);
}

// The axis nearest to a direction of the octahedral square, in integers with `steps` on either side of 0: floats of directions between two
// axes might say one thing in one shader and another in the next.
SHARED_FN int cache_nearest_axis(int o_x, int o_y, int steps) {
    int x = abs(o_x), y = abs(o_y);
    const int z = steps - x - y;
    if (z < 0) {
        const int unfolded = steps - y;
        y = steps - x;
        x = unfolded;
    }
    return x >= y && x >= abs(z) ? 0 : y >= abs(z) ? 1 : 2;
}
SHARED_FN int cache_flat_axis(uint normal_code) {
    const int steps = int(kCacheNormalSteps), across = 2 * steps + 1;
    return cache_nearest_axis(int(normal_code) % across - steps, int(normal_code) / across - steps, steps);
}
// How many cells of a level there are to its size, by axis.
SHARED_CONST float kCacheFlat = 4.0f;  // along the axis in which they are flat
SHARED_FN vec3 cache_flatness(uint normal_code) {
    vec3 cells = vec3(1.0f);
    cells[cache_flat_axis(normal_code)] = kCacheFlat;
    return cells;
}

// The level of cells of about this size, metres, at a point; u in [0, 1) dissolves one level into the next. Cells are never so small
// that their numbers leave the key's bits: 2^-12 of the distance from the origin, 2^-10 along the axis in which they are flat, where floats
// themselves are getting coarse.
SHARED_FN uint cache_level(vec3 p, uint normal_code, float size, float u) {
    const float past = float(floatBitsToUint(size) & 0x7FFFFFu) * 1.1920929e-7f;  // of the way to the next power of two
    const int wanted = cache_exponent(size) + (u < past ? 1 : 0), flat_axis = cache_flat_axis(normal_code);
    const int least = max(cache_exponent(max(abs(p.x), max(abs(p.y), abs(p.z)))), cache_exponent(abs(p[flat_axis])) + 2) - (kCacheAxisBits - 2);
    return uint(min(max(max(wanted, least) + int(kCacheUnitLevel), 0), int(kCacheLevels) - 1));
}

// The number of the cell that a point belongs to. It is looked up a little above the surface, so that walls that lie in a plane of the
// lattice fall into one layer of cells, and moved along the surface by `jitter` (cells): neighbours blend where look-ups vary.
SHARED_FN ivec3 cache_cell(vec3 p, vec3 n, uint normal_code, uint level, vec3 jitter) {
    const float kAbove = 0.0734f;  // of a level's size; no plane that a modeller would draw is that far off the lattice
    const float size = cache_level_size(level);
    SHARED_PRECISE const vec3 moved = (jitter - n * dot(n, jitter)) + n * kAbove;
    SHARED_PRECISE const vec3 cell = floor((p * (1.0f / size) + moved) * cache_flatness(normal_code));
    const int most = 1 << (kCacheAxisBits - 1);
    return ivec3(min(max(int(cell.x), -most), most - 1), min(max(int(cell.y), -most), most - 1), min(max(int(cell.z), -most), most - 1));
}
// The corner of a cell where its coordinates are least, in sizes of its level.
SHARED_FN vec3 cache_corner(ivec3 cell, uint normal_code) { return vec3(float(cell.x), float(cell.y), float(cell.z)) / cache_flatness(normal_code); }

SHARED_FN uint64_t cache_key(ivec3 cell, uint level, uint normal_code, uint owner) {
    const uint mask = (1u << kCacheAxisBits) - 1u;
    uint64_t key = uint64_t(uint(cell.x) & mask) | (uint64_t(uint(cell.y) & mask) << 14) | (uint64_t(uint(cell.z) & mask) << 28);
    key |= (uint64_t(level) << 42) | (uint64_t(normal_code) << 47) | (uint64_t(pcg_hash(owner) & 0x1FFu) << 54);
    return cache_mix(key ^ kCacheKeySalt, kCacheKeyBits, 32u);
}

// Of a key, with or without kCacheNewborn.
SHARED_FN uint64_t cache_plain_key(uint64_t key) { return cache_unmix(key & ~kCacheNewborn, kCacheKeyBits, 32u) ^ kCacheKeySalt; }
SHARED_FN uint cache_key_level(uint64_t key) { return uint(cache_plain_key(key) >> 42) & 31u; }
SHARED_FN uint cache_key_normal(uint64_t key) { return uint(cache_plain_key(key) >> 47) & 127u; }
SHARED_FN int cache_key_axis(uint64_t plain, uint axis) {
    const int bits = int(uint(plain >> (14u * axis)) << 18);
    return bits >> 18;
}
SHARED_FN ivec3 cache_key_cell(uint64_t key) {
    const uint64_t plain = cache_plain_key(key);
    return ivec3(cache_key_axis(plain, 0u), cache_key_axis(plain, 1u), cache_key_axis(plain, 2u));
}

// Where a key may lie: the slots of a bucket, from one on and around its end.
SHARED_FN uint cache_bucket(uint64_t key, uint bucket_mask) { return uint(key) & bucket_mask; }
SHARED_FN uint cache_probe(uint64_t key, uint bucket, uint i) { return bucket * kCacheBucket + ((uint(key >> 32) + i) & (kCacheBucket - 1u)); }

// Let into a bucket of this strictness: a share of 2^-strictness of all keys, always the same ones.
SHARED_FN bool cache_admitted(uint64_t key, uint strictness) { return strictness == 0u || (uint(key >> 37) & ((1u << min(strictness, 25u)) - 1u)) == 0u; }

SHARED_END
#endif
