// Random numbers of paths: a number is a function of (pixel, sample, seed, dimension) and of nothing else, so any pass can make
// the sampler anew at any bounce and gets the numbers that another renderer got there. Also compiled as C++ (shared/functions.h).
//
//     PathSampler s = make_sampler(pixel, sample_index, seed, kind, sobol_address, blue_noise_address);
//     start_bounce(s, 1u);  const vec2 u = next_2d(s);  const float v = next_1d(s);
//
// All numbers are multiples of 2^-24 in [0, 1).
#ifndef PARHELION_LIB_SAMPLER_GLSL
#define PARHELION_LIB_SAMPLER_GLSL
#include "lib/hash.glsl"
#include "lib/sobol.glsl"
SHARED_BEGIN

SHARED_ARRAY(BlueNoiseTile, uint)

struct PathSampler {
    uint64_t sobol;       // address of the Sobol table, read by kSamplerCranley only
    uint64_t blue_noise;  // address of the blue-noise tile, read by kSamplerCranley only
    uvec2 pixel;
    uint sample_index;
    uint seed;
    uint kind;       // kSampler...
    uint dimension;  // of the next number
};

SHARED_FN PathSampler make_sampler(uvec2 pixel, uint sample_index, uint seed, uint kind, uint64_t sobol_table, uint64_t blue_noise) {
    PathSampler s;
    s.sobol = sobol_table;
    s.blue_noise = blue_noise;
    s.pixel = pixel;
    s.sample_index = sample_index;
    s.seed = seed;
    s.kind = kind;
    s.dimension = 0u;
    return s;
}

// Goes to the dimensions of a scattering: 0 is the camera, 1 the first surface, and so on.
SHARED_FN void start_bounce(SHARED_INOUT(PathSampler) s, uint bounce) {
    s.dimension = bounce == 0u ? 0u : kCameraDimensions + (bounce - 1u) * kDimensionsPerBounce;
}

// White noise from all keys. Jarzynski and Olano 2020.
SHARED_FN uvec2 draw_pcg(PathSampler s, uint dimension) {
    const uvec4 h = pcg4d(uvec4(s.pixel.x, s.pixel.y, s.sample_index, hash_combine(s.seed, dimension)));
    return uvec2(h.x, h.y);
}

// A (0,2)-sequence of its own for each pixel and dimension.
SHARED_FN uvec2 draw_owen(PathSampler s) {
    const uvec4 h = pcg4d(uvec4(s.pixel.x, s.pixel.y, s.seed, s.dimension));
    return owen_sobol_2d(s.sample_index, uvec3(h.x, h.y, h.z));
}

// White noise of document 003: a Wang hash of the keys times large primes, then xorshift. Kept for comparison: 32 bits of state
// for all keys together.
SHARED_FN uvec2 draw_white(PathSampler s) {
    const uint key = s.pixel.x * 73856093u + s.pixel.y * 19349663u + s.sample_index * 83492791u + s.dimension * 2654435761u;
    const uint first = xorshift(wang_hash(key + s.seed * 3266489917u));
    return uvec2(first, xorshift(first));
}

// Blue-noise rank of a pixel in a dimension. The tile moves from one dimension to the next by a step (found by trying all) that
// keeps the places of any two dimensions of the table at least 11 pixels apart on the torus, of the next eight 42: nearer ones
// correlate, the tile being blue. Document 002's step (73, 127) puts every seventh dimension 7 pixels away.
SHARED_FN uint blue_noise_rank(uint64_t tile, uvec2 pixel, uint dimension) {
    const uint x = (pixel.x + 71u * dimension) & (kBlueNoiseSize - 1u);
    const uint y = (pixel.y + 84u * dimension) & (kBlueNoiseSize - 1u);
    return (BlueNoiseTile(tile).v[(y * kBlueNoiseSize + x) >> 1] >> (16u * (x & 1u))) & 0xFFFFu;
}

// Sobol with a shift per pixel (Cranley and Patterson 1976) whose high bits are blue noise over the image (Georgiev and Fajardo
// 2016) and whose low bits are hashed, so that the shift is uniform to the last bit. A new seed moves it by golden-ratio steps;
// each dimension takes the steps in its own shuffled order, because equal steps in all would only walk the diagonal. All samples
// of a seed share the shift: moving it by sample breaks the sequence. The first 2^k points of Sobol's sequence differ in k bits only,
// and with the same shift they would agree in all others, which choose between the sides of an alias table's bins: those are hashed
// by sample, as far as the bits that the points so far have told apart, and ten at least, stay as they are.
SHARED_FN uint draw_cranley(PathSampler s, uint dimension) {
    if (dimension >= kSobolDimensions) return draw_pcg(s, dimension).x;
    const uint low_bits = 32u - kBlueNoiseRankBits;
    const uint low = pcg4d(uvec4(s.pixel.x, s.pixel.y, s.seed, dimension)).x >> kBlueNoiseRankBits;
    const uint blue = (blue_noise_rank(s.blue_noise, s.pixel, dimension) << low_bits) | low;
    const uint step = nested_uniform_scramble(s.seed, pcg_hash(dimension));
    const uint kept_bits = max(uint(findMSB(s.sample_index) + 1), 10u);
    const uint jitter = pcg4d(uvec4(s.pixel.x, s.pixel.y, hash_combine(s.seed, s.sample_index), dimension)).y >> kept_bits;
    return sobol(s.sobol, s.sample_index, dimension) + blue + step * 0x9E3779B9u + jitter;
}

SHARED_FN float next_1d(SHARED_INOUT(PathSampler) s) {
    uint bits;
    if (s.kind == kSamplerOwen) bits = draw_owen(s).x;
    else if (s.kind == kSamplerCranley) bits = draw_cranley(s, s.dimension);
    else if (s.kind == kSamplerPcg) bits = draw_pcg(s, s.dimension).x;
    else bits = draw_white(s).x;
    s.dimension += 1u;
    return uint_to_unit_float(bits);
}

SHARED_FN vec2 next_2d(SHARED_INOUT(PathSampler) s) {
    uvec2 bits;
    if (s.kind == kSamplerOwen) bits = draw_owen(s);
    else if (s.kind == kSamplerCranley) bits = uvec2(draw_cranley(s, s.dimension), draw_cranley(s, s.dimension + 1u));
    else if (s.kind == kSamplerPcg) bits = draw_pcg(s, s.dimension);
    else bits = draw_white(s);
    s.dimension += 2u;
    return vec2(uint_to_unit_float(bits.x), uint_to_unit_float(bits.y));
}

SHARED_END
#endif
