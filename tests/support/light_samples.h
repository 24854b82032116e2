#pragma once
// Samples lights on the device by the scene's own functions (tests/device/shaders/light_samples.trace).
#include <random>

#include "support/render_fixture.h"

namespace parhelion::testing {

struct LightInput {
    glm::vec4 pick{0.0f}, light{0.0f};  // numbers in [0, 1); or a direction in pick
};
struct LightResult {
    glm::vec3 wi, radiance;
    float pdf;              // per solid angle, with the light's probability
    float pdf_environment;  // with which wi would have been sampled as the environment's
    uint32_t emitter, triangle;
    float probability;
    glm::vec3 target_ws;
};

inline std::vector<LightResult> run_lights(Stage& stage, uint32_t kind, const std::vector<LightInput>& inputs, glm::vec3 position_ws = glm::vec3(0.0f)) {
    struct Push {
        uint64_t inputs = 0, results = 0;
        uint32_t kind, count;
        glm::vec3 position_ws;
    };
    Frame& frame = stage.frame;
    const auto count = static_cast<uint32_t>(inputs.size());
    const gpu::Buffer input(frame.device(), "test/inputs", inputs.size() * sizeof(LightInput)), output(frame.device(), "test/results", inputs.size() * sizeof(LightResult));
    stage.scene_gpu.finish(frame);
    frame.upload(input, 0, std::as_bytes(std::span(inputs)));
    frame.trace("device/light_samples", gpu::TraceWay::Compute)
        .scene(stage.scene_gpu.binding())
        .read("inputs", input)
        .write("results", output)
        .push(Push{.kind = kind, .count = count, .position_ws = position_ws})
        .over(std::min(count, 4096u), (count + 4095u) / 4096u);
    const gpu::Buffer copy = frame.read_back(output);
    frame.run();
    const auto found = copy.mapped_as<LightResult>();
    return {found.begin(), found.end()};
}

// Lights sampled at a point.
inline std::vector<LightResult> sample_lights(Stage& stage, uint32_t count, uint32_t seed, glm::vec3 position_ws = glm::vec3(0.0f)) {
    std::mt19937 random(seed);
    std::vector<LightInput> inputs(count);
    for (LightInput& input : inputs)
        for (int i = 0; i < 4; ++i) {
            input.pick[i] = static_cast<float>(random() >> 8) * 0x1p-24f;
            input.light[i] = static_cast<float>(random() >> 8) * 0x1p-24f;
        }
    return run_lights(stage, 0, inputs, position_ws);
}

// The environment along directions: radiance and density.
inline std::vector<LightResult> look_at_environment(Stage& stage, const std::vector<glm::vec3>& directions) {
    std::vector<LightInput> inputs;
    for (const glm::vec3 d : directions) inputs.push_back({.pick = glm::vec4(d, 0.0f)});
    return run_lights(stage, 1, inputs);
}

}  // namespace parhelion::testing
