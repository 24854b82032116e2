#pragma once
// Small statistics for tests. Every test says its false-alarm rate; seeds are fixed, so a test that passes once passes always.
#include <cmath>
#include <cstddef>
#include <span>

namespace parhelion::testing {

// Upper point of the standard normal distribution: P(Z > z) = alpha, alpha in (0, 0.5]. Abramowitz and Stegun 26.2.23, |error| < 4.5e-4.
inline double normal_upper_point(double alpha) {
    const double t = std::sqrt(-2.0 * std::log(alpha));
    return t - (2.515517 + t * (0.802853 + t * 0.010328)) / (1.0 + t * (1.432788 + t * (0.189269 + t * 0.001308)));
}

// Upper point of chi-square with `freedom` degrees of freedom. Wilson and Hilferty 1931; good to a percent from 3 degrees on.
inline double chi_square_upper_point(double freedom, double alpha) {
    const double z = normal_upper_point(alpha), v = 2.0 / (9.0 * freedom);
    return freedom * std::pow(1.0 - v + z * std::sqrt(v), 3);
}

// Alpha of each of `count` independent tests, so that all together raise a false alarm with probability alpha. Sidak 1967.
inline double sidak(double alpha, size_t count) { return 1.0 - std::pow(1.0 - alpha, 1.0 / static_cast<double>(count)); }

// Pearson's test of counts against expected counts. Cells are pooled in order until each pool expects `least` or more.
struct ChiSquare {
    double statistic = 0, freedom = 0;
    bool passes(double alpha) const { return freedom < 1 || statistic <= chi_square_upper_point(freedom, alpha); }
};
template <class Count>
ChiSquare chi_square(std::span<const Count> observed, std::span<const double> expected, double least = 5) {
    ChiSquare result{.freedom = -1};
    double o = 0, e = 0;
    for (size_t i = 0; i < observed.size(); ++i) {
        o += static_cast<double>(observed[i]);
        e += expected[i];
        if (e < least && i + 1 < observed.size()) continue;
        if (e > 0) {
            result.statistic += (o - e) * (o - e) / e;
            result.freedom += 1;
        }
        o = e = 0;
    }
    return result;
}

// Pearson's correlation of paired values.
template <class T>
double correlation(std::span<const T> a, std::span<const T> b) {
    double sa = 0, sb = 0, saa = 0, sbb = 0, sab = 0;
    const auto n = static_cast<double>(a.size());
    for (size_t i = 0; i < a.size(); ++i) {
        const double x = a[i], y = b[i];
        sa += x, sb += y, saa += x * x, sbb += y * y, sab += x * y;
    }
    return (n * sab - sa * sb) / std::sqrt((n * saa - sa * sa) * (n * sbb - sb * sb));
}

// Least-squares slope of y over x.
inline double fit_slope(std::span<const double> x, std::span<const double> y) {
    double sx = 0, sy = 0, sxx = 0, sxy = 0;
    const auto n = static_cast<double>(x.size());
    for (size_t i = 0; i < x.size(); ++i) sx += x[i], sy += y[i], sxx += x[i] * x[i], sxy += x[i] * y[i];
    return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

}  // namespace parhelion::testing
