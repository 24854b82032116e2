#include "support/statistics.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include <fmt/format.h>

namespace parhelion::testing {

namespace {

constexpr double kTiny = 1e-300;
constexpr double kPrecision = 1e-15;
constexpr int kMaxTerms = 2000;

void require(bool condition, const char* message) {
    if (!condition) throw std::invalid_argument(message);
}

// Continued fraction of Q(a, x) and of I_x(a, b), by Lentz's method: f = 1 / (b0 + a1 / (b1 + ...)).
double gamma_fraction(double a, double x) {
    double b = x + 1 - a, c = 1 / kTiny, d = 1 / b, f = d;
    for (int i = 1; i < kMaxTerms; ++i) {
        const double term = -i * (i - a);
        b += 2;
        d = term * d + b;
        c = b + term / c;
        if (std::abs(d) < kTiny) d = kTiny;
        if (std::abs(c) < kTiny) c = kTiny;
        d = 1 / d;
        f *= d * c;
        if (std::abs(d * c - 1) < kPrecision) break;
    }
    return f;
}

double gamma_series(double a, double x) {
    double term = 1 / a, sum = term;
    for (int i = 1; i < kMaxTerms && term > sum * kPrecision; ++i) {
        term *= x / (a + i);
        sum += term;
    }
    return sum;
}

double beta_fraction(double a, double b, double x) {
    double c = 1, d = 1 - (a + b) * x / (a + 1);
    if (std::abs(d) < kTiny) d = kTiny;
    d = 1 / d;
    double f = d;
    const auto step = [&](double term) {
        d = 1 + term * d;
        c = 1 + term / c;
        if (std::abs(d) < kTiny) d = kTiny;
        if (std::abs(c) < kTiny) c = kTiny;
        d = 1 / d;
        f *= d * c;
    };
    for (int m = 1; m < kMaxTerms; ++m) {
        step(m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m)));
        step(-(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1)));
        if (std::abs(d * c - 1) < kPrecision) break;
    }
    return f;
}

// Probability of more than |t| on either side; exact far out in the tails.
double two_sided_p(double t, double df) {
    if (std::isinf(df)) return std::erfc(std::abs(t) / std::sqrt(2.0));
    if (std::isinf(t)) return 0;
    return incomplete_beta(df / 2, 0.5, df / (df + t * t));
}

// The argument at which a growing function reaches `p`.
template <class Cdf>
double invert(const Cdf& cdf, double p) {
    require(p > 0 && p < 1, "a quantile needs a probability between 0 and 1");
    double low = -1, high = 1;
    while (cdf(low) > p) low *= 2;
    while (cdf(high) < p) high *= 2;
    for (int i = 0; i < 200; ++i) {
        const double middle = 0.5 * (low + high);
        (cdf(middle) < p ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

// Welch-Satterthwaite degrees of freedom of the sum of two estimated variances.
double welch(double a, double df_a, double b, double df_b) {
    const double denominator = a * a / df_a + b * b / df_b;
    return denominator > 0 ? (a + b) * (a + b) / denominator : std::numeric_limits<double>::infinity();
}

}  // namespace

double upper_gamma(double a, double x) {
    require(a > 0 && x >= 0, "incomplete gamma: a > 0 and x >= 0");
    if (x == 0) return 1;
    const double scale = std::exp(a * std::log(x) - x - std::lgamma(a));
    return x < a + 1 ? 1 - scale * gamma_series(a, x) : scale * gamma_fraction(a, x);
}

double incomplete_beta(double a, double b, double x) {
    require(a > 0 && b > 0 && x >= 0 && x <= 1, "incomplete beta: a, b > 0 and x in [0,1]");
    if (x == 0 || x == 1) return x;
    const double scale = std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log1p(-x));
    return x < (a + 1) / (a + b + 2) ? scale * beta_fraction(a, b, x) / a : 1 - scale * beta_fraction(b, a, 1 - x) / b;
}

double normal_cdf(double z) { return 0.5 * std::erfc(-z / std::sqrt(2.0)); }
double normal_quantile(double p) { return invert(normal_cdf, p); }

double t_cdf(double t, double degrees_of_freedom) {
    if (std::isinf(degrees_of_freedom)) return normal_cdf(t);
    const double tail = 0.5 * two_sided_p(t, degrees_of_freedom);
    return t > 0 ? 1 - tail : tail;
}

double t_quantile(double p, double degrees_of_freedom) {
    return invert([&](double t) { return t_cdf(t, degrees_of_freedom); }, p);
}

double chi_square_survival(double chi2, double degrees_of_freedom) { return upper_gamma(degrees_of_freedom / 2, chi2 / 2); }

double binomial_cdf(uint64_t successes, uint64_t trials, double p) {
    if (successes >= trials) return 1;
    return incomplete_beta(static_cast<double>(trials - successes), static_cast<double>(successes) + 1, 1 - p);
}

uint64_t binomial_quantile(double probability, uint64_t trials, double p) {
    uint64_t k = 0;
    while (k < trials && binomial_cdf(k, trials, p) < probability) ++k;
    return k;
}

double sidak(double alpha, uint64_t tests) { return -std::expm1(std::log1p(-alpha) / static_cast<double>(tests)); }

double Moments::standard_error() const { return std::sqrt(variance / static_cast<double>(count)); }

Moments moments(std::span<const double> values) {
    Moments out{.count = values.size()};
    if (values.empty()) return out;
    out.mean = std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
    for (const double v : values) out.variance += (v - out.mean) * (v - out.mean);
    if (values.size() > 1) out.variance /= static_cast<double>(values.size() - 1);
    return out;
}

Runs::Runs(uint32_t width, uint32_t height, uint32_t tile_size)
    : width_(width), height_(height), tile_size_(tile_size), tiles_x_((width + tile_size - 1) / tile_size), tiles_y_((height + tile_size - 1) / tile_size), tiles_(tile_count()) {}

void Runs::add_run(std::span<const float> values) {
    require(values.size() == size_t{width_} * height_ && !values.empty(), "a run of another size than the others");
    std::vector<double> sums(tile_count()), pixels(tile_count());
    for (uint32_t y = 0; y < height_; ++y)
        for (uint32_t tile_x = 0; tile_x < tiles_x_; ++tile_x) {
            const uint32_t begin = tile_x * tile_size_, end = std::min(width_, begin + tile_size_);
            const size_t tile = size_t{y / tile_size_} * tiles_x_ + tile_x;
            double sum = 0;
            for (uint32_t x = begin; x < end; ++x) sum += static_cast<double>(values[size_t{y} * width_ + x]);
            sums[tile] += sum;
            pixels[tile] += end - begin;
        }
    means_.push_back(std::accumulate(sums.begin(), sums.end(), 0.0) / static_cast<double>(values.size()));
    for (size_t tile = 0; tile < sums.size(); ++tile) tiles_[tile].push_back(sums[tile] / pixels[tile]);
}

namespace {

constexpr uint32_t kMinRuns = 32;
constexpr double kIntervalTail = 0.0005;  // of the 99.9 % interval, on each side
constexpr double kTileLevel = 0.01, kTileCountProbability = 0.999;
constexpr double kDarkTile = 0.01;        // of the mean; darker tiles are not judged

// The relative variance of the mean, and its degrees of freedom (infinite for an exact truth).
struct RelativeError {
    double mean, variance, degrees_of_freedom;
};
RelativeError relative_error(std::span<const double> means) {
    const Moments m = moments(means);
    const double error = m.standard_error() / m.mean;
    return {m.mean, error * error, m.count > 1 ? static_cast<double>(m.count - 1) : std::numeric_limits<double>::infinity()};
}

void judge_mean(const Runs& test, const Runs& reference, double margin, Equivalence& out) {
    const RelativeError t = relative_error(test.means()), r = relative_error(reference.means());
    require(std::isfinite(t.mean) && r.mean > 0 && std::isfinite(r.mean), "the means must be finite and the reference's positive");
    out.ratio = t.mean / r.mean;
    const double df = welch(t.variance, t.degrees_of_freedom, r.variance, r.degrees_of_freedom);
    const double half = t_quantile(1 - kIntervalTail, df) * std::abs(out.ratio) * std::sqrt(t.variance + r.variance);
    out.low = out.ratio - half;
    out.high = out.ratio + half;
    out.reference_error = std::sqrt(r.variance);
    out.mean_passed = out.low >= 1 - margin && out.high <= 1 + margin && out.reference_error <= margin / 4;
}

void judge_tiles(const Runs& test, const Runs& reference, double rounding, Equivalence& out) {
    const double dark = kDarkTile * moments(reference.means()).mean;
    for (uint32_t tile = 0; tile < reference.tile_count(); ++tile) {
        const Moments t = moments(test.tile_means(tile)), r = moments(reference.tile_means(tile));
        if (!(r.mean > dark)) continue;
        ++out.tiles;
        const double var_t = t.variance / static_cast<double>(t.count), var_r = r.variance / static_cast<double>(r.count);
        const double df = welch(var_t, static_cast<double>(t.count - 1), var_r, std::max<double>(1, static_cast<double>(r.count) - 1));
        const double error = std::max(std::sqrt(var_t + var_r), rounding * r.mean);
        if (!(two_sided_p((t.mean - r.mean) / error, df) >= kTileLevel)) ++out.tiles_over;
    }
    out.tiles_allowed = static_cast<uint32_t>(binomial_quantile(kTileCountProbability, out.tiles, kTileLevel));
    out.tiles_passed = out.tiles_over <= out.tiles_allowed;
}

Equivalence judge(const Runs& test, const Runs& reference, double margin, double rounding) {
    require(test.count() >= kMinRuns, "the equivalence test needs at least 32 runs");
    require(test.tile_count() == reference.tile_count(), "test and reference differ in size");
    Equivalence out;
    judge_mean(test, reference, margin, out);
    judge_tiles(test, reference, rounding, out);
    out.passed = out.mean_passed && out.tiles_passed;
    out.text = fmt::format("ratio {:.6f} in [{:.6f}, {:.6f}], margin {:.4f}, reference error {:.6f} (at most {:.6f}), {} of {} tiles differ ({} allowed), {} runs",
                           out.ratio, out.low, out.high, margin, out.reference_error, margin / 4, out.tiles_over, out.tiles, out.tiles_allowed, test.count());
    return out;
}

}  // namespace

Equivalence equivalence_test(const Runs& test, const Runs& reference, double margin, double rounding) {
    require(reference.count() >= 2, "the reference needs at least 2 runs, for its own error; equivalence_test_exact takes an exact truth");
    return judge(test, reference, margin, rounding);
}

Equivalence equivalence_test_exact(const Runs& test, const Runs& truth, double margin) {
    require(truth.count() == 1, "an exact truth is one plane");
    return judge(test, truth, margin, kRounding);
}

namespace {

// A difference of two values with these variances, in standard errors, and its p.
struct Difference {
    double z, p;
};
Difference difference(float a, double variance_a, float b, double variance_b, double degrees_of_freedom) {
    const double rounding = kRounding * std::max(std::abs(a), std::abs(b));
    const double error = std::max({std::sqrt(variance_a + variance_b), rounding, kTiny}), z = (static_cast<double>(a) - static_cast<double>(b)) / error;
    const double df = std::isinf(degrees_of_freedom) ? degrees_of_freedom : welch(variance_a, degrees_of_freedom, variance_b, degrees_of_freedom);
    return {z, std::isfinite(z) ? two_sided_p(z, df) : 0};
}

}  // namespace

ZTest z_test(std::span<const float> a, std::span<const float> variance_a, std::span<const float> b, std::span<const float> variance_b, double alpha,
             double degrees_of_freedom) {
    require(!a.empty() && a.size() == b.size() && a.size() == variance_a.size() && a.size() == variance_b.size(), "Z-test of planes of different size");
    ZTest out{.threshold = sidak(alpha, a.size())};
    double worst_z = 0;
    for (size_t i = 0; i < a.size(); ++i) {
        const Difference d = difference(a[i], double(variance_a[i]), b[i], double(variance_b[i]), degrees_of_freedom);
        out.below += d.p < out.threshold;
        if (d.p < out.worst_p || i == 0) out.worst_p = d.p, out.worst_index = i, worst_z = d.z;
    }
    out.passed = out.worst_p >= out.threshold;
    out.text = fmt::format("worst of {} values at {}: {} and {}, z {:.2f}, p {:.3g}, threshold {:.3g}", a.size(), out.worst_index, a[out.worst_index],
                           b[out.worst_index], worst_z, out.worst_p, out.threshold);
    return out;
}

std::vector<double> z_test_p(std::span<const float> a, std::span<const float> variance_a, std::span<const float> b, std::span<const float> variance_b,
                             double degrees_of_freedom) {
    require(a.size() == b.size() && a.size() == variance_a.size() && a.size() == variance_b.size(), "Z-test of planes of different size");
    std::vector<double> out;
    for (size_t i = 0; i < a.size(); ++i) out.push_back(difference(a[i], double(variance_a[i]), b[i], double(variance_b[i]), degrees_of_freedom).p);
    return out;
}

ChiSquare chi_square_test(std::span<const double> counts, std::span<const double> expected, double min_expected, unsigned fitted) {
    require(counts.size() == expected.size(), "chi-square test of counts and expectations of different number");
    std::vector<size_t> order(counts.size());
    std::iota(order.begin(), order.end(), size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](size_t x, size_t y) { return expected[x] < expected[y]; });

    ChiSquare out;
    size_t cells = 0;
    double pooled_count = 0, pooled_expected = 0;
    for (const size_t i : order) {
        if (expected[i] <= 0 && counts[i] > 0) {
            out.p = 0;
            out.text = fmt::format("cell {} has {} counts where none can be", i, counts[i]);
            return out;
        }
        pooled_count += counts[i];
        pooled_expected += expected[i];
        if (pooled_expected < min_expected) continue;
        out.chi2 += (pooled_count - pooled_expected) * (pooled_count - pooled_expected) / pooled_expected;
        ++cells;
        pooled_count = pooled_expected = 0;
    }
    require(cells > 1 + fitted, "chi-square test of too few counts");
    out.degrees_of_freedom = static_cast<double>(cells - 1 - fitted);
    out.p = chi_square_survival(out.chi2, out.degrees_of_freedom);
    out.text = fmt::format("chi-square {:.2f} with {} degrees of freedom, p {:.3g}", out.chi2, out.degrees_of_freedom, out.p);
    return out;
}

KolmogorovSmirnov kolmogorov_smirnov_test(std::vector<double> samples, const std::function<double(double)>& cdf) {
    require(!samples.empty(), "Kolmogorov-Smirnov test of no samples");
    std::sort(samples.begin(), samples.end());
    const auto n = static_cast<double>(samples.size());
    KolmogorovSmirnov out;
    for (size_t i = 0; i < samples.size(); ++i) {
        const double value = cdf(samples[i]);
        out.distance = std::max({out.distance, static_cast<double>(i + 1) / n - value, value - static_cast<double>(i) / n});
    }
    const double lambda = (std::sqrt(n) + 0.12 + 0.11 / std::sqrt(n)) * out.distance;
    if (lambda < 0.2) return out;  // p is 1 to ten digits, and the series slow
    double p = 0;
    for (int j = 1; j <= 100; ++j) p += (j % 2 == 1 ? 2 : -2) * std::exp(-2.0 * j * j * lambda * lambda);
    out.p = std::clamp(p, 0.0, 1.0);
    return out;
}

SlopeFit fit_slope(std::span<const double> x, std::span<const double> y) {
    require(x.size() == y.size() && x.size() >= 3, "a slope needs at least 3 points");
    const Moments mx = moments(x), my = moments(y);
    double xx = 0, xy = 0;
    for (size_t i = 0; i < x.size(); ++i) {
        xx += (x[i] - mx.mean) * (x[i] - mx.mean);
        xy += (x[i] - mx.mean) * (y[i] - my.mean);
    }
    require(xx > 0, "a slope needs different abscissas");
    SlopeFit out{.slope = xy / xx};
    out.intercept = my.mean - out.slope * mx.mean;
    double residual = 0;
    for (size_t i = 0; i < x.size(); ++i) {
        const double d = y[i] - out.intercept - out.slope * x[i];
        residual += d * d;
    }
    out.standard_error = std::sqrt(residual / static_cast<double>(x.size() - 2) / xx);
    return out;
}

SlopeFit fit_log_slope(std::span<const double> x, std::span<const double> y) {
    std::vector<double> log_x, log_y;
    for (const double v : x) log_x.push_back(std::log(v));
    for (const double v : y) log_y.push_back(std::log(v));
    return fit_slope(log_x, log_y);
}

}  // namespace parhelion::testing
