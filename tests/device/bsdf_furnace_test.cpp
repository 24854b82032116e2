// The BSDF in a furnace: white surfaces give back what they get, whatever their roughness and layers; and the tables behind that.
#include <fmt/format.h>

#include "device/bsdf_device.h"

namespace parhelion::testing {
namespace {

constexpr float kRoughnesses[] = {0, 0.02f, 0.05f, 0.1f, 0.2f, 0.3f, 0.4f, 0.5f, 0.6f, 0.7f, 0.8f, 0.9f, 1};
constexpr float kCosines[] = {0.02f, 0.1f, 0.2f, 0.3f, 0.5f, 0.7f, 0.9f, 1};

class Furnace : public BsdfTest {
protected:
    struct Deviation {
        double low = 2, high = 0;
        std::string where_low, where_high;
    };
    // The albedo of every surface from every cosine, by `samples` points of low discrepancy.
    Deviation deviation(const std::vector<BsdfSurface>& surfaces, uint32_t samples, int channel = 0) {
        std::vector<BsdfInput> inputs;
        for (uint32_t s = 0; s < surfaces.size(); ++s)
            for (const float c : kCosines) inputs.push_back({s, direction(c, 0.7), glm::vec3(float(samples), 0, 0)});
        const std::vector<BsdfResult> results = run(Kind::Furnace, surfaces, inputs);
        Deviation out;
        for (size_t k = 0; k < results.size(); ++k) {
            const double albedo = double((results[k].diffuse + results[k].specular + results[k].transmission)[channel]) / samples;
            const BsdfSurface& s = surfaces[inputs[k].surface];
            const std::string where = fmt::format("{:.4f} at cosine {}: metallic {}, roughness {}, specular {}, coat {} of roughness {}, sheen {} of roughness {}", albedo, inputs[k].wo.z, s.metallic,
                                                  s.roughness, s.specular, s.coat, s.coat_roughness, s.sheen_color.x, s.sheen_roughness);
            EXPECT_TRUE(std::isfinite(albedo)) << where;
            if (albedo < out.low) out.low = albedo, out.where_low = where;
            if (albedo > out.high) out.high = albedo, out.where_high = where;
        }
        return out;
    }
    void expect_white(const std::vector<BsdfSurface>& surfaces, uint32_t samples = 1 << 14) {
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

}  // namespace parhelion::testing
