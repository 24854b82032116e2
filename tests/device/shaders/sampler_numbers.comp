#version 460
// Sampler tests: numbers of many (kind, pixel, sample, seed, bounce), keys by hash of the invocation.
// Reads: sobol, blue_noise. Writes: numbers, six words an invocation.
#extension GL_GOOGLE_include_directive : require
#include "lib/sampler.glsl"
layout(local_size_x = 64) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Numbers { uint v[]; };
layout(push_constant, scalar) uniform Push {
    SobolTable sobol;
    BlueNoiseTile blue_noise;
    Numbers numbers;
    uint count;
} push;

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    const uvec4 keys = pcg4d(uvec4(i, 1u, 2u, 3u));
    const uvec2 pixel = uvec2(keys.x & 8191u, keys.y & 8191u);
    const uint sample_index = keys.z >> (keys.w & 31u), seed = i / 5u;
    PathSampler s = make_sampler(pixel, sample_index, seed, i % kSamplerKindCount, uint64_t(push.sobol), uint64_t(push.blue_noise));
    start_bounce(s, keys.w >> 28);
    const float a = next_1d(s);
    const vec2 b = next_2d(s);
    const vec2 c = next_2d(s);
    const float d = hash_alpha(hash_ray(pixel, sample_index, seed, i % 9u, i & 1u), keys.x, i % 3u, keys.y);
    push.numbers.v[6u * i] = floatBitsToUint(a);
    push.numbers.v[6u * i + 1u] = floatBitsToUint(b.x);
    push.numbers.v[6u * i + 2u] = floatBitsToUint(b.y);
    push.numbers.v[6u * i + 3u] = floatBitsToUint(c.x);
    push.numbers.v[6u * i + 4u] = floatBitsToUint(c.y);
    push.numbers.v[6u * i + 5u] = floatBitsToUint(d);
}
