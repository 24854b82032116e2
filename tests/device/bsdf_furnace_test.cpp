// The BSDF in a furnace: white surfaces give back what they get, whatever their roughness and layers; and the tables behind that.
#include <fmt/format.h>

#include "device/bsdf_device.h"

namespace parhelion::testing::bsdf_furnace_test {
namespace {

constexpr float kRoughnesses[] = {0, 0.02f, 0.1f, 0.2f, 0.3f, 0.4f, 0.5f, 0.6f, 0.7f, 0.8f, 0.9f, 1};
constexpr float kCosines[] = {0.02f, 0.1f, 0.2f, 0.3f, 0.5f, 0.7f, 0.9f, 1};

// Albedo of the white GGX lobe, and with the weight (1 - cos_h)^5: its value (Walter et al. 2007; Heitz 2014) summed over directions,
// closest together around the mirror's azimuth and at grazing angles.
std::pair<double, double> brute_force(double cos_o, double roughness) {
    constexpr int kSide = 700;
    constexpr double kPi = 3.14159265358979;
    const double alpha = roughness * roughness, sin_o = std::sqrt(1 - cos_o * cos_o);
    const auto lambda = [&](double c) { return (std::sqrt(1 + alpha * alpha * (1 / (c * c) - 1)) - 1) / 2; };
    double all = 0, grazing = 0;
    for (int a = 0; a < kSide; ++a) {
        const double t = (a + 0.5) / kSide, cos_i = t * t, sin_i = std::sqrt(1 - cos_i * cos_i), visible = 1 / (1 + lambda(cos_o) + lambda(cos_i)) / (4 * cos_o);
        for (int b = 0; b < kSide; ++b) {
            const double x = (b + 0.5) / kSide, phi = kPi * x * x, cos_oi = cos_o * cos_i - sin_o * sin_i * std::cos(phi), cos_h = std::sqrt((1 + cos_oi) / 2), cos_m = (cos_o + cos_i) / (2 * cos_h);
            const double d = cos_m * cos_m * (alpha * alpha - 1) + 1, value = alpha * alpha / (kPi * d * d) * visible * (2 * t * 4 * kPi * x) / (double(kSide) * kSide);
            all += value;
            grazing += value * std::pow(1 - cos_h, 5);
        }
    }
    return {all, grazing};
}

class Furnace : public BsdfTest {
protected:
    struct Deviation {
        double low = 2, high = 0;
        std::string where_low, where_high;
    };
    // The albedo of every surface from every cosine, by `samples` points of low discrepancy in each set of directions.
    Deviation deviation(const std::vector<BsdfSurface>& surfaces, uint32_t samples, int channel = 0) {
        std::vector<BsdfInput> inputs;
        for (uint32_t s = 0; s < surfaces.size(); ++s)
            for (const float c : kCosines) inputs.push_back({s, direction(c, 0.7), glm::vec3(float(samples), 0, 0)});
        const std::vector<BsdfResult> results = run(Kind::Furnace, surfaces, inputs);
        Deviation out;
        for (size_t k = 0; k < results.size(); ++k) {
            const double albedo = double((results[k].diffuse + results[k].specular + results[k].transmission)[channel]);
            const BsdfSurface& s = surfaces[inputs[k].surface];
            const std::string where = fmt::format("{:.4f} at cosine {}: metallic {}, roughness {}, specular {}, coat {} of roughness {}, sheen {} of roughness {}, transmission {} ({}{}, index {})", albedo,
                                                  inputs[k].wo.z, s.metallic, s.roughness, s.specular, s.coat, s.coat_roughness, s.sheen_color.x, s.sheen_roughness, s.transmission,
                                                  s.thin ? "thin" : "body", s.inside ? ", inside" : "", s.eta);
            EXPECT_TRUE(std::isfinite(albedo)) << where;
            if (albedo < out.low) out.low = albedo, out.where_low = where;
            if (albedo > out.high) out.high = albedo, out.where_high = where;
        }
        return out;
    }
    void expect_white(const std::vector<BsdfSurface>& surfaces, uint32_t samples = 1 << 12) {
        const Deviation d = deviation(surfaces, samples);
        EXPECT_GE(d.low, 0.995) << d.where_low;
        EXPECT_LE(d.high, 1.005) << d.where_high;
        RecordProperty("lowest", d.where_low);
        RecordProperty("highest", d.where_high);
    }
    static std::vector<BsdfSurface> over_roughness(BsdfSurface surface) {
        std::vector<BsdfSurface> out;
        for (const float r : kRoughnesses) {
            surface.roughness = r;
            out.push_back(surface);
        }
        return out;
    }
};

}  // namespace

TEST_F(Furnace, a_white_metal_is_white) { expect_white(over_roughness({.metallic = 1})); }
TEST_F(Furnace, a_white_dielectric_is_white) {
    expect_white(over_roughness({}));
    expect_white(over_roughness({.ior = 2.5f, .specular = 0.7f}));
    expect_white(over_roughness({.ior = 0}));
}
TEST_F(Furnace, half_a_metal_is_white) { expect_white(over_roughness({.metallic = 0.5f})); }
TEST_F(Furnace, a_coated_surface_is_white) {
    for (const float metallic : {0.0f, 1.0f})
        for (const float coat_roughness : {0.0f, 0.1f, 0.4f, 1.0f}) expect_white(over_roughness({.metallic = metallic, .coat = 1, .coat_roughness = coat_roughness}));
}
TEST_F(Furnace, a_surface_with_sheen_is_white) {
    for (const float metallic : {0.0f, 1.0f})
        for (const float sheen_roughness : {0.0f, 0.15f, 0.4f, 1.0f}) expect_white(over_roughness({.sheen_color = glm::vec3(1.0f), .metallic = metallic, .sheen_roughness = sheen_roughness}));
}
TEST_F(Furnace, the_whole_stack_is_white) {
    for (const float metallic : {0.0f, 0.5f, 1.0f})
        for (const float r : {0.0f, 0.3f, 1.0f})
            expect_white(over_roughness({.sheen_color = glm::vec3(1.0f), .metallic = metallic, .coat = 0.8f, .coat_roughness = r, .sheen_roughness = std::max(0.2f, 1 - r)}));
}

// Glass under layers: nothing that crosses or is turned back is lost, from outside and from within.
TEST_F(Furnace, coated_glass_is_white) {
    const BsdfSurface coated{.transmission = 1, .coat = 1}, rough_coat{.transmission = 1, .coat = 1, .coat_roughness = 0.5f}, velvet{.sheen_color = glm::vec3(1.0f), .transmission = 1, .sheen_roughness = 0.3f};
    const BsdfSurface mixed{.sheen_color = glm::vec3(0.5f), .metallic = 0.2f, .transmission = 0.6f, .coat = 0.7f, .coat_roughness = 0.2f, .sheen_roughness = 0.4f};
    std::vector<BsdfSurface> surfaces;
    const auto add = [&](BsdfSurface s, std::initializer_list<float> roughnesses) {
        for (const float r : roughnesses)
            for (const bool inside : {false, true}) {
                s.roughness = r, s.inside = inside, s.eta = inside ? 1 / 1.5f : 1.5f;
                surfaces.push_back(s);
            }
    };
    add(coated, {0.02f, 0.1f, 0.25f, 0.6f, 1.0f});
    add(rough_coat, {0.02f, 0.4f});
    add(velvet, {0.1f, 0.5f});
    add(mixed, {0.02f, 0.1f, 0.8f});
    expect_white(surfaces, 1 << 14);
}
// Where the volume behind is the rarer one, narrow lobes under sheen lose a little at grazing angles; nothing gains.
TEST_F(Furnace, coated_bubbles_give_back_what_they_get) {
    const Deviation d = deviation({{.roughness = 0.2f, .transmission = 1, .eta = 1 / 1.5f, .coat = 1},
                                   {.roughness = 0.3f, .transmission = 1, .eta = 1.5f, .coat = 1, .inside = 1},
                                   {.sheen_color = glm::vec3(1.0f), .roughness = 0.15f, .transmission = 1, .eta = 1 / 1.5f, .sheen_roughness = 0.2f},
                                   {.sheen_color = glm::vec3(1.0f), .roughness = 0.15f, .transmission = 1, .eta = 1.5f, .sheen_roughness = 0.2f, .inside = 1}},
                                  1 << 14);
    EXPECT_GE(d.low, 0.98) << d.where_low;
    EXPECT_LE(d.high, 1.01) << d.where_high;
}
TEST_F(Furnace, a_coated_wall_of_glass_is_white) {
    for (const float roughness : {0.0f, 0.3f, 1.0f}) {
        expect_white(over_roughness({.transmission = 1, .coat = 1, .coat_roughness = roughness, .thin = 1}), 1 << 14);
        expect_white(over_roughness({.sheen_color = glm::vec3(1.0f), .transmission = 1, .sheen_roughness = std::max(roughness, 0.3f), .thin = 1}), 1 << 14);
    }
}

// Coloured and lossy surfaces return no more than they get either, from any direction.
TEST_F(Furnace, no_surface_returns_more_than_it_gets) {
    std::vector<BsdfSurface> surfaces;
    std::mt19937 random(3);
    const auto unit = [&] { return static_cast<float>(random() >> 8) * 0x1p-24f; };
    for (int k = 0; k < 64; ++k) {
        BsdfSurface s;
        s.base_color = glm::vec3(unit() < 0.5f ? 1.0f : unit());
        s.metallic = unit(), s.roughness = unit(), s.ior = 1 + 2 * unit(), s.specular = unit(), s.coat = unit(), s.coat_roughness = unit(), s.sheen_roughness = unit();
        s.specular_color = s.sheen_color = glm::vec3(unit());
        s.compensate = random() % 2;
        surfaces.push_back(s);
    }
    const Deviation d = deviation(surfaces, 1 << 12);
    EXPECT_LE(d.high, 1.01) << d.where_high;
}

TEST_F(Furnace, without_compensation_a_rough_metal_loses_what_bounces_twice) {
    const std::vector<BsdfSurface> surfaces{{.metallic = 1, .roughness = 1, .compensate = 0}};
    const Deviation d = deviation(surfaces, 1 << 12);
    EXPECT_NEAR(d.low, brute_force(1, 1).first, 0.003);  // straight down is where it loses most
}

// The tables against brute force by another way of sampling, on the host.
TEST_F(Furnace, the_tables_of_albedos_agree_with_brute_force) {
    std::vector<BsdfInput> inputs;
    for (const float cosine : {0.07f, 0.21f, 0.47f, 0.83f, 0.93f})
        for (const float roughness : {0.13f, 0.183f, 0.29f, 0.52f, 0.77f, 1.0f}) inputs.push_back({0, {}, {cosine, roughness, 0}});
    const std::vector<BsdfResult> results = run(Kind::Tables, {{}}, inputs);
    for (size_t k = 0; k < results.size(); ++k) {
        const auto [all, grazing] = brute_force(inputs[k].given.x, inputs[k].given.y);
        EXPECT_NEAR(1 - results[k].value.x, all, 1e-3) << "cosine " << inputs[k].given.x << ", roughness " << inputs[k].given.y;
        EXPECT_NEAR(results[k].value.y, grazing, 1e-3) << "cosine " << inputs[k].given.x << ", roughness " << inputs[k].given.y;
    }
}

}  // namespace parhelion::testing::bsdf_furnace_test
