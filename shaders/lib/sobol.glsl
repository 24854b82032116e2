// Sobol points and Owen's scrambling of them, on 32-bit fixed point fractions. Also compiled as C++ (shared/functions.h).
// Sobol 1967; Owen 1995; Burley 2020, "Practical Hash-based Owen Scrambling".
#ifndef PARHELION_LIB_SOBOL_GLSL
#define PARHELION_LIB_SOBOL_GLSL
#include "shared/functions.h"
#include "shared/sampler.h"
SHARED_BEGIN

SHARED_ARRAY(SobolTable, uint)

// A permutation of 32-bit words in which every output bit depends on its own and lower input bits only: Owen's scrambling of a
// bit-reversed fraction. After Laine and Karras 2011, with Vegdahl's constants (2021, "Building a Better LK Hash"), whose
// bits avalanche better than the first published set. The seed must be well mixed.
SHARED_FN uint permute_upwards(uint v, uint seed) {
    v ^= v * 0x3D20ADEAu;
    v += seed;
    v *= (seed >> 16) | 1u;
    v ^= v * 0x05526C56u;
    return v ^ (v * 0x53A22864u);
}

// Owen's scrambling of a fraction; of an index: a shuffle that keeps every aligned block of 2^k indices together.
SHARED_FN uint nested_uniform_scramble(uint v, uint seed) { return bitfieldReverse(permute_upwards(bitfieldReverse(v), seed)); }

// The second Sobol dimension, bit-reversed (the first is the index itself, bit-reversed). Its generator matrix is Pascal's
// triangle mod 2, where C(j, k) is odd just if the bits of k are among those of j (Lucas): bit k sums the index bits j over all
// supersets j of k, five butterfly steps. The structure is Ahmed's (2024, "An Implementation Algorithm of 2D Sobol Sequence").
SHARED_FN uint sobol_second_reversed(uint index) {
    index ^= (index >> 16) & 0x0000FFFFu;
    index ^= (index >> 8) & 0x00FF00FFu;
    index ^= (index >> 4) & 0x0F0F0F0Fu;
    index ^= (index >> 2) & 0x33333333u;
    return index ^ ((index >> 1) & 0x55555555u);
}

// Point `index` of a randomised (0,2)-sequence: the first two Sobol dimensions, the order shuffled by seeds.x, the coordinates
// scrambled by seeds.y and seeds.z. Any two sets of seeds give independent sequences, which is how dimensions are padded.
SHARED_FN uvec2 owen_sobol_2d(uint index, uvec3 seeds) {
    const uint shuffled = nested_uniform_scramble(index, seeds.x);
    return uvec2(bitfieldReverse(permute_upwards(shuffled, seeds.y)),
                 bitfieldReverse(permute_upwards(sobol_second_reversed(shuffled), seeds.z)));
}

// Coordinate `dimension` < kSobolDimensions of Sobol point `index`. `table`: address of uint[kSobolDimensions * 32].
SHARED_FN uint sobol(uint64_t table, uint index, uint dimension) {
    uint result = 0u;
    while (index != 0u) {
        result ^= SobolTable(table).v[32u * dimension + uint(findLSB(index))];
        index &= index - 1u;
    }
    return result;
}

SHARED_END
#endif
