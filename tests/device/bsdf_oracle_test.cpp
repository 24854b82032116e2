// Metals and coated diffuse surfaces against values that a separate implementation computed from the papers
// (tools/oracles/make_microfacet_values.py); glass is in glass_test.cpp.
#include <fstream>
#include <sstream>

#include <fmt/format.h>

#include "device/bsdf_device.h"

namespace parhelion::testing::bsdf_oracle_test {
namespace {

struct Point {
    std::string kind;
    BsdfSurface surface;
    glm::vec3 wo{}, wi{};
    glm::dvec3 f{};  // without the cosine
};

std::vector<Point> read_points() {
    std::ifstream file(std::string(PARHELION_SOURCE_DIR) + "/tests/golden/oracles/microfacet_values.tsv");
    std::vector<Point> points;
    std::string line;
    for (std::getline(file, line); std::getline(file, line);) {  // the first line is the heading
        std::istringstream row(line);
        Point p;
        BsdfSurface& s = p.surface;
        row >> p.kind >> s.compensate >> s.roughness >> s.ior >> s.base_color.x >> s.base_color.y >> s.base_color.z;
        row >> p.wo.x >> p.wo.y >> p.wo.z >> p.wi.x >> p.wi.y >> p.wi.z >> p.f.x >> p.f.y >> p.f.z;
        EXPECT_TRUE(row) << line;
        s.metallic = p.kind == "conductor" ? 1 : 0;
        if (p.kind == "conductor" || p.kind == "coated") points.push_back(p);
    }
    return points;
}

class BsdfOracle : public BsdfTest {};

}  // namespace

// What is computed directly agrees to rounding, coats to what their table holds. Light that scatters more than once is a product of
// differences 1 - E from the table, whose steps leave an absolute error: at roughness 0.2 that light is some hundredths of a percent of all.
TEST_F(BsdfOracle, values_are_those_of_a_separate_implementation) {
    const std::vector<Point> points = read_points();  // each pair of directions first without compensation, then with it
    ASSERT_EQ(points.size(), 240u);
    std::vector<BsdfSurface> surfaces;
    std::vector<BsdfInput> inputs;
    for (const Point& p : points) {
        inputs.push_back({static_cast<uint32_t>(surfaces.size()), p.wo, p.wi});
        surfaces.push_back(p.surface);
    }
    const std::vector<BsdfResult> results = run(Evaluate, surfaces, inputs);
    double worst_direct = 0, worst_coated = 0, worst_more = 0;  // relative; of light that scatters more than once, absolute
    for (size_t k = 0; k < points.size(); ++k) {
        const Point& p = points[k];
        const bool coated = p.kind == "coated", compensated = p.surface.compensate;
        ASSERT_EQ(compensated, k % 2 == 1);
        for (int c = 0; c < 3; ++c) {
            const double expected = p.f[c] * double(p.wi.z), more = compensated && !coated ? expected - points[k - 1].f[c] * double(p.wi.z) : 0;
            const double error = std::abs(double(results[k].value[c]) - expected);
            EXPECT_LE(error, (coated ? 3e-4 : 1e-5) * expected + 0.02 * more + (more > 0 ? 1.5e-4 : 0)) << fmt::format("{} of roughness {}, compensation {}, point {}, channel {}", p.kind, p.surface.roughness, compensated, k, c);
            double& worst = coated ? worst_coated : compensated ? worst_more : worst_direct;
            worst = std::max(worst, error / (more > 0 ? 1 : expected));
        }
    }
    fmt::print("worst deviation: metal {:.2g}, coated {:.2g}, light that scattered more than once {:.2g} (absolute)\n", worst_direct, worst_coated, worst_more);
}

}  // namespace parhelion::testing::bsdf_oracle_test
