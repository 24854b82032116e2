// The BSDF's triple at length: a million samples of every lobe and stack at five roughnesses and five angles against their density in 80 x 160
// cells, the density's integral, and weights (what tests/device/bsdf_test.cpp looks at in passing).
#include <numbers>

#include <fmt/format.h>

#include "device/bsdf_device.h"
#include "support/statistics.h"

namespace parhelion::testing::bsdf_test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr uint32_t kRows = 80, kColumns = 160, kSamples = 1'000'000;
constexpr float kRoughnesses[] = {0.25f, 0.4f, 0.6f, 0.8f, 1.0f};
constexpr float kCosines[] = {0.98f, 0.8f, 0.5f, 0.2f, 0.06f};

struct Stack {
    const char* name;
    BsdfSurface surface;
};
const Stack kStacks[] = {
    {"dielectric", {}},
    {"metal", {.metallic = 1}},
    {"half metal of index 2", {.metallic = 0.5f, .ior = 2}},
    {"coat over a dielectric", {.coat = 1}},
    {"sheen over a dielectric", {.sheen_color = glm::vec3(0.8f)}},
    {"everything opaque", {.sheen_color = glm::vec3(0.5f), .metallic = 0.3f, .coat = 0.7f}},
    {"glass from outside", {.transmission = 1, .eta = 1.5f}},
    {"glass from inside", {.transmission = 1, .eta = 1 / 1.5f, .inside = 1}},
    {"thin wall", {.transmission = 1, .thin = 1}},
    {"coated glass from inside", {.transmission = 0.8f, .eta = 1 / 1.5f, .coat = 1, .inside = 1}},
};

class BsdfAtLength : public BsdfTest {
protected:
    // Directions over the sphere, `fine_rows` x `fine_columns` a cell. Rows of equal angles: lobes about the normal are narrow in the cosine.
    struct Grid {
        uint32_t fine_rows, fine_columns, height = kRows * fine_rows, width = kColumns * fine_columns;
        double angle(double row) const { return kPi * row / height; }
        std::vector<glm::vec3> directions() const {
            std::vector<glm::vec3> out(size_t(height) * width);
            for (uint32_t y = 0; y < height; ++y)
                for (uint32_t x = 0; x < width; ++x) out[size_t(y) * width + x] = direction(std::cos(angle(y + 0.5)), 2 * kPi * (x + 0.5) / width);
            return out;
        }
    };
    static size_t cell_of(glm::vec3 w) {
        const double turn = std::atan2(double(w.y), double(w.x)) / (2 * kPi), angle = std::acos(std::clamp(double(w.z), -1.0, 1.0));
        const auto column = static_cast<size_t>(std::min((turn < 0 ? turn + 1 : turn) * kColumns, kColumns - 1.0));
        return static_cast<size_t>(std::min(angle / kPi * kRows, kRows - 1.0)) * kColumns + column;
    }
    void check(const BsdfSurface& surface, glm::vec3 wo, const Grid& grid, const std::vector<glm::vec3>& directions) {
        std::vector<double> expected(size_t(kRows) * kColumns), seen(expected.size());
        const std::vector<BsdfResult> densities = evaluate(surface, wo, directions);
        double integral = 0;
        for (uint32_t y = 0; y < grid.height; ++y) {
            const double solid_angle = (std::cos(grid.angle(y)) - std::cos(grid.angle(y + 1.0))) * 2 * kPi / grid.width;
            for (uint32_t x = 0; x < grid.width; ++x) {
                const double share = double(densities[size_t(y) * grid.width + x].pdf_again) * solid_angle;
                integral += share;
                expected[size_t(y / grid.fine_rows) * kColumns + x / grid.fine_columns] += share * kSamples;
            }
        }
        uint32_t left = 0;
        double worst = 0;
        for (const BsdfResult& r : sample(surface, wo, kSamples)) {
            if (r.lobe == kLobeNone || r.pdf < 0) continue;
            ++left;
            ++seen[cell_of(r.wi)];
            for (int c = 0; c < 3; ++c) worst = std::max(worst, std::abs(double(r.weight[c]) * r.pdf - r.value[c]) / (double(r.value[c]) + 1e-5));
        }
        const double share = double(left) / kSamples, noise = std::sqrt(share * (1 - share) / kSamples);
        EXPECT_LE(worst, 1e-3);
        EXPECT_LE(integral, 1.001);
        EXPECT_NEAR(integral, share, 1e-3 + 4 * noise);
        const ChiSquare test = chi_square_test(seen, expected);
        EXPECT_GE(test.p, sidak(0.01, std::size(kStacks) * std::size(kRoughnesses) * std::size(kCosines))) << test.text;
    }
};

// False alarm: 1 % for all by the cells, 6e-5 each by the integral.
TEST_F(BsdfAtLength, a_million_samples_follow_their_density) {
    for (const float cosine : kCosines) {
        const Grid grid = cosine < 0.1f ? Grid{24, 12} : Grid{8, 6};  // lobes seen at grazing angles are the narrowest
        const std::vector<glm::vec3> directions = grid.directions();
        for (const Stack& stack : kStacks)
            for (const float roughness : kRoughnesses) {
                SCOPED_TRACE(fmt::format("{}, roughness {}, cosine {}", stack.name, roughness, cosine));
                BsdfSurface surface = stack.surface;
                surface.roughness = surface.coat_roughness = surface.sheen_roughness = roughness;
                check(surface, direction(cosine, 0.9), grid, directions);
            }
    }
}

}  // namespace
}  // namespace parhelion::testing::bsdf_test
