#pragma once
// Ratios of means with what their noise leaves open, for budgets: "at most so much", judged on the upper 99 % bound, so that noise fails.
#include <span>

#include "support/statistics.h"

namespace parhelion::testing {

struct Ratio {
    double value = 0;
    double error = 0;               // standard
    double degrees_of_freedom = 1;  // of that error
    // One-sided bounds, each passed by the true ratio with probability 1 - confidence; t-distributed.
    double upper(double confidence = 0.99) const;
    double lower(double confidence = 0.99) const;
};

// Mean of `test` over mean of `reference`, of independent runs (delta method, Welch-Satterthwaite degrees of freedom). Throws
// std::invalid_argument for fewer than two of either, or a reference whose mean is not positive.
Ratio ratio_of_means(std::span<const double> test, std::span<const double> reference);
// The same where test[i] and reference[i] come from one run: what both have in common cancels.
Ratio paired_ratio(std::span<const double> test, std::span<const double> reference);
// Of the 8x8 tiles brighter than 1 % of the reference's mean: this quantile of the relative difference of their means, not less than
// without noise (noise widens it). Its error is that of 200 bootstrap samples of the runs (Efron 1979; fixed seed).
Ratio tile_quantile(const Runs& test, const Runs& reference, double quantile);

}  // namespace parhelion::testing
