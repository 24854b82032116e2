// Pictures by a stranger: Mitsuba 3's of the same glTF files, where its models are ours (tools/oracles/make_mitsuba_oracles.py), and with
// rough surfaces written for it from the papers (rough_*: tools/oracles/make_microfacet_oracles.py).
#include <algorithm>
#include <cmath>
#include <numbers>

#include "image/decode.h"
#include "scene/load.h"
#include "support/render_fixture.h"
#include "support/statistics.h"

namespace parhelion::testing::oracle_test {
namespace {

const std::filesystem::path kFolder = PARHELION_SOURCE_DIR "/tests/golden/oracles";
constexpr uint32_t kRuns = 16, kTile = 4, kNoRoulette = 1u << 20;
constexpr size_t kColors = 3;
constexpr double kPictureLevel = 0.01, kShare = 0.9975;          // of the first rule below
constexpr double kValueLevel = 0.01, kCountProbability = 0.99997;  // of the second: 5e-4 for all scenes
constexpr double kMaxSkewness = 0.5;                             // of a run's values that Student's t is used on

// What is compared: single pixels, or tiles of kTile x kTile where a few paths carry much of a pixel's light.
enum class Unit { Pixels, Tiles };

struct OracleCase {
    const char* name;
    uint32_t samples;     // of each of our runs
    Unit unit = Unit::Pixels;
    float turn = 0.0f;    // of its environment, degrees
    double margin = 0.005;  // of the picture's mean
};
void PrintTo(const OracleCase& oracle, std::ostream* out) { *out << oracle.name; }

constexpr OracleCase kCases[] = {
    {"cornell", 16},
    {"textured", 16},
    {"many_emitters", 40, Unit::Tiles, 0.0f, 0.01},
    {"textured_emitters", 16},
    {"environment", 16, Unit::Pixels, 73.0f},
    {"instances", 48, Unit::Pixels, 0.0f, 0.01},
    {"punctual", 24, Unit::Pixels, 0.0f, 0.01},
    {"directional", 8},
    {"alpha", 16},
    {"mirrors", 16, Unit::Tiles, 0.0f, 0.01},
    {"glass", 16, Unit::Tiles, 0.0f, 0.01},
    {"rough_room", 16, Unit::Pixels, 0.0f, 0.01},
    {"rough_room_compensated", 16, Unit::Pixels, 0.0f, 0.01},
    {"rough_sky", 32, Unit::Pixels, 73.0f, 0.01},
    {"rough_sky_compensated", 32, Unit::Pixels, 73.0f, 0.01},
    {"rough_glass", 32, Unit::Pixels, 73.0f, 0.01},
    {"rough_slab", 16, Unit::Pixels, 0.0f, 0.01},
};

// Pictures of the same scene, with the light put back that scatters more than once.
constexpr std::string_view kCompensated = "_compensated";
bool is_compensated(const OracleCase& oracle) { return std::string_view(oracle.name).ends_with(kCompensated); }
std::filesystem::path scene_file(const OracleCase& oracle) {
    std::string_view name = oracle.name;
    if (is_compensated(oracle)) name.remove_suffix(kCompensated.size());
    return kFolder / (std::string(name) + ".glb");
}

// The mean of each tile of size x size pixels; planes one after another.
std::vector<float> tiled(const std::vector<float>& values, uint32_t width, uint32_t height, uint32_t size) {
    std::vector<float> out;
    for (size_t c = 0; c < kColors; ++c)
        for (uint32_t y = 0; y < height; y += size)
            for (uint32_t x = 0; x < width; x += size) {
                double sum = 0;
                for (uint32_t i = 0; i < size * size; ++i) sum += double(values[(c * height + y + i / size) * width + x + i % size]);
                out.push_back(float(sum / (size * size)));
            }
    return out;
}

// A picture's values, red, green and blue plane, and the variances of these means.
struct Estimate {
    std::vector<float> mean, variance;
    double skewness = 0;  // of one run's values about their means, over all of them
};

Estimate estimate(std::span<const std::vector<float>> runs) {
    Estimate out;
    double cubes = 0;
    size_t count = 0;
    for (size_t i = 0; i < runs[0].size(); ++i) {
        std::vector<double> values;
        for (const std::vector<float>& run : runs) values.push_back(double(run[i]));
        const Moments m = moments(values);
        out.mean.push_back(float(m.mean));
        out.variance.push_back(float(m.variance / double(m.count)));
        if (!(m.variance > 0)) continue;
        for (const double v : values) cubes += std::pow((v - m.mean) / std::sqrt(m.variance), 3);
        count += values.size();
    }
    out.skewness = count != 0 ? cubes / double(count) : 0;
    return out;
}

// Our runs against their picture, both in units of size x size pixels.
struct Judgement {
    double share = 0;             // of values within what equal expectations exceed once in a hundred pictures
    size_t units = 0, over = 0, allowed = 0;  // those whose p, over three colours, is below 1 %, and how many may be
    double skewness = 0;
    std::string worst = {};
};
Judgement judge(std::span<const std::vector<float>> runs, const Estimate& theirs, uint32_t width, uint32_t height, uint32_t size) {
    std::vector<std::vector<float>> our_units;
    for (const std::vector<float>& run : runs) our_units.push_back(tiled(run, width, height, size));
    const Estimate ours = estimate(our_units);
    const std::vector<float> mean = tiled(theirs.mean, width, height, size);
    std::vector<float> variance = tiled(theirs.variance, width, height, size);
    for (float& v : variance) v /= float(size * size);  // of a mean of independent pixels
    const double freedom = kRuns - 1;                   // of the reference's variances too: they come from 16 runs
    const ZTest test = z_test(ours.mean, ours.variance, mean, variance, kPictureLevel, freedom);
    const std::vector<double> p = z_test_p(ours.mean, ours.variance, mean, variance, freedom);
    Judgement out{.share = 1.0 - double(test.below) / double(mean.size()), .units = mean.size() / kColors, .skewness = ours.skewness, .worst = test.text};
    // Colours of one unit are alike: Sidak's level is no lower than the one meant.
    for (size_t i = 0; i < out.units; ++i) out.over += std::min({p[i], p[out.units + i], p[2 * out.units + i]}) < sidak(kValueLevel, kColors);
    out.allowed = binomial_quantile(kCountProbability, out.units, kValueLevel);
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

double mean_of(std::span<const float> values) {
    double sum = 0;
    for (const float v : values) sum += double(v);
    return sum / double(values.size());
}

}  // namespace

// Three rules. (1) 99.75 % of the pixel values lie within what a picture of equal expectations exceeds once in a hundred times
// (Welch's t, Sidak); where samples are too skewed for that, all means of 4x4 pixels do. (2) Of these tiles no more differ at the level of 1 %
// than one of a thousand pictures of equal expectations has (5 of 108). (3) The ratio of the whole pictures' means, with its 99.9 % interval,
// lies within the margin, so that noise fails.
TEST_P(MitsubaOracle, draws_the_same_picture) {
    const OracleCase& oracle = GetParam();
    const image::ImageF theirs = image::read_linear(kFolder / (std::string(oracle.name) + ".exr"));
    const std::vector<std::vector<float>> runs = our_runs(oracle, theirs);
    const Estimate reference{planes(theirs, ""), planes(theirs, "variance")};

    const Judgement pixels = judge(runs, reference, theirs.width, theirs.height, 1), tiles = judge(runs, reference, theirs.width, theirs.height, kTile);
    const bool by_pixel = oracle.unit == Unit::Pixels;
    const Judgement& judged = by_pixel ? pixels : tiles;
    EXPECT_GE(judged.share, by_pixel ? kShare : 1.0) << judged.worst;
    EXPECT_LT(judged.skewness, kMaxSkewness);
    EXPECT_LE(tiles.over, tiles.allowed) << tiles.worst;

    std::vector<double> means;
    for (const std::vector<float>& run : runs) means.push_back(mean_of(run));
    const Moments ours = moments(means);
    const double expected = mean_of(reference.mean), ratio = ours.mean / expected;
    const double reference_error = std::sqrt(mean_of(reference.variance) / double(reference.mean.size())) / expected;
    const double error = std::hypot(ours.standard_error() / ours.mean, reference_error) * t_quantile(0.9995, kRuns - 1);
    EXPECT_LT(std::abs(ratio - 1.0) + error, oracle.margin) << ratio;
    fmt::print("{}: mean {:.4f} +-{:.4f} of theirs; {:.2f} % of pixel values, skewness {:.2f}; {:.2f} % of tile values, {} of {} tiles over 1 % ({} allowed), skewness {:.2f}; by {}\n",
               oracle.name, ratio, error, 100 * pixels.share, pixels.skewness, 100 * tiles.share, tiles.over, tiles.units, tiles.allowed, tiles.skewness, by_pixel ? "pixels" : "tiles");
}

INSTANTIATE_TEST_SUITE_P(Scenes, MitsubaOracle, ::testing::ValuesIn(kCases), [](const auto& row) { return std::string(row.param.name); });

}  // namespace parhelion::testing::oracle_test
