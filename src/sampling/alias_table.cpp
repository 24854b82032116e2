#include "sampling/alias_table.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace parhelion::sampling {

namespace {

constexpr double kUnit = 1u << 24;  // probabilities are counted in units of 2^-24

double checked_maximum(std::span<const double> weights, std::string_view where) {
    if (weights.size() > AliasTable::kMaxRows)
        throw Error(ErrorCode::Failed, fmt::format("{} weights are more than an alias table holds ({})", weights.size(), AliasTable::kMaxRows),
                    std::string(where));
    double largest = 0;
    for (size_t i = 0; i < weights.size(); ++i) {
        if (!(weights[i] >= 0) || std::isinf(weights[i]))
            throw Error(ErrorCode::Failed, fmt::format("weight {} is {}, not a finite number of 0 or more", i, weights[i]), std::string(where));
        largest = std::max(largest, weights[i]);
    }
    return largest;
}

}  // namespace

AliasTable::AliasTable(std::span<const double> weights, std::string_view where) {
    const double largest = checked_maximum(weights, where);
    if (largest == 0) return;
    // Relative to the largest weight, so that neither huge weights overflow nor tiny ones vanish. A sum of 2^24 such terms keeps
    // nine digits.
    std::vector<double> mass(weights.size());
    double sum = 0;
    for (size_t i = 0; i < mass.size(); ++i) sum += mass[i] = weights[i] / largest;
    for (double& m : mass) m *= static_cast<double>(weights.size()) / sum;
    pair_rows(weights, std::move(mass));
    sum_pmf();
}

// Vose's pairing: each row lighter than the mean is filled up from a heavier one. `mass` is the weight in units of the mean. The
// donor gives what the rounded row really lacks, so rounding errors do not add up.
void AliasTable::pair_rows(std::span<const double> weights, std::vector<double> mass) {
    const auto count = static_cast<uint32_t>(weights.size());
    std::vector<uint32_t> light, heavy;
    entries_.resize(count);
    for (uint32_t i = 0; i < count; ++i) {
        entries_[i] = {1.0f, i};
        (mass[i] < 1.0 ? light : heavy).push_back(i);
    }
    while (!light.empty() && !heavy.empty()) {
        const uint32_t taker = light.back(), donor = heavy.back();
        light.pop_back();
        const double own = weights[taker] > 0 ? std::clamp(std::round(mass[taker] * kUnit), 1.0, kUnit) / kUnit : 0.0;
        entries_[taker] = {static_cast<float>(own), donor};
        mass[donor] -= 1.0 - own;
        if (mass[donor] >= 1.0) continue;
        heavy.pop_back();
        light.push_back(donor);
    }
    // What is left is a full row but for rounding, which must not bring an impossible index to life.
    const auto heaviest = static_cast<uint32_t>(std::max_element(weights.begin(), weights.end()) - weights.begin());
    for (const uint32_t i : light)
        if (weights[i] == 0) entries_[i] = {0.0f, heaviest};
}

void AliasTable::sum_pmf() {
    std::vector<double> units(entries_.size(), 0.0);  // whole numbers, so the sums are exact
    for (size_t i = 0; i < entries_.size(); ++i) {
        const double own = static_cast<double>(entries_[i].probability) * kUnit;
        units[i] += own;
        units[entries_[i].alias] += kUnit - own;
    }
    pmf_.resize(entries_.size());
    for (size_t i = 0; i < pmf_.size(); ++i) pmf_[i] = static_cast<float>(units[i] / kUnit / static_cast<double>(entries_.size()));
}

}  // namespace parhelion::sampling
