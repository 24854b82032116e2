// Pictures by a stranger: Mitsuba 3's of the same glTF files, where its models are ours (tools/oracles/make_mitsuba_oracles.py), and with
// rough surfaces written for it from the papers (rough_*: tools/oracles/make_microfacet_oracles.py).
#include <algorithm>
#include <cmath>
#include <numbers>

#include "image/decode.h"
#include "scene/load.h"
#include "support/render_fixture.h"
#include "support/statistics.h"

namespace parhelion::testing {
namespace {

const std::filesystem::path kFolder = PARHELION_SOURCE_DIR "/tests/golden/oracles";
constexpr uint32_t kRuns = 16, kTile = 6, kNoRoulette = 1u << 20;
constexpr size_t kColors = 3;

struct OracleCase {
    const char* name;
    uint32_t samples;     // of each of our runs
    float turn = 0.0f;    // of its environment, degrees
    double margin = 0.005;  // of the picture's mean
};
void PrintTo(const OracleCase& oracle, std::ostream* out) { *out << oracle.name; }

constexpr OracleCase kCases[] = {
    {"cornell", 16},
    {"textured", 16},
    {"many_emitters", 40, 0.0f, 0.01},
    {"textured_emitters", 16},
    {"environment", 16, 73.0f},
    {"instances", 48, 0.0f, 0.01},
    {"punctual", 24, 0.0f, 0.01},
    {"directional", 8},
    {"alpha", 16},
    {"mirrors", 16, 0.0f, 0.01},
    {"glass", 16, 0.0f, 0.01},
    {"rough_room", 16, 0.0f, 0.01},
    {"rough_room_compensated", 16, 0.0f, 0.01},
    {"rough_sky", 32, 73.0f, 0.01},
    {"rough_sky_compensated", 32, 73.0f, 0.01},
    {"rough_glass", 32, 73.0f, 0.01},
    {"rough_slab", 16, 0.0f, 0.01},
};

// Pictures of the same scene, with the light put back that scatters more than once.
constexpr std::string_view kCompensated = "_compensated";
bool is_compensated(const OracleCase& oracle) { return std::string_view(oracle.name).ends_with(kCompensated); }
std::filesystem::path scene_file(const OracleCase& oracle) {
    std::string_view name = oracle.name;
    if (is_compensated(oracle)) name.remove_suffix(kCompensated.size());
    return kFolder / (std::string(name) + ".glb");
}

// A picture and the variance of its values, red plane, green plane, blue plane; pixels or tiles.
struct Estimate {
    std::vector<float> mean, variance;
};

// Means of kTile x kTile pixels.
std::vector<float> tiles_of(std::span<const float> plane, uint32_t width, uint32_t height) {
    std::vector<float> out;
    for (uint32_t y = 0; y < height; y += kTile)
        for (uint32_t x = 0; x < width; x += kTile) {
            double sum = 0;
            for (uint32_t i = 0; i < kTile * kTile; ++i) sum += double(plane[(y + i / kTile) * width + x + i % kTile]);
            out.push_back(float(sum / (kTile * kTile)));
        }
    return out;
}

// The mean of runs of the same values, and its variance.
Estimate estimate(std::span<const std::vector<float>> runs) {
    Estimate out;
    for (size_t i = 0; i < runs[0].size(); ++i) {
        std::vector<double> values;
        for (const std::vector<float>& run : runs) values.push_back(double(run[i]));
        const Moments m = moments(values);
        out.mean.push_back(float(m.mean));
        out.variance.push_back(float(m.variance / double(m.count)));
    }
    return out;
}

class MitsubaOracle : public GpuTest, public ::testing::WithParamInterface<OracleCase> {
protected:
    static Stage make_stage(const OracleCase& oracle) {
        LoadedScene loaded = load_scene(scene_file(oracle).string());
        if (oracle.turn != 0.0f) {
            Environment environment = load_environment(kFolder / "environment_map.exr");
            environment.rotation = oracle.turn * std::numbers::pi_v<float> / 180.0f;
            SceneEdit edit;
            edit.set_environment(std::move(environment));
            loaded.scene.apply(std::move(edit));
        }
        return Stage(std::move(loaded.scene), {.hardware = false});
    }
    // Independent runs, each with its own seed, of independent samples (PCG): equal depth, box filter, no roulette, no departures.
    static std::vector<std::vector<float>> our_runs(const OracleCase& oracle, const image::ImageF& theirs) {
        Stage stage = make_stage(oracle);
        std::vector<std::vector<float>> out;
        for (uint32_t run = 0; run < kRuns; ++run) {
            const image::ImageF picture = stage.picture({.view = {.width = theirs.width,
                                                                  .height = theirs.height,
                                                                  .seed = 7 + run,
                                                                  .max_bounces = uint32_t(std::stoul(theirs.attributes.at("bounces"))),
                                                                  .sampler = SamplerKind::Pcg,
                                                                  .roulette_start = kNoRoulette,
                                                                  .energy_compensation = is_compensated(oracle),
                                                                  .normal_correction = false},
                                                         .sample_count = oracle.samples});
            expect_sane(picture);
            out.emplace_back(picture.data.begin(), picture.data.begin() + ptrdiff_t(kColors * picture.pixel_count()));
        }
        return out;
    }
};

std::vector<float> planes(const image::ImageF& image, std::string_view layer) {
    const image::RgbPlanes rgb = image::rgb_planes(image, layer);
    std::vector<float> out(rgb.r.begin(), rgb.r.end());
    out.insert(out.end(), rgb.g.begin(), rgb.g.end());
    out.insert(out.end(), rgb.b.begin(), rgb.b.end());
    return out;
}

std::vector<float> tiled(const std::vector<float>& values, uint32_t width, uint32_t height) {
    std::vector<float> out;
    for (size_t c = 0; c < kColors; ++c) {
        const std::vector<float> part = tiles_of(std::span(values).subspan(c * width * height, size_t{width} * height), width, height);
        out.insert(out.end(), part.begin(), part.end());
    }
    return out;
}

double mean_of(std::span<const float> values) {
    double sum = 0;
    for (const float v : values) sum += double(v);
    return sum / double(values.size());
}

}  // namespace

// Three statements, from fine to coarse. Pixels: 99.75 % of the values lie within what a picture of equal expectation exceeds once
// in a hundred times (Sidak). Tiles of 6x6: all lie within what such a picture exceeds once in a thousand times. The whole: the ratio
// of the means, with its 99.9 % interval, lies within the margin, so that noise fails.
TEST_P(MitsubaOracle, draws_the_same_picture) {
    const OracleCase& oracle = GetParam();
    const image::ImageF theirs = image::read_linear(kFolder / (std::string(oracle.name) + ".exr"));
    const std::vector<std::vector<float>> runs = our_runs(oracle, theirs);
    const Estimate reference{planes(theirs, ""), planes(theirs, "variance")};
    const double freedom = kRuns - 1;  // of the reference's variances too: they come from 16 runs

    const Estimate pixels = estimate(runs);
    const ZTest by_pixel = z_test(pixels.mean, pixels.variance, reference.mean, reference.variance, 0.01, freedom);
    const double share = 1.0 - double(by_pixel.below) / double(pixels.mean.size());
    EXPECT_GE(share, 0.9975) << by_pixel.text;

    std::vector<std::vector<float>> tile_runs;
    for (const std::vector<float>& run : runs) tile_runs.push_back(tiled(run, theirs.width, theirs.height));
    const Estimate tiles = estimate(tile_runs);
    std::vector<float> reference_variance = tiled(reference.variance, theirs.width, theirs.height);  // of a mean of independent pixels
    for (float& v : reference_variance) v /= float(kTile * kTile);
    const ZTest by_tile = z_test(tiles.mean, tiles.variance, tiled(reference.mean, theirs.width, theirs.height), reference_variance, 0.001, freedom);
    EXPECT_TRUE(by_tile.passed) << by_tile.text;

    std::vector<double> means;
    for (const std::vector<float>& run : runs) means.push_back(mean_of(run));
    const Moments ours = moments(means);
    const double expected = mean_of(reference.mean), ratio = ours.mean / expected;
    const double reference_error = std::sqrt(mean_of(reference.variance) / double(reference.mean.size())) / expected;
    const double error = std::hypot(ours.standard_error() / ours.mean, reference_error) * t_quantile(0.9995, freedom);
    EXPECT_LT(std::abs(ratio - 1.0) + error, oracle.margin) << ratio;
    fmt::print("{}: mean {:.5f} +-{:.5f} of theirs, {:.3f} % of pixel values agree, worst tile p {:.2g} (limit {:.2g})\n", oracle.name, ratio, error, 100 * share, by_tile.worst_p, by_tile.threshold);
}

INSTANTIATE_TEST_SUITE_P(Scenes, MitsubaOracle, ::testing::ValuesIn(kCases), [](const auto& row) { return std::string(row.param.name); });

}  // namespace parhelion::testing
