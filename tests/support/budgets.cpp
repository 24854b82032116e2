#include "support/budgets.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>
#include <vector>

namespace parhelion::testing {

namespace {

constexpr double kDarkTile = 0.01;  // of the mean; darker tiles are not judged
constexpr uint32_t kBootstraps = 200;

void check(std::span<const double> test, std::span<const double> reference) {
    if (test.size() < 2 || reference.size() < 2) throw std::invalid_argument("a ratio of means needs two runs of each");
    if (!(moments(reference).mean > 0)) throw std::invalid_argument("the reference's mean must be positive");
}

// Each tile's mean over the chosen runs.
std::vector<double> tile_means(const Runs& runs, std::span<const uint32_t> chosen) {
    std::vector<double> out(runs.tile_count());
    for (uint32_t tile = 0; tile < runs.tile_count(); ++tile) {
        const std::span<const double> of_runs = runs.tile_means(tile);
        for (const uint32_t run : chosen) out[tile] += of_runs[run] / static_cast<double>(chosen.size());
    }
    return out;
}

double quantile_of_differences(std::span<const double> test, std::span<const double> reference, std::span<const uint32_t> tiles, double quantile) {
    std::vector<double> differences;
    for (const uint32_t tile : tiles) differences.push_back(std::abs(test[tile] / reference[tile] - 1.0));
    std::sort(differences.begin(), differences.end());
    return differences[static_cast<size_t>(std::ceil(quantile * static_cast<double>(differences.size()))) - 1];
}

}  // namespace

double Ratio::upper(double confidence) const { return value + t_quantile(confidence, degrees_of_freedom) * error; }
double Ratio::lower(double confidence) const { return value - t_quantile(confidence, degrees_of_freedom) * error; }

Ratio ratio_of_means(std::span<const double> test, std::span<const double> reference) {
    check(test, reference);
    const Moments t = moments(test), r = moments(reference);
    Ratio out{.value = t.mean / r.mean};
    const double a = std::pow(t.standard_error() / r.mean, 2), b = std::pow(out.value * r.standard_error() / r.mean, 2);
    out.error = std::sqrt(a + b);
    const double df_a = static_cast<double>(t.count - 1), df_b = static_cast<double>(r.count - 1);
    out.degrees_of_freedom = out.error > 0 ? (a + b) * (a + b) / (a * a / df_a + b * b / df_b) : df_a + df_b;
    return out;
}

Ratio paired_ratio(std::span<const double> test, std::span<const double> reference) {
    check(test, reference);
    if (test.size() != reference.size()) throw std::invalid_argument("pairs of different number");
    const double mean = moments(reference).mean;
    Ratio out{.value = moments(test).mean / mean, .degrees_of_freedom = static_cast<double>(test.size() - 1)};
    std::vector<double> residuals;
    for (size_t i = 0; i < test.size(); ++i) residuals.push_back((test[i] - out.value * reference[i]) / mean);
    out.error = moments(residuals).standard_error();
    return out;
}

Ratio tile_quantile(const Runs& test, const Runs& reference, double quantile) {
    if (test.tile_count() != reference.tile_count()) throw std::invalid_argument("test and reference differ in size");
    std::vector<uint32_t> all_test(test.count()), all_reference(reference.count()), tiles;
    for (uint32_t i = 0; i < test.count(); ++i) all_test[i] = i;
    for (uint32_t i = 0; i < reference.count(); ++i) all_reference[i] = i;
    const std::vector<double> truth = tile_means(reference, all_reference);
    const double dark = kDarkTile * moments(reference.means()).mean;
    for (uint32_t tile = 0; tile < truth.size(); ++tile)
        if (truth[tile] > dark) tiles.push_back(tile);
    if (tiles.empty()) throw std::invalid_argument("no tile is bright enough to be judged");
    Ratio out{.value = quantile_of_differences(tile_means(test, all_test), truth, tiles, quantile), .degrees_of_freedom = static_cast<double>(test.count() - 1)};
    std::mt19937_64 rng(20250701);
    const auto draw = [&](std::vector<uint32_t> runs) {
        for (uint32_t& run : runs) run = static_cast<uint32_t>(rng() % runs.size());
        return runs;
    };
    std::vector<double> again;
    for (uint32_t i = 0; i < kBootstraps; ++i)
        again.push_back(quantile_of_differences(tile_means(test, draw(all_test)), tile_means(reference, draw(all_reference)), tiles, quantile));
    out.error = std::sqrt(moments(again).variance);
    return out;
}

}  // namespace parhelion::testing
