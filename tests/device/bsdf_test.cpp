// The BSDF's triple sample / pdf / eval held against each other on the device, lobe by lobe and as a whole.
#include <numbers>

#include <fmt/format.h>

#include "device/bsdf_device.h"
#include "support/statistics.h"

namespace parhelion::testing::bsdf_test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr glm::vec3 kBrown{0.9f, 0.6f, 0.3f};

struct Named {
    const char* name;
    BsdfSurface surface;
};
const Named kSurfaces[] = {
    {"Lambert", {.base_color = kBrown, .roughness = 1, .specular = 0}},
    {"dielectric", {.base_color = kBrown, .roughness = 0.5f}},
    {"rough metal", {.base_color = kBrown, .metallic = 1, .roughness = 0.8f}},
    {"metal", {.base_color = kBrown, .metallic = 1, .roughness = 0.4f}},
    {"half metal", {.base_color = kBrown, .metallic = 0.5f, .roughness = 0.6f}},
    {"metal without compensation", {.base_color = kBrown, .metallic = 1, .roughness = 0.8f, .compensate = 0}},
    {"tinted dielectric", {.base_color = kBrown, .specular_color = {0.2f, 1.0f, 9.0f}, .roughness = 0.5f, .ior = 3, .specular = 0.8f}},
    {"specular colour alone", {.base_color = {0.5f, 0.3f, 0.2f}, .specular_color = {0.9f, 0.6f, 0.2f}, .roughness = 0.6f, .ior = 0}},
    {"Lambert under a mirror", {.base_color = kBrown, .roughness = 0}},
    {"coated dielectric", {.base_color = kBrown, .roughness = 0.5f, .coat = 1, .coat_roughness = 0.5f}},
    {"metal under a smooth coat", {.base_color = kBrown, .metallic = 1, .roughness = 0.6f, .coat = 0.7f}},
    {"coat with a normal of its own", {.base_color = kBrown, .coat_normal = glm::normalize(glm::vec3(0.3f, -0.2f, 1.0f)), .roughness = 0.5f, .coat = 1, .coat_roughness = 0.5f}},
    {"sheen over Lambert", {.base_color = kBrown, .sheen_color = {0.3f, 0.9f, 0.5f}, .specular = 0, .sheen_roughness = 0.5f}},
    {"everything", {.base_color = kBrown, .sheen_color = {0.8f, 0.4f, 0.6f}, .metallic = 0.4f, .roughness = 0.5f, .coat = 0.9f, .coat_roughness = 0.4f, .sheen_roughness = 0.7f}},
    {"glass and Lambert", {.base_color = kBrown, .roughness = 0.5f, .transmission = 0.6f}},
    {"coated glass from outside", {.base_color = kBrown, .specular_color = {0.3f, 1.0f, 0.6f}, .roughness = 0.4f, .transmission = 1, .coat = 1}},
    {"coated glass from inside", {.base_color = kBrown, .roughness = 0.5f, .transmission = 0.8f, .eta = 1 / 1.5f, .coat = 1, .coat_roughness = 0.4f, .inside = 1}},
    {"everything over a thin wall", {.base_color = kBrown, .sheen_color = {0.8f, 0.4f, 0.6f}, .metallic = 0.2f, .roughness = 0.5f, .transmission = 0.8f, .coat = 0.9f, .coat_roughness = 0.4f,
                                     .sheen_roughness = 0.7f, .thin = 1}},
};
constexpr float kCosines[] = {0.95f, 0.5f, 0.15f};

template <class Check>
void for_all(Check check) {
    for (const Named& s : kSurfaces)
        for (const float c : kCosines) {
            SCOPED_TRACE(fmt::format("{}, cosine {}", s.name, c));
            check(s.surface, direction(c, 0.9));
        }
}

}  // namespace

TEST_F(BsdfTest, a_weight_is_value_over_density) {
    for_all([&](const BsdfSurface& surface, glm::vec3 wo) {
        for (const BsdfResult& r : sample(surface, wo, 2048)) {
            if (r.lobe == kLobeNone || r.pdf < 0) continue;
            ASSERT_NEAR(glm::length(r.wi), 1.0f, 1e-5f);
            ASSERT_NEAR(r.pdf, r.pdf_again, 1e-5f * r.pdf);
            for (int c = 0; c < 3; ++c) {
                ASSERT_TRUE(std::isfinite(r.weight[c]) && r.weight[c] >= 0);
                ASSERT_NEAR(r.weight[c] * r.pdf, r.value[c], 1e-5f * r.value[c] + 1e-7f);
            }
        }
    });
}

// Samples in 32 x 16 cells of (cosine, azimuth) over the sphere against the density summed over 16 x 24 points a cell. Alpha 1e-4 each,
// 54 tests: false alarm 0.5 %. The density's integral is the share of samples that leave the surface, mirrors apart.
TEST_F(BsdfTest, samples_follow_their_density) {
    constexpr uint32_t kRows = 32, kColumns = 16, kFineRows = 24, kFineColumns = 16, kHeight = kRows * kFineRows, kWidth = kColumns * kFineColumns, kSamples = 1 << 15;
    std::vector<glm::vec3> grid(size_t(kHeight) * kWidth);
    for (uint32_t y = 0; y < kHeight; ++y)
        for (uint32_t x = 0; x < kWidth; ++x) grid[size_t(y) * kWidth + x] = direction(2 * (y + 0.5) / kHeight - 1, 2 * kPi * (x + 0.5) / kWidth);
    for_all([&](const BsdfSurface& surface, glm::vec3 wo) {
        std::vector<double> expected(kRows * kColumns), seen(kRows * kColumns);
        const std::vector<BsdfResult> densities = evaluate(surface, wo, grid);
        double integral = 0;
        for (uint32_t y = 0; y < kHeight; ++y)
            for (uint32_t x = 0; x < kWidth; ++x) {
                const double share = double(densities[size_t(y) * kWidth + x].pdf_again) * 4 * kPi / (double(kHeight) * kWidth);
                integral += share;
                expected[y / kFineRows * kColumns + x / kFineColumns] += share * kSamples;
            }
        EXPECT_LE(integral, 1.003);
        uint32_t left = 0;
        for (const BsdfResult& r : sample(surface, wo, kSamples)) {
            if (r.lobe == kLobeNone || r.pdf < 0) continue;
            ++left;
            const double turn = std::atan2(double(r.wi.y), double(r.wi.x)) / (2 * kPi);
            const auto column = static_cast<uint32_t>(std::min((turn < 0 ? turn + 1 : turn) * kColumns, kColumns - 1.0));
            const auto row = static_cast<uint32_t>(std::min((double(r.wi.z) + 1) / 2 * kRows, kRows - 1.0));
            ++seen[row * kColumns + column];
        }
        EXPECT_NEAR(integral, double(left) / kSamples, 0.012);
        const ChiSquare test = chi_square_test(seen, expected);
        EXPECT_GE(test.p, 1e-4) << test.text;
    });
}

TEST_F(BsdfTest, light_may_go_either_way) {
    std::mt19937 random(5);
    const auto unit = [&] { return static_cast<double>(random() >> 8) * 0x1p-24; };
    std::vector<glm::vec3> directions(2048);
    for (glm::vec3& d : directions) d = direction((0.02 + 0.98 * unit()) * (random() % 2 ? 1 : -1), 2 * kPi * unit());
    for_all([&](const BsdfSurface& surface, glm::vec3 wo) {
        if (surface.coat_normal.z < 1) return;  // its cosine is not the surface's: not reciprocal
        for (const BsdfResult& r : evaluate(surface, wo, directions))
            for (int c = 0; c < 3; ++c) {
                const float index2 = r.wi.z < 0 && !surface.thin ? surface.eta * surface.eta : 1.0f;  // values are of radiance
                const float there = r.value[c] / std::abs(r.wi.z) * index2, back = r.value_swapped[c] / wo.z;
                ASSERT_NEAR(there, back, 1e-3f * there + 1e-7f);
            }
    });
}

// Scenes without layered materials are drawn by the variant without them: it must say the same.
TEST_F(BsdfTest, without_layers_both_variants_of_the_shader_agree) {
    for (const Named& s : kSurfaces) {
        if (s.surface.coat > 0 || s.surface.transmission > 0 || s.surface.sheen_color != glm::vec3(0.0f)) continue;
        variant = "+LAYERS";
        const auto layered = sample(s.surface, direction(0.5, 1), 512);
        variant = "";
        const auto plain = sample(s.surface, direction(0.5, 1), 512);
        for (size_t i = 0; i < plain.size(); ++i) {
            ASSERT_EQ(plain[i].lobe, layered[i].lobe) << s.name;
            ASSERT_NEAR(plain[i].pdf, layered[i].pdf, 1e-5f * std::abs(plain[i].pdf)) << s.name;
            for (int c = 0; c < 3; ++c) ASSERT_NEAR(plain[i].weight[c], layered[i].weight[c], 1e-5f) << s.name;
        }
    }
}

// A mirror: one direction, no density, no value for light samples; the weight is reflectance over the share of samples.
TEST_F(BsdfTest, a_smooth_surface_is_an_exact_mirror) {
    const float kF0 = 0.04f;
    for (const float cosine : {1.0f, 0.7f, 0.3f, 0.05f}) {
        const glm::vec3 wo = direction(cosine, 0.4), there{-wo.x, -wo.y, wo.z};
        const double schlick = kF0 + (1 - kF0) * std::pow(1 - double(cosine), 5);
        for (const bool metal : {false, true}) {
            const BsdfSurface surface{.base_color = metal ? kBrown : glm::vec3(0.0f), .metallic = metal ? 1.0f : 0.0f, .roughness = 0.029f};
            for (const BsdfResult& r : sample(surface, wo, 64)) {
                ASSERT_LT(r.pdf, 0.0f);
                ASSERT_LE(glm::length(r.wi - there), 1e-6f);
                ASSERT_EQ(r.value, glm::vec3(0.0f));
                ASSERT_EQ(r.pdf_again, 0.0f);
                for (int c = 0; c < 3; ++c) ASSERT_NEAR(r.weight[c], metal ? kBrown[c] + (1 - kBrown[c]) * std::pow(1 - cosine, 5) : schlick, 1e-5);
            }
        }
        // Over Lambert the mirror is drawn with a share of all samples; weight times share is its reflectance.
        uint32_t mirrored = 0;
        double sum = 0;
        const auto results = sample({.base_color = kBrown, .roughness = 0}, wo, 1 << 15);
        for (const BsdfResult& r : results)
            if (r.pdf < 0) ++mirrored, sum += r.weight.x;
        // The share is at least 0.1: the count's relative standard error is at most 1.7 %; five of them.
        EXPECT_NEAR(sum / results.size(), schlick, 0.085 * schlick);
        EXPECT_GT(mirrored, results.size() / 12);
    }
}

// Any material in range, any direction: numbers that a picture can hold.
TEST_F(BsdfTest, no_input_in_range_gives_anything_but_numbers) {
    std::mt19937 random(23);
    const auto unit = [&] { return static_cast<float>(random() >> 8) * 0x1p-24f; };
    const auto one_of = [&](std::initializer_list<float> values) { return values.begin()[random() % values.size()]; };
    const auto color = [&] { return glm::vec3(one_of({0, 1, unit()}), one_of({0, 1, unit()}), one_of({0, 1, unit()})); };
    const auto anywhere = [&] { return direction(one_of({1e-6f, 1e-4f, unit(), 1}), 6.2831853 * unit()); };
    std::vector<BsdfSurface> surfaces(4096);
    std::vector<BsdfInput> draws, looks;
    for (uint32_t k = 0; k < surfaces.size(); ++k) {
        BsdfSurface& s = surfaces[k];
        s.base_color = color(), s.specular_color = color() * one_of({1, 20}), s.sheen_color = color() * one_of({0, 0, 1});
        s.metallic = one_of({0, 1, unit()}), s.roughness = one_of({0, 0.02f, 0.03f, 0.031f, 1, unit()}), s.ior = one_of({0, 1, 1.5f, 1 + 2 * unit()}), s.specular = one_of({0, 1, unit()});
        s.transmission = one_of({0, 1, unit()}), s.thin = random() % 2, s.compensate = random() % 2;
        s.eta = s.ior == 0 || random() % 2 ? s.ior : 1 / s.ior;
        s.coat = one_of({0, 1, unit()}), s.coat_roughness = one_of({0, 0.03f, 1, unit()}), s.sheen_roughness = one_of({0, 1, unit()});
        if (random() % 4 == 0) s.coat_normal = direction(0.3 + 0.7 * unit(), 6 * unit());
        for (int n = 0; n < 8; ++n) {
            draws.push_back({k, anywhere(), {unit(), unit(), unit()}});
            looks.push_back({k, anywhere(), anywhere() * glm::vec3(1, 1, random() % 4 == 0 ? -1 : 1)});
        }
    }
    const auto check = [&](const std::vector<BsdfResult>& results, const std::vector<BsdfInput>& inputs) {
        for (size_t k = 0; k < results.size(); ++k) {
            const BsdfResult& r = results[k];
            const BsdfSurface& s = surfaces[inputs[k].surface];
            SCOPED_TRACE(fmt::format("metallic {}, roughness {}, ior {}, specular {}, transmission {}, eta {}, thin {}, coat {} of roughness {}, sheen {} of roughness {}, cosine {} to {}", s.metallic,
                                     s.roughness, s.ior, s.specular, s.transmission, s.eta, s.thin, s.coat, s.coat_roughness, s.sheen_color.x, s.sheen_roughness, inputs[k].wo.z, r.wi.z));
            for (int c = 0; c < 3; ++c) {
                ASSERT_TRUE(std::isfinite(r.weight[c]) && r.weight[c] >= 0) << r.weight[c];
                ASSERT_TRUE(std::isfinite(r.value[c]) && r.value[c] >= 0) << r.value[c];
            }
            ASSERT_TRUE(std::isfinite(r.pdf) && std::isfinite(r.pdf_again) && r.pdf_again >= 0);
            ASSERT_TRUE(r.lobe == kLobeNone || std::abs(glm::length(r.wi) - 1.0f) < 1e-4f);
        }
    };
    check(run(Sample, surfaces, draws), draws);
    check(run(Evaluate, surfaces, looks), looks);
}

// The coat's own normal turns its mirror, and nothing else.
TEST_F(BsdfTest, a_coat_with_its_own_normal_reflects_about_it) {
    const glm::vec3 wo = direction(0.8, 0.4), n = glm::normalize(glm::vec3(0.2f, -0.1f, 1.0f)), there = 2 * glm::dot(wo, n) * n - wo;
    uint32_t mirrored = 0;
    for (const BsdfResult& r : sample({.base_color = kBrown, .coat_normal = n, .specular = 0, .coat = 1}, wo, 4096)) {
        if (r.pdf >= 0) continue;
        ++mirrored;
        ASSERT_LE(glm::length(r.wi - there), 1e-6f);
    }
    EXPECT_GT(mirrored, 4096u / 12);
}

}  // namespace parhelion::testing::bsdf_test
