// The shaders' random numbers, alias draws and warps on a device. The first two must equal the host's bits; warps are held
// against their densities.
#include <bit>
#include <cmath>
#include <numbers>

#include "lib/alias.glsl"
#include "sampling/alias_table.h"
#include "sampling/path_sampler.h"
#include "support/gpu_fixture.h"
#include "support/statistics.h"

namespace parhelion::testing::sampler_test {
namespace {

constexpr double kPi = std::numbers::pi;

struct NumbersPush {
    uint64_t sobol = 0, blue_noise = 0, numbers = 0;
    uint32_t count = 0;
};
struct AliasPush {
    uint64_t rows = 0, drawn = 0;
    uint32_t row_count = 0, count = 0;
};
struct WarpPush {
    uint64_t samples = 0;
    uint32_t shape = 0, count = 0;
    float opening = 0;
};
enum Shape : uint32_t { kTriangle, kDisk, kCosine, kSphere, kCone };

class SamplerDeviceTest : public GpuTest {
protected:
    std::vector<glm::vec4> warp(Shape shape, float opening = 0) {
        constexpr uint32_t kCount = 1 << 17;
        const gpu::Buffer samples(device(), "test/samples", kCount * sizeof(glm::vec4));
        Frame frame(device(), {}, test_shader_pack());
        frame.compute("device/sampler_warp").write("samples", samples).push(WarpPush{.shape = shape, .count = kCount, .opening = opening}).over(kCount);
        frame.run();
        return download<glm::vec4>(samples);
    }

    // `square(v)` maps a sample back to the unit square so that right samples are uniform there; 16 x 16 cells. Alpha 0.1 % a
    // shape: the seven below raise a false alarm with 0.7 %.
    template <class Square>
    void expect_uniform(const std::vector<glm::vec4>& samples, const Square& square) {
        std::vector<double> seen(256, 0.0);
        for (const glm::vec4& v : samples) {
            const glm::dvec2 u = glm::clamp(square(glm::dvec3(v)), 0.0, 0.999999);
            ++seen[static_cast<size_t>(u.x * 16) * 16 + static_cast<size_t>(u.y * 16)];
        }
        const ChiSquare test = chi_square_test(seen, std::vector<double>(256, static_cast<double>(samples.size()) / 256));
        EXPECT_GE(test.p, 0.001) << test.text;
    }
};

double turn(double y, double x) { return std::atan2(y, x) / (2 * kPi) + 0.5; }

TEST_F(SamplerDeviceTest, numbers_equal_the_host_bit_for_bit) {
    constexpr uint32_t kCount = 1 << 16;
    const gpu::Buffer sobol = upload<uint32_t>("sobol", sampling::sobol_table()), blue_noise = upload<uint32_t>("blue_noise", sampling::blue_noise_words());
    const gpu::Buffer numbers(device(), "test/numbers", kCount * 6 * sizeof(uint32_t));
    Frame frame(device(), {}, test_shader_pack());
    frame.compute("device/sampler_numbers").read("sobol", sobol).read("blue_noise", blue_noise).write("numbers", numbers).push(NumbersPush{.count = kCount}).over(kCount);
    frame.run();
    const std::vector<uint32_t> got = download<uint32_t>(numbers);
    for (uint32_t i = 0; i < kCount; ++i) {
        const glm::uvec4 keys = shared::pcg4d({i, 1, 2, 3});
        const glm::uvec2 pixel(keys.x & 8191u, keys.y & 8191u);
        const uint32_t sample_index = keys.z >> (keys.w & 31u), seed = i / 5;
        shared::PathSampler s = sampling::make_sampler(pixel, sample_index, seed, i % shared::kSamplerKindCount);
        shared::start_bounce(s, keys.w >> 28);
        const float a = shared::next_1d(s);
        const glm::vec2 b = shared::next_2d(s);
        const glm::vec2 c = shared::next_2d(s);
        const float d = shared::hash_alpha(shared::hash_ray(pixel, sample_index, seed, i % 9, i & 1), keys.x, i % 3, keys.y);
        const float want[6]{a, b.x, b.y, c.x, c.y, d};
        for (uint32_t k = 0; k < 6; ++k) ASSERT_EQ(got[6 * i + k], std::bit_cast<uint32_t>(want[k])) << "invocation " << i << ", number " << k;
    }
}

TEST_F(SamplerDeviceTest, alias_draws_equal_the_host_index_for_index) {
    constexpr uint32_t kCount = 1 << 16;
    for (const uint32_t row_count : {1u, 2u, 1000u, 300000u}) {
        std::vector<double> weights(row_count);
        for (uint32_t i = 0; i < row_count; ++i) weights[i] = i == 0 ? 1e5 : static_cast<double>(shared::pcg_hash(i) >> (i % 32));
        const sampling::AliasTable table(weights);
        std::vector<shared::AliasEntry> rows;
        for (uint32_t i = 0; i < row_count; ++i) rows.push_back({table.entries()[i].probability, table.entries()[i].alias, table.pmf()[i]});
        const gpu::Buffer on_device = upload<shared::AliasEntry>("rows", rows), drawn(device(), "test/drawn", kCount * sizeof(uint32_t));
        Frame frame(device(), {}, test_shader_pack());
        frame.compute("device/sampler_alias").read("rows", on_device).write("drawn", drawn).push(AliasPush{.row_count = row_count, .count = kCount}).over(kCount);
        frame.run();
        const std::vector<uint32_t> got = download<uint32_t>(drawn);
        for (uint32_t i = 0; i < kCount; ++i) {
            const glm::uvec4 random = shared::pcg4d({i, 4, 5, 6});
            const glm::vec2 u(shared::uint_to_unit_float(random.x), shared::uint_to_unit_float(random.y));
            ASSERT_EQ(got[i], shared::sample_alias(reinterpret_cast<uint64_t>(rows.data()), row_count, u)) << "invocation " << i << " of " << row_count << " rows";
        }
    }
}

TEST_F(SamplerDeviceTest, triangle_samples_are_uniform_and_inside) {
    const std::vector<glm::vec4> samples = warp(kTriangle);
    for (const glm::vec4& v : samples) {
        ASSERT_TRUE(v.x >= 0 && v.y >= 0 && v.x + v.y <= 1) << v.x << ' ' << v.y;
        ASSERT_FLOAT_EQ(v.w, 9.0f / (0.5f * 0.25f));  // distance^2 / (area x cosine)
    }
    // The share of the triangle nearer to vertex 0 is (x + y)^2.
    expect_uniform(samples, [](glm::dvec3 v) { return glm::dvec2((v.x + v.y) * (v.x + v.y), v.x / std::max(v.x + v.y, 1e-30)); });
}

TEST_F(SamplerDeviceTest, disk_samples_are_uniform_and_strictly_inside) {
    const std::vector<glm::vec4> samples = warp(kDisk);
    for (const glm::vec4& v : samples) {
        ASSERT_LE(std::hypot(v.x, v.y), 1.0f);
        ASSERT_FLOAT_EQ(v.w, static_cast<float>(1 / kPi));
    }
    expect_uniform(samples, [](glm::dvec3 v) { return glm::dvec2(v.x * v.x + v.y * v.y, turn(v.y, v.x)); });
}

TEST_F(SamplerDeviceTest, cosine_samples_have_their_density_and_never_lie_in_the_surface) {
    const std::vector<glm::vec4> samples = warp(kCosine);
    for (const glm::vec4& v : samples) {
        ASSERT_NEAR(glm::length(glm::vec3(v)), 1.0f, 1e-6f);
        ASSERT_GT(v.z, 0.0f);
        ASSERT_NEAR(v.w, v.z / kPi, 1e-7);
    }
    expect_uniform(samples, [](glm::dvec3 v) { return glm::dvec2(v.z * v.z, turn(v.y, v.x)); });
}

TEST_F(SamplerDeviceTest, sphere_samples_are_uniform) {
    const std::vector<glm::vec4> samples = warp(kSphere);
    for (const glm::vec4& v : samples) {
        ASSERT_NEAR(glm::length(glm::vec3(v)), 1.0f, 1e-6f);
        ASSERT_FLOAT_EQ(v.w, static_cast<float>(1 / (4 * kPi)));
    }
    expect_uniform(samples, [](glm::dvec3 v) { return glm::dvec2(0.5 + 0.5 * v.z, turn(v.y, v.x)); });
}

// Wider than a hemisphere, ordinary, and the sun's (half angle 0.265 degrees).
TEST_F(SamplerDeviceTest, cone_samples_are_uniform_down_to_the_size_of_the_sun) {
    for (const float opening : {1.3f, 0.1f, 1.07e-5f}) {
        const std::vector<glm::vec4> samples = warp(kCone, opening);
        for (const glm::vec4& v : samples) {
            ASSERT_NEAR(glm::length(glm::vec3(v)), 1.0f, 1e-6f);
            ASSERT_NEAR(v.w * 2 * kPi * opening, 1.0, 1e-6);
        }
        // 1 - cos by way of the sine where the cosine has no digits left.
        expect_uniform(samples, [opening](glm::dvec3 v) {
            const double sine_squared = v.x * v.x + v.y * v.y;
            const double one_minus_cos = v.z > 0.9 ? sine_squared / (1 + std::sqrt(1 - sine_squared)) : 1 - v.z;
            return glm::dvec2(one_minus_cos / opening, turn(v.y, v.x));
        });
    }
}

}  // namespace
}  // namespace parhelion::testing::sampler_test
