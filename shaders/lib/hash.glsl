// Integer hashes and random numbers from keys. Also compiled as C++ (shared/functions.h).
#ifndef PARHELION_LIB_HASH_GLSL
#define PARHELION_LIB_HASH_GLSL
#include "shared/functions.h"
SHARED_BEGIN

// Uniform on the 2^24 multiples of 2^-24 in [0, 1): never 1, and the product is exact.
SHARED_FN float uint_to_unit_float(uint bits) { return float(bits >> 8) * 5.9604645e-8f; }

// One step of a PCG with its output function as a hash. Jarzynski and Olano 2020, "Hash Functions for GPU Rendering"; O'Neill 2014.
SHARED_FN uint pcg_hash(uint value) {
    const uint state = value * 747796405u + 2891336453u;
    const uint word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;
    return (word >> 22) ^ word;
}

// Four keys to four hashes. Jarzynski and Olano 2020.
SHARED_FN uvec4 pcg4d(uvec4 v) {
    v = v * 1664525u + 1013904223u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    v = v ^ (v >> 16u);
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    return v;
}

// A fraction of 2^32 that differs much between pixels and frames near each other: among any few of them all fractions are there about as often as is due.
// Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences" (R3). Uniform in `start`, for which there is another one each time.
SHARED_FN uint spread_number(uvec2 pixel, uint frame, uint start) { return start + pixel.x * 3518319155u + pixel.y * 2882110345u + frame * 2360945575u; }

// Wang 1997, "Integer Hash Function" (32 bit).
SHARED_FN uint wang_hash(uint value) {
    value = (value ^ 61u) ^ (value >> 16);
    value *= 9u;
    value = value ^ (value >> 4);
    value *= 0x27D4EB2Du;
    return value ^ (value >> 15);
}

// One step of a xorshift generator. Marsaglia 2003.
SHARED_FN uint xorshift(uint state) {
    state ^= state << 13;
    state ^= state >> 17;
    return state ^ (state << 5);
}

// Adds one more word to a key; order matters.
SHARED_FN uint hash_combine(uint key, uint value) { return pcg_hash(key ^ pcg_hash(value + 0x9E3779B9u)); }

// Names one ray of one sample: key of its alpha tests.
SHARED_FN uint hash_ray(uvec2 pixel, uint sample_index, uint seed, uint bounce, uint ray_kind) {
    const uint place = hash_combine(hash_combine(pixel.x, pixel.y), sample_index);
    return hash_combine(hash_combine(hash_combine(place, seed), bounce), ray_kind);
}

// The random number that decides whether ray `ray_key` meets a partly transparent triangle: equal each time it is asked, however
// often and in whatever order candidates come, and independent between rays and between surfaces on one ray.
SHARED_FN float hash_alpha(uint ray_key, uint instance, uint geometry, uint primitive) {
    return uint_to_unit_float(hash_combine(hash_combine(hash_combine(ray_key, instance), geometry), primitive));
}

SHARED_END
#endif
