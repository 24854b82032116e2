#include "image/convolve.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/parallel.h"

namespace parhelion::image {

namespace {

// Pixels whose sums are kept together: enough to fill vector registers, with a length that the compiler knows.
constexpr size_t kLanes = 16;
constexpr size_t kRowsPerTask = 16;

size_t padded_width(uint32_t width) { return (width + kLanes - 1) / kLanes * kLanes; }

// out[0..kLanes) = sum over k of kernel[k] * sources(k)[0..kLanes).
template <class Source>
void weigh(const Kernel& kernel, const Source& source, float* out) {
    std::array<float, kLanes> sum{};
    for (size_t k = 0; k < kernel.size(); ++k) {
        const float weight = kernel[k];
        const float* in = source(k);
        for (size_t i = 0; i < kLanes; ++i) sum[i] += weight * in[i];
    }
    std::copy(sum.begin(), sum.end(), out);
}

}  // namespace

void filter_rows(std::span<const float> in, Plane& out, uint32_t width, uint32_t height, const Kernel& kernel) {
    const size_t radius = kernel.size() / 2, padded = padded_width(width);
    out.resize(size_t{width} * height);
    parallel_for(height, kRowsPerTask, [&](size_t begin, size_t end) {
        std::vector<float> row(padded + 2 * radius), sums(padded);
        for (size_t y = begin; y < end; ++y) {
            const float* source = in.data() + y * width;
            std::fill_n(row.begin(), radius, source[0]);
            std::copy_n(source, width, row.begin() + static_cast<std::ptrdiff_t>(radius));
            std::fill(row.begin() + static_cast<std::ptrdiff_t>(radius + width), row.end(), source[width - 1]);
            for (size_t x = 0; x < padded; x += kLanes) weigh(kernel, [&](size_t k) { return row.data() + x + k; }, sums.data() + x);
            std::copy_n(sums.begin(), width, out.begin() + static_cast<std::ptrdiff_t>(y * width));
        }
    });
}

void filter_columns(std::span<const float> in, Plane& out, uint32_t width, uint32_t height, const Kernel& kernel) {
    const auto radius = static_cast<std::ptrdiff_t>(kernel.size() / 2);
    out.resize(size_t{width} * height);
    const auto row_at = [&](size_t y, size_t k) {
        const std::ptrdiff_t wanted = static_cast<std::ptrdiff_t>(y + k) - radius;
        return in.data() + static_cast<size_t>(std::clamp<std::ptrdiff_t>(wanted, 0, height - 1)) * width;
    };
    parallel_for(height, kRowsPerTask, [&](size_t begin, size_t end) {
        for (size_t y = begin; y < end; ++y) {
            float* target = out.data() + y * width;
            size_t x = 0;
            for (; x + kLanes <= width; x += kLanes) weigh(kernel, [&](size_t k) { return row_at(y, k) + x; }, target + x);
            for (; x < width; ++x) {
                target[x] = 0.0f;
                for (size_t k = 0; k < kernel.size(); ++k) target[x] += kernel[k] * row_at(y, k)[x];
            }
        }
    });
}

Kernel gaussian_kernel(double sigma, int radius) {
    std::vector<double> weights;
    double sum = 0;
    for (int x = -radius; x <= radius; ++x) {
        weights.push_back(std::exp(-0.5 * x * x / (sigma * sigma)));
        sum += weights.back();
    }
    Kernel kernel;
    for (const double weight : weights) kernel.push_back(static_cast<float>(weight / sum));
    return kernel;
}

}  // namespace parhelion::image
