// Glass on the device: the triple sample / pdf / eval held against each other over the whole sphere, against Fresnel and Snell in
// closed form, and against a furnace that is everywhere.
#include <cmath>
#include <fstream>
#include <numbers>
#include <random>
#include <sstream>

#include <fmt/format.h>
#include <glm/glm.hpp>

#include "device/given_directions.h"
#include "scene_gpu/bsdf_tables.h"
#include "support/gpu_fixture.h"
#include "support/statistics.h"

namespace parhelion::testing::glass_test {
namespace {

constexpr double kPi = std::numbers::pi;

struct GlassInput {
    glm::vec3 wo, given{};
    glm::vec3 tint{1.0f};
    float roughness = 0, eta = 1.5f, specular = 1;
    uint32_t thin = 0, compensate = 0;
};
struct GlassResult {
    glm::vec3 wi, weight;
    float pdf;
    uint32_t delta;
    glm::vec3 value;
    float pdf_again;
    glm::vec3 value_swapped;
    glm::vec3 reflected, transmitted;
};

// Born and Wolf, section 1.5: reflectance of a smooth boundary; 1 where reflection is total.
double fresnel(double cos_o, double eta) {
    const double sin_i = std::sqrt(1 - cos_o * cos_o) / eta;
    if (sin_i >= 1) return 1;
    const double o = std::acos(cos_o), i = std::asin(sin_i);
    if (o < 1e-6) return std::pow((eta - 1) / (eta + 1), 2);
    const double s = std::sin(o - i) / std::sin(o + i), p = std::tan(o - i) / std::tan(o + i);
    return (s * s + p * p) / 2;
}

class GlassDevice : public GpuTest {
protected:
    enum Kind : uint32_t { Sample, Evaluate, Furnace };
    struct Push {
        uint64_t inputs = 0, results = 0, tables = 0;
        uint32_t kind, count;
    };
    std::vector<GlassResult> run(Kind kind, const std::vector<GlassInput>& inputs) {
        const auto count = static_cast<uint32_t>(inputs.size());
        const gpu::Buffer input = upload<GlassInput>("inputs", inputs), output(device(), "test/results", inputs.size() * sizeof(GlassResult));
        const gpu::Buffer tables = upload<uint32_t>("tables", bsdf_table_words());
        Frame frame(device(), {}, test_shader_pack());
        frame.compute("device/glass").read("inputs", input).read("tables", tables).write("results", output).push(Push{.kind = kind, .count = count}).over(count);
        frame.run();
        return download<GlassResult>(output);
    }
    std::vector<GlassResult> sample(const GlassInput& input, uint32_t count) { return run(Sample, with_random_numbers(input, count)); }
    template <class Check>
    static void for_all(Check check) {
        const GlassInput surfaces[] = {{.wo = {}, .roughness = 0.6f, .eta = 1.5f},
                                       {.wo = {}, .tint = {0.9f, 0.5f, 0.2f}, .roughness = 0.5f, .eta = 1 / 1.5f},
                                       {.wo = {}, .tint = {0.1f, 0.9f, 0.5f}, .roughness = 1.0f, .eta = 2.4f, .specular = 0.5f},
                                       {.wo = {}, .roughness = 0.8f, .eta = 1 / 2.4f, .specular = 0.7f},
                                       {.wo = {}, .tint = {0.9f, 0.5f, 0.2f}, .roughness = 0.5f, .eta = 1.5f, .thin = 1},
                                       {.wo = {}, .tint = glm::vec3(0.0f), .roughness = 0.7f, .eta = 1.33f},
                                       {.wo = {}, .roughness = 0.7f, .eta = 1.2f, .specular = 0.0f}};
        for (GlassInput surface : surfaces)
            for (const float cosine : {0.95f, 0.5f, 0.15f}) {
                surface.compensate = cosine < 0.9f ? 1 : 0;
                surface.wo = direction(cosine, 0.9);
                SCOPED_TRACE(fmt::format("roughness {}, eta {}{}{}, cosine {}", surface.roughness, surface.eta, surface.thin ? ", thin" : "", surface.compensate ? ", compensated" : "", cosine));
                check(surface);
            }
    }
};

}  // namespace

TEST_F(GlassDevice, a_weight_is_value_over_density) {
    for_all([&](const GlassInput& glass) {
        uint32_t across = 0;
        for (const GlassResult& r : sample(glass, 4096)) {
            if (r.pdf == 0) continue;
            across += r.wi.z < 0 ? 1 : 0;
            ASSERT_NEAR(glm::length(r.wi), 1.0f, 1e-5f);
            ASSERT_NEAR(r.pdf, r.pdf_again, 1e-5f * r.pdf);
            for (int c = 0; c < 3; ++c) {
                ASSERT_TRUE(std::isfinite(r.weight[c]) && r.weight[c] >= 0);
                ASSERT_NEAR(r.weight[c] * r.pdf, r.value[c], 1e-5f * r.value[c] + 1e-7f);
            }
        }
        EXPECT_EQ(across > 0, glass.tint != glm::vec3(0.0f));
    });
}

// Samples in 32 x 16 cells of (cosine, azimuth) over the sphere against the density summed over 16 x 16 points a cell. Alpha 1e-4
// each, 21 tests: false alarm 0.21 %. The density's integral is the share of samples that are not absorbed.
TEST_F(GlassDevice, samples_follow_their_density_over_the_sphere) {
    constexpr uint32_t kRows = 32, kColumns = 16, kFine = 16, kHeight = kRows * kFine, kWidth = kColumns * kFine, kSamples = 1 << 16;
    for_all([&](const GlassInput& glass) {
        std::vector<GlassInput> grid(size_t(kHeight) * kWidth, glass);
        for (uint32_t y = 0; y < kHeight; ++y)
            for (uint32_t x = 0; x < kWidth; ++x) grid[size_t(y) * kWidth + x].given = direction(2 * (y + 0.5) / kHeight - 1, 2 * kPi * (x + 0.5) / kWidth);
        std::vector<double> expected(kRows * kColumns), seen(kRows * kColumns);
        const std::vector<GlassResult> densities = run(Evaluate, grid);
        double integral = 0;
        for (uint32_t y = 0; y < kHeight; ++y)
            for (uint32_t x = 0; x < kWidth; ++x) {
                const double share = double(densities[size_t(y) * kWidth + x].pdf_again) * 4 * kPi / (double(kHeight) * kWidth);
                integral += share;
                expected[y / kFine * kColumns + x / kFine] += share * kSamples;
            }
        EXPECT_LE(integral, 1.003);
        uint32_t left = 0;
        for (const GlassResult& r : sample(glass, kSamples)) {
            if (r.pdf == 0) continue;
            ++left;
            const double turn = std::atan2(double(r.wi.y), double(r.wi.x)) / (2 * kPi);
            const auto column = static_cast<uint32_t>(std::min((turn < 0 ? turn + 1 : turn) * kColumns, kColumns - 1.0)), row = static_cast<uint32_t>(std::min((r.wi.z + 1.0) / 2 * kRows, kRows - 1.0));
            ++seen[row * kColumns + column];
        }
        EXPECT_NEAR(integral, double(left) / kSamples, 0.01);
        const ChiSquare test = chi_square_test(seen, expected);
        EXPECT_GE(test.p, 1e-4) << test.text;
    });
}

// Radiance over the square of the index is what is equal in both directions.
TEST_F(GlassDevice, light_may_go_either_way_but_for_the_square_of_the_index) {
    std::mt19937 random(5);
    const auto unit = [&] { return static_cast<float>(random() >> 8) * 0x1p-24f; };
    for_all([&](const GlassInput& glass) {
        std::vector<GlassInput> inputs(2048, glass);
        for (GlassInput& i : inputs) i.given = direction((0.02 + 0.98 * unit()) * (unit() < 0.5f ? -1 : 1), 2 * kPi * unit());
        uint32_t lit = 0;
        for (const GlassResult& r : run(Evaluate, inputs)) {
            const float index2 = r.wi.z < 0 && !glass.thin ? glass.eta * glass.eta : 1.0f;
            lit += r.wi.z < 0 && r.value.g > 0 ? 1 : 0;
            for (int c = 0; c < 3; ++c) {
                const float there = r.value[c] / std::abs(r.wi.z) * index2, back = r.value_swapped[c] / glass.wo.z;
                ASSERT_NEAR(there, back, 1e-3f * there + 1e-6f) << r.wi.z;
            }
        }
        EXPECT_EQ(lit > 20, glass.tint.g > 0);
    });
}

TEST_F(GlassDevice, smooth_glass_follows_fresnel_and_snell) {
    std::vector<GlassInput> inputs;
    for (const float eta : {1.05f, 1.5f, 2.5f, 3.0f, 1 / 1.05f, 1 / 1.5f, 1 / 2.5f, 1 / 3.0f})
        for (const float cosine : {1.0f, 0.9f, 0.7f, 0.4f, 0.1f, 0.01f})
            for (const float specular : {1.0f, 0.4f})
                for (const float u : {0.0f, 0.999999f}) inputs.push_back({.wo = direction(cosine, 2.0), .given = {u, 0, 0}, .tint = {0.5f, 1.0f, 0.8f}, .eta = eta, .specular = specular});
    const std::vector<GlassResult> results = run(Sample, inputs);
    for (size_t k = 0; k < inputs.size(); ++k) {
        const auto& [wo, given, tint, roughness, eta, specular, thin, compensate] = inputs[k];
        const GlassResult& r = results[k];
        SCOPED_TRACE(fmt::format("eta {}, cosine {}, specular {}", eta, wo.z, specular));
        const double f = fresnel(wo.z, eta), reflected = f == 1 ? 1 : specular * f, share = reflected / (reflected + (1 - reflected) * (0.2126 * tint.r + 0.7152 * tint.g + 0.0722 * tint.b));
        ASSERT_TRUE(r.delta);
        ASSERT_LT(r.pdf, 0.0f);
        ASSERT_EQ(r.value, glm::vec3(0.0f));
        ASSERT_EQ(r.pdf_again, 0.0f);
        ASSERT_NEAR(r.reflected.x, reflected, 2e-5);
        if (given.x == 0 || reflected == 1) {
            ASSERT_NEAR(glm::distance(r.wi, glm::vec3(-wo.x, -wo.y, wo.z)), 0.0f, 1e-6f);
            ASSERT_NEAR(r.weight.r, reflected / share, 2e-4);
        } else {
            const glm::dvec2 bent = -glm::dvec2(wo) / double(eta);  // Snell
            ASSERT_NEAR(glm::distance(r.wi, glm::vec3(bent, -std::sqrt(1 - glm::dot(bent, bent)))), 0.0f, 1e-5f);
            ASSERT_NEAR(r.weight.r, tint.r * (1 - reflected) / (1 - share) / (eta * eta), 1e-3 * r.weight.r);
            ASSERT_NEAR(r.weight.b / r.weight.r, tint.b / tint.r, 1e-5);
        }
    }
}

// Beyond the critical angle all light is reflected, however little `specular` reflects elsewhere; just before it some passes.
TEST_F(GlassDevice, reflection_is_total_from_the_critical_angle_on) {
    const float eta = 1 / 1.5f, critical = std::sqrt(1 - eta * eta);
    std::vector<GlassInput> inputs;
    for (const float cosine : {critical - 1e-4f, critical + 1e-4f, 0.01f}) inputs.push_back({.wo = direction(cosine, 1), .given = {0.999f, 0, 0}, .eta = eta, .specular = 0.1f});
    const std::vector<GlassResult> r = run(Sample, inputs);
    EXPECT_GT(r[0].wi.z, 0.0f);
    EXPECT_EQ(r[0].weight, glm::vec3(1.0f));
    EXPECT_LT(r[1].wi.z, 0.0f);
    EXPECT_LT(r[1].reflected.x, 0.1f);
    EXPECT_EQ(r[2].weight, glm::vec3(1.0f));
}

TEST_F(GlassDevice, equal_indices_let_light_straight_through) {
    for (const float roughness : {0.0f, 0.5f, 1.0f}) {
        const GlassResult r = run(Sample, {{.wo = direction(0.3, 1), .given = {0, 0.3f, 0.6f}, .tint = {0.2f, 0.4f, 0.8f}, .roughness = roughness, .eta = 1}})[0];
        EXPECT_LT(r.pdf, 0.0f);
        EXPECT_NEAR(glm::distance(r.wi, -direction(0.3, 1)), 0.0f, 1e-6f);
        EXPECT_NEAR(glm::distance(r.weight, glm::vec3(0.2f, 0.4f, 0.8f)), 0.0f, 1e-6f);
    }
}

TEST_F(GlassDevice, a_smooth_wall_reflects_and_lets_the_rest_pass_straight) {
    for (const float cosine : {1.0f, 0.5f, 0.1f}) {
        const GlassResult r = run(Sample, {{.wo = direction(cosine, 1), .given = {0.9f, 0.3f, 0.6f}, .tint = {0.2f, 0.4f, 0.8f}, .specular = 0.5f, .thin = 1}})[0];
        const double reflected = 0.5 * fresnel(cosine, 1.5);
        EXPECT_LT(r.pdf, 0.0f);
        EXPECT_GT(r.wi.z, 0.0f);
        EXPECT_NEAR(r.weight.r, reflected, 1e-5);
        EXPECT_NEAR(glm::distance(r.transmitted, glm::vec3(0.2f, 0.4f, 0.8f) * float(1 - reflected)), 0.0f, 1e-5f);
    }
    const GlassResult rough = run(Sample, {{.wo = direction(0.5, 1), .roughness = 0.5f, .thin = 1}})[0];
    EXPECT_EQ(rough.transmitted, glm::vec3(0.0f)) << "a rough wall scatters what it lets pass";
}

// What crosses a rough wall is what it reflects, mirrored: with F the reflectance at the microfacet, f_r (1 - F) = f_t F.
TEST_F(GlassDevice, a_rough_wall_scatters_alike_to_both_sides) {
    std::vector<GlassInput> inputs;
    for (const double z : {0.9, 0.5, 0.2, 0.05})
        for (const double side : {1.0, -1.0}) inputs.push_back({.wo = direction(0.6, 0), .given = direction(z * side, 2.5), .roughness = 0.7f, .thin = 1});
    const std::vector<GlassResult> r = run(Evaluate, inputs);
    for (size_t k = 0; k < inputs.size(); k += 2) {
        const double f = fresnel(glm::dot(inputs[k].wo, glm::normalize(inputs[k].wo + inputs[k].given)), 1.5);
        EXPECT_NEAR(r[k].value.r * (1 - f), r[k + 1].value.r * f, 1e-4 * r[k].value.r);
    }
}

// The furnace: what is lost when light may meet one microfacet only is given back. Reflected and transmitted light together, the
// square of the index taken off. Points of low discrepancy: no noise to speak of.
TEST_F(GlassDevice, no_glass_loses_or_makes_light) {
    std::vector<GlassInput> inputs;
    for (const uint32_t thin : {0u, 1u})
        for (const float specular : {1.0f, 0.4f})
            for (const float eta : {1.05f, 1.1f, 1.33f, 1.5f, 2.0f, 2.5f})
                for (const bool leaving : {false, true})
                    for (const float roughness : {0.0f, 0.02f, 0.05f, 0.1f, 0.2f, 0.3f, 0.4f, 0.5f, 0.6f, 0.7f, 0.8f, 0.9f, 1.0f})
                        for (const float cosine : {0.02f, 0.05f, 0.1f, 0.3f, 0.5f, 0.7f, 0.9f, 1.0f}) {
                            if (thin && (leaving || roughness < 0.03f)) continue;
                            inputs.push_back({.wo = direction(cosine, 1), .given = {8192, 0, 0}, .roughness = roughness, .eta = leaving ? 1 / eta : eta, .specular = specular, .thin = thin, .compensate = 1});
                        }
    const std::vector<GlassResult> results = run(Furnace, inputs);
    double worst = 0;
    for (size_t k = 0; k < inputs.size(); ++k) {
        const GlassInput& i = inputs[k];
        const double all = double(results[k].reflected.x) + double(results[k].transmitted.x);
        worst = std::max(worst, std::abs(all - 1));
        EXPECT_NEAR(all, 1.0, 0.005) << fmt::format("roughness {}, eta {}, cosine {}, specular {}{}", i.roughness, i.eta, i.wo.z, i.specular, i.thin ? ", thin" : "");
    }
    RecordProperty("worst", fmt::format("{:.5f}", worst));
}

// The values that someone else computed from the papers (tools/oracles/make_microfacet_values.py).
TEST_F(GlassDevice, values_are_those_of_a_separate_implementation) {
    std::ifstream file(std::string(PARHELION_SOURCE_DIR) + "/tests/golden/oracles/microfacet_values.tsv");
    std::vector<GlassInput> inputs;
    std::vector<double> expected;
    for (std::string line; std::getline(file, line);) {
        std::istringstream row(line);
        std::string kind;
        double compensation, roughness, eta;
        glm::dvec3 colour, wo, wi, f;
        row >> kind >> compensation >> roughness >> eta >> colour.x >> colour.y >> colour.z >> wo.x >> wo.y >> wo.z >> wi.x >> wi.y >> wi.z >> f.x;
        if (kind != "glass") continue;
        inputs.push_back({.wo = glm::vec3(wo), .given = glm::vec3(wi), .roughness = float(roughness), .eta = float(eta)});
        expected.push_back(f.x * std::abs(wi.z));
    }
    ASSERT_GE(inputs.size(), 50u);
    const std::vector<GlassResult> results = run(Evaluate, inputs);
    for (size_t k = 0; k < inputs.size(); ++k) EXPECT_NEAR(results[k].value.r, expected[k], 1e-3 * expected[k] + 1e-6) << k;
}

TEST_F(GlassDevice, albedos_are_those_of_a_separate_implementation) {
    std::ifstream file(std::string(PARHELION_SOURCE_DIR) + "/tests/golden/oracles/microfacet_albedos.tsv");
    std::vector<GlassInput> inputs;
    std::vector<double> expected;
    std::string line;
    for (std::getline(file, line); std::getline(file, line);) {  // the first line is the heading
        std::istringstream row(line);
        double roughness, mu, skipped, reflected, transmitted;
        row >> roughness >> mu >> skipped >> skipped >> skipped >> skipped;
        for (const float eta : {1.5f, 1 / 1.5f}) {
            row >> reflected >> transmitted;
            inputs.push_back({.wo = direction(mu, 1), .given = {65536, 0, 0}, .roughness = float(roughness), .eta = eta});
            expected.insert(expected.end(), {reflected, transmitted});
        }
    }
    ASSERT_GE(inputs.size(), 50u);
    const std::vector<GlassResult> results = run(Furnace, inputs);
    for (size_t k = 0; k < inputs.size(); ++k) {
        const std::string what = fmt::format("roughness {}, eta {}, cosine {}", inputs[k].roughness, inputs[k].eta, inputs[k].wo.z);
        EXPECT_NEAR(results[k].reflected.x, expected[2 * k], 0.003) << what;
        EXPECT_NEAR(results[k].transmitted.x, expected[2 * k + 1], 0.003) << what;
    }
}

// Everything in range, and a little beyond, gives finite numbers that are not negative.
TEST_F(GlassDevice, nothing_breaks_at_the_edges) {
    std::mt19937 random(3);
    const auto pick = [&](std::initializer_list<float> values) { return values.begin()[random() % values.size()]; };
    std::vector<GlassInput> inputs(1 << 16);
    for (GlassInput& i : inputs) {
        i = {.wo = direction(pick({1.0f, 0.5f, 1e-2f, 1e-4f, 1e-6f}), pick({0.0f, 1.0f, 3.14159265f})), .tint = glm::vec3(pick({0.0f, 1.0f})), .roughness = pick({0.0f, 0.03f, 0.031f, 0.2f, 0.6f, 1.0f}),
             .eta = pick({1.0f, 1.0001f, 1.002f, 0.998f, 1.5f, 0.6666667f, 3.0f, 0.3333333f, 0.0f, INFINITY}), .specular = pick({0.0f, 0.3f, 1.0f}), .thin = static_cast<uint32_t>(random() % 2), .compensate = static_cast<uint32_t>(random() % 2)};
        i.given = {pick({0.0f, 0.5f, 0.99999994f}), pick({0.0f, 0.25f, 0.99999994f}), pick({0.0f, 0.5f, 0.99999994f})};
    }
    const auto check = [&](Kind kind) {
        for (const GlassResult& r : run(kind, inputs))
            for (const float v : {r.weight.r, r.weight.g, r.value.r, r.value.b, r.pdf_again, r.value_swapped.r, r.reflected.r, r.transmitted.r, std::abs(r.wi.z)})
                ASSERT_TRUE(std::isfinite(v) && v >= 0);
    };
    check(Sample);
    for (GlassInput& i : inputs) i.given = direction(pick({1.0f, 0.5f, 1e-2f, 1e-4f, 1e-6f}) * pick({1.0f, -1.0f}), pick({0.0f, 1.0f, 3.14159265f}));
    check(Evaluate);
}

}  // namespace parhelion::testing::glass_test
