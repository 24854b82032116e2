#pragma once
// The statistics that proofs are made of. Every test here states what it does with noise: an equivalence test fails on noise, a
// difference test (Z, chi-square, Kolmogorov-Smirnov) passes on it, with the false-alarm rate that its caller gives.
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <vector>

namespace parhelion::testing {

// ---- distributions ----

// Regularised incomplete gamma Q(a, x) and beta I_x(a, b), to about 1e-12 relative.
double upper_gamma(double a, double x);
double incomplete_beta(double a, double b, double x);

double normal_cdf(double z);
double normal_quantile(double p);
double t_cdf(double t, double degrees_of_freedom);       // infinite degrees of freedom: the normal distribution
double t_quantile(double p, double degrees_of_freedom);
double chi_square_survival(double chi2, double degrees_of_freedom);  // probability of more than chi2
double binomial_cdf(uint64_t successes, uint64_t trials, double p);
uint64_t binomial_quantile(double probability, uint64_t trials, double p);  // least k with cdf(k) >= probability

// The false-alarm rate for each of `tests` independent tests that gives `alpha` for all of them (Sidak 1967).
double sidak(double alpha, uint64_t tests);

// ---- means ----

struct Moments {
    double mean = 0, variance = 0;  // variance with n - 1
    uint64_t count = 0;
    double standard_error() const;
};
Moments moments(std::span<const double> values);

// ---- the equivalence test of "two means are equal" ----

// Independent runs of one renderer: own seeds, own history. Keeps each run's mean and its means over tiles, squares of 8x8 pixels unless said.
class Runs {
public:
    static constexpr uint32_t kTileSize = 8;

    Runs(uint32_t width, uint32_t height, uint32_t tile_size = kTileSize);
    // One plane (luminance or a channel), row by row.
    void add_run(std::span<const float> values);

    uint32_t count() const { return static_cast<uint32_t>(means_.size()); }
    uint32_t tile_count() const { return tiles_x_ * tiles_y_; }
    std::span<const double> means() const { return means_; }
    std::span<const double> tile_means(uint32_t tile) const { return tiles_[tile]; }  // one a run

private:
    uint32_t width_, height_, tile_size_, tiles_x_, tiles_y_;
    std::vector<double> means_;
    std::vector<std::vector<double>> tiles_;
};

// Float images that should be equal differ by rounding where nothing is random; this much of a value is no difference.
constexpr double kRounding = 1e-6;

struct Equivalence {
    bool passed = false;                     // both below
    bool mean_passed = false;                // the interval lies inside 1 +- margin, and the reference is precise enough
    bool tiles_passed = false;
    double ratio = 0, low = 0, high = 0;     // mean of test over mean of reference, 99.9 % interval
    double reference_error = 0;              // standard error of the reference's mean, relative; must be <= margin / 4
    uint32_t tiles = 0, tiles_over = 0, tiles_allowed = 0;
    std::string text = {};                        // one line for the failure message
};

// Says whether the mean of `test` equals that of `reference` to `margin` (0.01: one per cent).
//   Mean: the 99.9 % t-interval of the ratio of means (delta method, Welch-Satterthwaite degrees of freedom) must lie inside the
//   margin: noise fails. The reference's own standard error must be at most a quarter of the margin.
//   Tiles: of the runs' tiles brighter than 1 % of the reference's mean, as many may differ by |t| above its 99 % point as the 99.9 %
//   binomial quantile says: 4 of 64, 8 of 220, 14 of 576. So an equal pair fails by its tiles once in a thousand times.
// Throws std::invalid_argument for fewer than 32 test runs, fewer than 2 reference runs, or a mean that is not positive.
// `rounding`: of pictures that are stored with fewer bits than a float has, relative.
Equivalence equivalence_test(const Runs& test, const Runs& reference, double margin, double rounding = kRounding);
// The same against a truth that is known exactly (a closed form): a plane like a run's.
Equivalence equivalence_test_exact(const Runs& test, const Runs& truth, double margin);

// ---- difference tests ----

struct ZTest {
    bool passed = false;
    double worst_p = 1;     // of all pixels
    double threshold = 0;   // what it must not fall below
    size_t worst_index = 0;
    size_t below = 0;       // values whose p is below the threshold
    std::string text = {};
};
// Pixel by pixel: do two images with these variances (of the pixel values as given, so of means) have one expectation? alpha is the
// false-alarm rate of the whole image (Sidak). Subr and Arvo, "Statistical Hypothesis Testing for Assessing Monte Carlo
// Estimators", 2007. degrees_of_freedom: of the variances, where they are estimated from few runs (per image, n - 1).
ZTest z_test(std::span<const float> a, std::span<const float> variance_a, std::span<const float> b, std::span<const float> variance_b, double alpha,
             double degrees_of_freedom = std::numeric_limits<double>::infinity());
// The two-sided p of each value of that test.
std::vector<double> z_test_p(std::span<const float> a, std::span<const float> variance_a, std::span<const float> b, std::span<const float> variance_b,
                             double degrees_of_freedom = std::numeric_limits<double>::infinity());

struct ChiSquare {
    double chi2 = 0, degrees_of_freedom = 0;
    double p = 1;  // of a worse fit by chance; 0 for counts where none can be
    std::string text = {};
};
// Do counts follow their expectations? Cells that expect fewer than `min_expected` are pooled, as in pbrt's tests. `fitted` is the
// number of parameters that were fitted to the counts.
ChiSquare chi_square_test(std::span<const double> counts, std::span<const double> expected, double min_expected = 5.0, unsigned fitted = 0);

struct KolmogorovSmirnov {
    double distance = 0, p = 1;
};
// Do samples follow a continuous distribution? p by Stephens' approximation (1970).
KolmogorovSmirnov kolmogorov_smirnov_test(std::vector<double> samples, const std::function<double(double)>& cdf);

// ---- slopes ----

struct SlopeFit {
    double slope = 0, intercept = 0, standard_error = 0;  // of the slope
};
// Least squares y = slope * x + intercept; at least 3 points.
SlopeFit fit_slope(std::span<const double> x, std::span<const double> y);
// In log-log: the order of convergence of errors y over counts x.
SlopeFit fit_log_slope(std::span<const double> x, std::span<const double> y);

}  // namespace parhelion::testing
