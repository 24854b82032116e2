// The random numbers of a vertex.
#ifndef PARHELION_SCENE_VERTEX_NUMBERS_GLSL
#define PARHELION_SCENE_VERTEX_NUMBERS_GLSL
#extension GL_EXT_control_flow_attributes : require
#include "lib/sampler.glsl"
#include "scene/path_state.glsl"

// The numbers of a vertex where the path scatters.
struct VertexNumbers {
    vec4 pick, light;
    vec3 scatter;  // lobe, direction
    float roulette;
};

VertexNumbers draw_numbers(ViewData view, PathKey key, uint bounce) {
    PathSampler samples = make_sampler(key.pixel, key.sample_index, key.seed, view.sampler_kind, scene.header.sobol, scene.header.blue_noise);
    start_bounce(samples, bounce + 1u);
    VertexNumbers numbers;
    // A loop, so that what is long is compiled once.
    [[dont_unroll]] for (uint k = 0u; k < 7u; ++k) {
        const vec2 u = k == 4u || k == 6u ? vec2(next_1d(samples), 0.0) : next_2d(samples);
        if (k == 0u) numbers.pick.xy = u;
        else if (k == 1u) numbers.pick.zw = u;
        else if (k == 2u) numbers.light.xy = u;
        else if (k == 3u) numbers.light.zw = u;
        else if (k == 4u) numbers.scatter.x = u.x;
        else if (k == 5u) numbers.scatter.yz = u;
        else numbers.roulette = u.x;
    }
    return numbers;
}
#endif
