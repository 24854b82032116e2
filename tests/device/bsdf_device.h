#pragma once
// The BSDF's triple on the device (shaders/bsdf.comp), for its tests.
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "device/given_directions.h"
#include "scene_gpu/bsdf_tables.h"
#include "support/gpu_fixture.h"

namespace parhelion::testing {

constexpr uint32_t kLobeNone = 3;

// As in the shader.
struct BsdfSurface {
    glm::vec3 base_color{1.0f}, specular_color{1.0f}, sheen_color{0.0f}, coat_normal{0.0f, 0.0f, 1.0f};
    float metallic = 0, roughness = 0.5f, ior = 1.5f, specular = 1, transmission = 0, eta = 1.5f, coat = 0, coat_roughness = 0, sheen_roughness = 0;
    uint32_t thin = 0, compensate = 1, inside = 0;
};
struct BsdfInput {
    uint32_t surface;
    glm::vec3 wo, given;
};
struct BsdfResult {
    glm::vec3 wi, weight;
    float pdf;
    uint32_t lobe;
    glm::vec3 value;
    float pdf_again;
    glm::vec3 value_swapped;
    glm::vec3 diffuse, specular, transmission;
};

class BsdfTest : public GpuTest {
protected:
    enum Kind : uint32_t { Sample, Evaluate, Furnace, Tables };
    std::string_view variant = "+LAYERS";

    std::vector<BsdfResult> run(Kind kind, const std::vector<BsdfSurface>& surfaces, const std::vector<BsdfInput>& inputs) {
        struct Push {
            uint64_t surfaces = 0, inputs = 0, results = 0, tables = 0;
            uint32_t kind, count;
        };
        const std::vector<uint32_t> words = bsdf_table_words();
        const auto count = static_cast<uint32_t>(inputs.size());
        const gpu::Buffer surface = upload<BsdfSurface>("surfaces", surfaces), input = upload<BsdfInput>("inputs", inputs), table = upload<uint32_t>("tables", words);
        const gpu::Buffer output(device(), "test/results", inputs.size() * sizeof(BsdfResult));
        Frame frame(device(), {}, test_shader_pack());
        frame.compute("device/bsdf", variant)
            .read("surfaces", surface)
            .read("inputs", input)
            .read("tables", table)
            .write("results", output)
            .push(Push{.kind = kind, .count = count})
            .over(count);
        frame.run();
        return download<BsdfResult>(output);
    }
    std::vector<BsdfResult> sample(const BsdfSurface& surface, glm::vec3 wo, uint32_t count) {
        return run(Sample, {surface}, with_random_numbers(BsdfInput{0, wo, {}}, count));
    }
    std::vector<BsdfResult> evaluate(const BsdfSurface& surface, glm::vec3 wo, const std::vector<glm::vec3>& directions) {
        std::vector<BsdfInput> inputs;
        for (const glm::vec3& wi : directions) inputs.push_back({0, wo, wi});
        return run(Evaluate, {surface}, inputs);
    }
};

}  // namespace parhelion::testing
