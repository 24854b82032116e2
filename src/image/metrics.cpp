#include "image/metrics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "base/error.h"
#include "base/parallel.h"
#include "image/convolve.h"

namespace parhelion::image {

namespace {

constexpr size_t kPixelsPerTask = 65536;

bool is_finite(const RgbPlanes& image, size_t p) { return std::isfinite(image.r[p]) && std::isfinite(image.g[p]) && std::isfinite(image.b[p]); }

void check_same_size(const RgbPlanes& a, const RgbPlanes& b) {
    PARHELION_CHECK(a.r.size() == b.r.size() && a.g.size() == b.g.size() && a.b.size() == b.b.size(), "images of {} and {} pixels", a.r.size(), b.r.size());
}

// Sums `add(partial, p)` over all pixels: one partial result a task, joined in order by `join(total, partial)`.
template <class Sum, class Add, class Join>
Sum sum_pixels(size_t count, const Add& add, const Join& join) {
    std::vector<Sum> partials((count + kPixelsPerTask - 1) / kPixelsPerTask);
    parallel_for(partials.size(), 1, [&](size_t begin, size_t end) {
        for (size_t task = begin; task < end; ++task)
            for (size_t p = task * kPixelsPerTask; p < std::min(count, (task + 1) * kPixelsPerTask); ++p) add(partials[task], p);
    });
    Sum total;
    for (const Sum& partial : partials) join(total, partial);
    return total;
}

struct ChannelSums {
    std::array<double, 3> test{}, reference{};
};

struct ErrorSums {
    double squared = 0, relative = 0, largest = 0;
    uint64_t pixels = 0;
};

void add_errors(ErrorSums& sums, const RgbPlanes& test, const RgbPlanes& reference, size_t p) {
    const std::array<double, 3> t = {test.r[p], test.g[p], test.b[p]}, r = {reference.r[p], reference.g[p], reference.b[p]};
    for (size_t c = 0; c < 3; ++c) {
        const double difference = t[c] - r[c], squared = difference * difference;
        sums.squared += squared;
        sums.relative += squared / (r[c] * r[c] + kRelMseEpsilon);
        sums.largest = std::max(sums.largest, std::abs(difference));
    }
    ++sums.pixels;
}

Plane products(std::span<const float> a, std::span<const float> b) {
    Plane out(a.size());
    for (size_t i = 0; i < out.size(); ++i) out[i] = a[i] * b[i];
    return out;
}

Plane window_mean(std::span<const float> in, uint32_t width, uint32_t height, const Kernel& window) {
    Plane rows, out;
    filter_rows(in, rows, width, height, window);
    filter_columns(rows, out, width, height, window);
    return out;
}

}  // namespace

BadPixels count_bad_pixels(const RgbPlanes& image) {
    BadPixels counts;
    for (size_t p = 0; p < image.r.size(); ++p) {
        const std::array<float, 3> v = {image.r[p], image.g[p], image.b[p]};
        counts.nan += std::any_of(v.begin(), v.end(), [](float x) { return std::isnan(x); });
        counts.infinite += std::any_of(v.begin(), v.end(), [](float x) { return std::isinf(x); });
        counts.negative += std::any_of(v.begin(), v.end(), [](float x) { return x < 0.0f; });
    }
    return counts;
}

MeanRatio mean_ratio(const RgbPlanes& test, const RgbPlanes& reference) {
    check_same_size(test, reference);
    const auto add = [&](ChannelSums& sums, size_t p) {
        if (!is_finite(test, p) || !is_finite(reference, p)) return;
        const std::array<float, 3> t = {test.r[p], test.g[p], test.b[p]}, r = {reference.r[p], reference.g[p], reference.b[p]};
        for (size_t c = 0; c < 3; ++c) sums.test[c] += t[c], sums.reference[c] += r[c];
    };
    const auto join = [](ChannelSums& total, const ChannelSums& partial) {
        for (size_t c = 0; c < 3; ++c) total.test[c] += partial.test[c], total.reference[c] += partial.reference[c];
    };
    const ChannelSums sums = sum_pixels<ChannelSums>(test.r.size(), add, join);
    const auto& t = sums.test;
    const auto& r = sums.reference;
    return {t[0] / r[0], t[1] / r[1], t[2] / r[2], luminance(t[0], t[1], t[2]) / luminance(r[0], r[1], r[2])};
}

SquaredErrors squared_errors(const RgbPlanes& test, const RgbPlanes& reference) {
    check_same_size(test, reference);
    const auto add = [&](ErrorSums& sums, size_t p) {
        if (is_finite(test, p) && is_finite(reference, p)) add_errors(sums, test, reference, p);
    };
    const auto join = [](ErrorSums& total, const ErrorSums& partial) {
        total.squared += partial.squared;
        total.relative += partial.relative;
        total.largest = std::max(total.largest, partial.largest);
        total.pixels += partial.pixels;
    };
    const ErrorSums sums = sum_pixels<ErrorSums>(test.r.size(), add, join);
    if (sums.pixels == 0) return {};
    const double values = 3.0 * static_cast<double>(sums.pixels);
    return {.mse = sums.squared / values, .relmse = sums.relative / values, .max_abs_error = sums.largest};
}

double psnr_from_mse(double mse, double peak) {
    return mse > 0.0 ? 10.0 * std::log10(peak * peak / mse) : std::numeric_limits<double>::infinity();
}

double ssim(std::span<const float> test, std::span<const float> reference, uint32_t width, uint32_t height) {
    PARHELION_CHECK(test.size() == size_t{width} * height && reference.size() == test.size() && !test.empty(), "SSIM of {} and {} pixels at {}x{}",
                    test.size(), reference.size(), width, height);
    static constexpr int kRadius = 5;
    static constexpr double kC1 = 0.01 * 0.01, kC2 = 0.03 * 0.03;
    const Kernel window = gaussian_kernel(1.5, kRadius);
    const auto mean = [&](std::span<const float> in) { return window_mean(in, width, height, window); };
    const Plane mean_t = mean(test), mean_r = mean(reference);
    const Plane mean_tt = mean(products(test, test)), mean_rr = mean(products(reference, reference)), mean_tr = mean(products(test, reference));

    const bool has_inside = width > 2 * kRadius && height > 2 * kRadius;
    const uint32_t margin = has_inside ? kRadius : 0;
    double sum = 0;
    for (uint32_t y = margin; y < height - margin; ++y)
        for (uint32_t x = margin; x < width - margin; ++x) {
            const size_t p = size_t{y} * width + x;
            const double t = mean_t[p], r = mean_r[p];
            const double variance_t = mean_tt[p] - t * t, variance_r = mean_rr[p] - r * r, covariance = mean_tr[p] - t * r;
            sum += (2 * t * r + kC1) * (2 * covariance + kC2) / ((t * t + r * r + kC1) * (variance_t + variance_r + kC2));
        }
    return sum / (static_cast<double>(width - 2 * margin) * (height - 2 * margin));
}

}  // namespace parhelion::image
