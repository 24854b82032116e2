// The environment's sampler: samples against their density, the density against what is integrated, and both against where a map's
// texels are. Light that no table knows of, a shift by half a texel, or sines that fail at the poles end here.
#include <cmath>
#include <map>
#include <numbers>

#include "image/image.h"
#include "support/light_samples.h"
#include "support/statistics.h"

namespace parhelion::testing::environment_sampling_test {
namespace {

constexpr double kPi = std::numbers::pi;

struct Map {
    const char* name;
    Environment environment;
};

Environment plain_map(uint32_t width, uint32_t height, float rotation, glm::vec3 radiance = glm::vec3(0.0f)) {
    Environment e{.width = width, .height = height, .scale = glm::vec3(1.0f), .rotation = rotation};
    e.radiance.assign(size_t(width) * height, radiance);
    return e;
}
Environment random_map(uint32_t width, uint32_t height, float rotation) {
    Environment e = plain_map(width, height, rotation);
    std::mt19937 random(width + height);
    for (glm::vec3& c : e.radiance) c = glm::vec3(float(random() % 1000), float(random() % 1000), float(random() % 1000)) * (random() % 4 == 0 ? 0.02f : 0.001f);
    return e;
}
// Dim, with two texels of 1e5 at the horizon.
Environment two_texel_sun() {
    Environment e = plain_map(64, 32, 0.7f, glm::vec3(1.0f));
    e.radiance[15 * 64 + 20] = e.radiance[15 * 64 + 21] = glm::vec3(1e5f);
    return e;
}
// Both poles bright.
Environment poles() {
    Environment e = plain_map(32, 16, 0.0f, glm::vec3(0.01f));
    for (uint32_t x = 0; x < 32; ++x) e.radiance[x] = e.radiance[15 * 32 + x] = glm::vec3(50.0f);
    return e;
}

const std::vector<Map>& maps() {
    static const std::vector<Map> all = {{"8x4", random_map(8, 4, 0.0f)},       {"13x7", random_map(13, 7, 2.1f)},        {"6x1", random_map(6, 1, -0.4f)},     {"1x1", random_map(1, 1, 1.0f)},
                                         {"1x5", random_map(1, 5, 0.0f)},       {"1200x600", random_map(1200, 600, 0.3f)}, {"two-texel sun", two_texel_sun()}, {"poles", poles()}};
    return all;
}

// The device's table is as large as the map, but no larger than this.
glm::uvec2 table_size(const Environment& e) { return {std::min(e.width, 1024u), std::min(e.height, 512u)}; }

// Written from Environment's definition: u = 0.5 along -Z, growing to the right; rotation about +Y, counter-clockwise from above.
glm::dvec3 direction_at(const Environment& e, double u, double v) {
    const double theta = kPi * v, right = 2 * kPi * (u - 0.5) - double(e.rotation);
    return {std::sin(theta) * std::sin(right), std::cos(theta), -std::sin(theta) * std::cos(right)};
}
glm::dvec2 place_of(const Environment& e, glm::dvec3 d) {
    const double turn = (std::atan2(d.x, -d.z) + double(e.rotation)) / (2 * kPi) + 0.5;
    return {turn - std::floor(turn), std::atan2(std::hypot(d.x, d.z), d.y) / kPi};
}
double luminance_at(const Environment& e, double u, double v) {
    const double x = u * e.width - 0.5, y = v * e.height - 0.5, left = std::floor(x), top = std::floor(y), fx = x - left, fy = y - top;
    const auto texel = [&](double i, double k) {
        const auto w = int64_t(e.width), column = (int64_t(i) % w + w) % w, row = std::clamp<int64_t>(int64_t(k), 0, int64_t(e.height) - 1);
        const glm::dvec3 c(e.radiance[size_t(row * w + column)]);
        return image::luminance(c.r, c.g, c.b);
    };
    return (1 - fy) * ((1 - fx) * texel(left, top) + fx * texel(left + 1, top)) + fy * ((1 - fx) * texel(left, top + 1) + fx * texel(left + 1, top + 1));
}

class EnvironmentSampling : public GpuTest {
protected:
    static constexpr uint32_t kSamples = 1 << 16;

    // Alone, so that a light's density is the environment's.
    static Stage& stage_of(const Map& map) {
        shared_device();
        static std::map<std::string, std::unique_ptr<Stage>> stages;
        std::unique_ptr<Stage>& stage = stages[map.name];
        if (!stage) {
            SceneEdit edit;
            edit.set_environment(map.environment);
            stage = std::make_unique<Stage>(make_scene(std::move(edit)));
        }
        return *stage;
    }
    // Of numbers by cell of the table, their sums over at most 32 x 32 groups of cells.
    static std::vector<double> grouped(const Environment& e, const std::vector<double>& cells) {
        const glm::uvec2 table = table_size(e), groups = glm::min(table, glm::uvec2(32));
        std::vector<double> out(size_t(groups.x) * groups.y);
        for (uint32_t y = 0; y < table.y; ++y)
            for (uint32_t x = 0; x < table.x; ++x) out[size_t(y * groups.y / table.y) * groups.x + x * groups.x / table.x] += cells[size_t(y) * table.x + x];
        return out;
    }
    static std::vector<double> counts_by_cell(const Environment& e, const std::vector<LightResult>& samples) {
        const glm::uvec2 table = table_size(e);
        std::vector<double> out(size_t(table.x) * table.y);
        for (const LightResult& r : samples) {
            const glm::uvec2 at(glm::min(place_of(e, glm::dvec3(r.wi)), 1 - 1e-12) * glm::dvec2(table));
            ++out[size_t(at.y) * table.x + at.x];
        }
        return out;
    }
    // What the map shows in each cell of the table, by points x points directions.
    static const std::vector<double>& light_by_cell(const Map& map) {
        static std::map<std::string, std::vector<double>> lights;
        std::vector<double>& out = lights[map.name];
        if (!out.empty()) return out;
        const Environment& e = map.environment;
        const glm::uvec2 table = table_size(e);
        const uint32_t points = table.x > 100 ? 4 : 64;
        out.resize(size_t(table.x) * table.y);
        for (uint32_t y = 0; y < table.y * points; ++y) {
            const double v = (y + 0.5) / (table.y * points), solid_angle = 2 * kPi / (table.x * points) * 2 * std::sin(kPi * v) * std::sin(0.5 * kPi / (table.y * points));
            for (uint32_t x = 0; x < table.x * points; ++x) out[size_t(y / points) * table.x + x / points] += solid_angle * luminance_at(e, (x + 0.5) / (table.x * points), v);
        }
        return out;
    }
    static double sum_of(const std::vector<double>& values) {
        double sum = 0;
        for (const double v : values) sum += v;
        return sum;
    }
    // Alpha 1e-4 a map: false alarm 0.08 % a test.
    static void expect_counts(const Map& map, const std::vector<double>& share_by_cell) {
        const Environment& e = map.environment;
        std::vector<double> expected = grouped(e, share_by_cell);
        for (double& share : expected) share *= kSamples;
        if (expected.size() < 2) return;
        const ChiSquare test = chi_square_test(grouped(e, counts_by_cell(e, samples_of(map))), expected);
        EXPECT_GE(test.p, 1e-4) << map.name << ": " << test.text;
    }
    static const std::vector<LightResult>& samples_of(const Map& map) {
        static std::map<std::string, std::vector<LightResult>> samples;
        std::vector<LightResult>& found = samples[map.name];
        if (found.empty()) found = sample_lights(stage_of(map), kSamples, 7);
        return found;
    }
    // The device's density, at one direction in each cell of the table, anywhere in it: it is constant there. By cell, times solid angle.
    static std::vector<double> density_by_cell(const Map& map) {
        const glm::uvec2 table = table_size(map.environment);
        std::mt19937 random(4);
        std::vector<glm::vec3> directions;
        for (uint32_t y = 0; y < table.y; ++y)
            for (uint32_t x = 0; x < table.x; ++x) {
                const glm::dvec2 in_cell = 0.02 + 0.96 * glm::dvec2(random() % 1000, random() % 1000) / 1000.0;
                directions.emplace_back(direction_at(map.environment, (x + in_cell.x) / table.x, (y + in_cell.y) / table.y));
            }
        const std::vector<LightResult> found = look_at_environment(stage_of(map), directions);
        std::vector<double> out(found.size());
        for (uint32_t i = 0; i < out.size(); ++i) {
            const uint32_t y = i / table.x;
            out[i] = double(found[i].pdf_environment) * 2 * kPi / table.x * (std::cos(kPi * y / table.y) - std::cos(kPi * (y + 1) / table.y));
        }
        return out;
    }
};

}  // namespace

TEST_F(EnvironmentSampling, samples_follow_radiance_times_solid_angle) {
    for (const Map& map : maps()) {
        std::vector<double> light = light_by_cell(map);
        const double total = sum_of(light);
        for (double& share : light) share /= total;
        expect_counts(map, light);
    }
}

TEST_F(EnvironmentSampling, samples_follow_their_density_which_integrates_to_one) {
    for (const Map& map : maps()) {
        const std::vector<double> density = density_by_cell(map);
        EXPECT_NEAR(sum_of(density), 1.0, 1e-4) << map.name;
        expect_counts(map, density);
    }
}

// No sample is spent where there is less light than the density says. Alias tables count in 2^-24 of a mean cell.
TEST_F(EnvironmentSampling, the_density_is_radiance_times_solid_angle_of_what_is_integrated) {
    for (const Map& map : maps()) {
        const std::vector<double> density = grouped(map.environment, density_by_cell(map)), light = grouped(map.environment, light_by_cell(map));
        const double total = sum_of(light);
        for (size_t i = 0; i < light.size(); ++i) ASSERT_NEAR(density[i], light[i] / total, 0.003 * light[i] / total + 1e-7 / double(light.size())) << map.name << ' ' << i;
    }
}

// But for directions on the border of two cells, which one function rounds into the one and the other into the other.
TEST_F(EnvironmentSampling, a_sample_has_the_density_that_its_direction_has) {
    for (const Map& map : maps()) {
        uint32_t different = 0;
        for (const LightResult& r : samples_of(map)) {
            ASSERT_NEAR(glm::length(r.wi), 1.0f, 1e-5f) << map.name;
            ASSERT_GT(r.pdf, 0.0f) << map.name;
            different += std::abs(r.pdf - r.pdf_environment) > 1e-5f * r.pdf;
        }
        EXPECT_LE(different, kSamples / (map.environment.width > 1000 ? 200u : 2000u)) << map.name;
    }
}

// The estimate of the whole sky's light, each sample radiance / density: where the table holds exactly what is shown, it has the
// least noise, and no direction that shines is missing. Four standard errors: false alarm 1e-4 a map.
TEST_F(EnvironmentSampling, samples_weighted_by_their_density_sum_up_to_all_light) {
    for (const Map& map : maps()) {
        std::vector<double> values;
        for (const LightResult& r : samples_of(map)) values.push_back(image::luminance(double(r.radiance.r), double(r.radiance.g), double(r.radiance.b)) / double(r.pdf));
        expect_mean(values, sum_of(light_by_cell(map)), 0.03, map.name);
    }
}

TEST_F(EnvironmentSampling, a_bright_texel_is_seen_exactly_where_it_is_and_sampled_where_it_is_seen) {
    for (const glm::uvec2 size : {glm::uvec2(16, 8), glm::uvec2(7, 5), glm::uvec2(1440, 720)})
        for (const float rotation : {0.0f, 0.9f}) {
            const glm::uvec2 bright = size * 2u / 7u;
            Environment e = plain_map(size.x, size.y, rotation);
            e.radiance[size_t(bright.y) * size.x + bright.x] = glm::vec3(100.0f);
            const Map map{.name = "one texel", .environment = e};
            SceneEdit edit;
            edit.set_environment(e);
            Stage stage(make_scene(std::move(edit)));
            const glm::dvec2 middle = (glm::dvec2(bright) + 0.5) / glm::dvec2(size), texel = 1.0 / glm::dvec2(size);
            // Full in the middle, half at the edges, gone at the neighbours' middles.
            const glm::dvec2 offsets[] = {{0, 0}, {0.5, 0}, {-0.5, 0}, {0, 0.5}, {0, -0.5}, {0.98, 0}, {-0.98, 0}, {0, 0.98}, {0, -0.98}, {1.02, 0}, {-1.02, 0}, {0, 1.02}, {0, -1.02}};
            const double shown[] = {100, 50, 50, 50, 50, 2, 2, 2, 2, 0, 0, 0, 0};
            std::vector<glm::vec3> directions;
            for (const glm::dvec2 offset : offsets) directions.emplace_back(direction_at(e, middle.x + offset.x * texel.x, middle.y + offset.y * texel.y));
            const std::vector<LightResult> seen = look_at_environment(stage, directions);
            // Devices read between texels in steps of 1/256; a float direction is good to 1e-7 rad, here to 1e-4 texels.
            for (size_t i = 0; i < seen.size(); ++i) EXPECT_NEAR(seen[i].radiance.g, shown[i], 0.5) << size.x << ' ' << rotation << ' ' << i;

            glm::dvec2 mean(0.0);
            double sum = 0;
            uint32_t dark = 0;
            for (const LightResult& r : sample_lights(stage, 1 << 14, 11)) {
                const glm::dvec2 at = (place_of(e, glm::dvec3(r.wi)) - middle) * glm::dvec2(size);
                ASSERT_LE(std::max(std::abs(at.x), std::abs(at.y)), size.x > 1024 ? 3.0 : 1.501);
                const double weight = double(r.radiance.g) / double(r.pdf);
                mean += weight * at;
                sum += weight;
                dark += r.radiance.g == 0.0f;
            }
            mean /= sum;
            // By 16384 samples with a spread of less than half a texel.
            EXPECT_NEAR(mean.x, 0.0, 0.03) << size.x << ' ' << rotation;
            EXPECT_NEAR(mean.y, 0.0, 0.03 + 0.3 / size.y) << size.x << ' ' << rotation;  // rows nearer to the horizon are longer
            EXPECT_LE(dark, size.x > 1024 ? 10000u : 6000u);
        }
}

TEST_F(EnvironmentSampling, straight_up_and_down_are_directions_like_others) {
    const Map& map = maps()[7];
    const std::vector<LightResult> seen = look_at_environment(stage_of(map), {{0.0f, 1.0f, 0.0f}, {0.0f, -1.0f, 0.0f}, {1e-20f, 1.0f, 0.0f}, {0.0f, -1.0f, 1e-6f}});
    for (const LightResult& r : seen) {
        EXPECT_NEAR(r.radiance.g, 50.0f, 0.01f);
        EXPECT_NEAR(r.pdf_environment, seen[0].pdf_environment, 1e-3f * r.pdf_environment);
        EXPECT_GT(r.pdf_environment, 0.1f);
    }
}

// A map without light is no emitter; its directions are black.
TEST_F(EnvironmentSampling, a_black_map_takes_no_samples_from_others) {
    SceneEdit edit;
    edit.set_environment(plain_map(8, 4, 0.0f));
    edit.add(Light{.kind = LightKind::Point, .intensity = 5.0f});
    Stage stage(make_scene(std::move(edit)));
    for (const LightResult& r : sample_lights(stage, 256, 12, {0.0f, 1.0f, 0.0f})) ASSERT_EQ(r.probability, 1.0f);
    EXPECT_EQ(stage.scene_gpu.stats().emitters, 1u);
}

}  // namespace parhelion::testing::environment_sampling_test
