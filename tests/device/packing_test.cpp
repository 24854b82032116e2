// What the realtime renderer packs comes back within the errors that the packings state, and light > 0 never becomes 0.
#include <cmath>
#include <random>

#include <glm/glm.hpp>

#include "support/gpu_fixture.h"

namespace parhelion::testing::packing_test {
namespace {

class Packing : public GpuTest {
protected:
    static constexpr size_t kForms = 7;

    std::vector<glm::vec3> round_trip(const std::vector<glm::vec3>& values) {
        struct Push {
            uint64_t values = 0, unpacked = 0;
            uint32_t count;
        };
        const auto count = static_cast<uint32_t>(values.size());
        const gpu::Buffer input = upload<glm::vec3>("values", values), output(device(), "test/unpacked", values.size() * kForms * sizeof(glm::vec3));
        Frame frame(device(), {}, test_shader_pack());
        frame.compute("device/packing").read("values", input).write("unpacked", output).push(Push{.count = count}).over(count);
        frame.run();
        return download<glm::vec3>(output);
    }
};

TEST_F(Packing, comes_back_within_the_stated_errors) {
    std::mt19937 random(11);
    std::normal_distribution<float> normal;
    std::uniform_real_distribution<float> exponent(-36.0f, 36.0f);
    std::vector<glm::vec3> values = {{1, 0, 0}, {0, -1, 0}, {0, 0, -1}, {1, 1, -1}, {-1, -1, -1}, {1e-9f, 1, 1e9f}};
    while (values.size() < 20000) values.push_back(glm::vec3(normal(random), normal(random), normal(random)) * std::exp2(exponent(random)));
    const std::vector<glm::vec3> found = round_trip(values);
    glm::vec3 mean_error(0.0f);  // of rgbe8, which rounds at random
    for (size_t i = 0; i < values.size(); ++i) {
        const glm::vec3 x = glm::abs(values[i]), n = glm::normalize(values[i]);
        const glm::vec3* form = &found[kForms * i];
        const float largest = std::max({x.x, x.y, x.z}), clamped = std::min(largest, 65408.0f);
        for (int c = 0; c < 3; ++c) {
            ASSERT_LE(std::abs(form[0][c] - x[c]), x[c] * 0x1p-14f) << i;
            const float target = std::min(x[c], 65408.0f);
            ASSERT_LE(std::abs(form[1][c] - target), std::max(clamped * 0x1.01p-9f, 0x1p-25f)) << i;
            if (x[c] > 0.0f) ASSERT_LE(std::abs(std::log2(form[4][c] / std::clamp(x[c], 0x1p-40f, 0x1p40f))), 0.5f * 80.0f / 510.0f + 1e-3f) << i;
            else ASSERT_EQ(form[4][c], 0.0f) << i;
            ASSERT_LE(std::abs(form[5][c] - x[c]), largest * 0x1p-7f) << i;
            ASSERT_EQ(form[6][c], form[5][c]) << i;
        }
        mean_error += (form[5] - x) / largest / static_cast<float>(values.size());
        // Half a cell of the square, three times as long on the sphere at the worst place, and rounding.
        ASSERT_LE(glm::length(form[2] - n), 3.0f * 0.70711f / 32767.0f + 4e-7f) << i;
        ASSERT_LE(glm::length(form[3] - n), 3.0f * 0.70711f / 4095.0f * 2.0f + 4e-7f) << i;
    }
    for (int c = 0; c < 3; ++c) EXPECT_LT(std::abs(mean_error[c]), 6.0f * 0x1p-8f / std::sqrt(static_cast<float>(values.size()))) << "six standard errors at most: false alarms 1 in 10^8";
}

}  // namespace
}  // namespace parhelion::testing::packing_test
