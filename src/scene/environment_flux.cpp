#include "scene/environment_flux.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/parallel.h"
#include "image/image.h"

namespace parhelion {

namespace {


// How much of a texel a cell holds.
struct Share {
    int64_t texel;  // as the filter counts, before it wraps
    double weight;
};

// The shares of each of `cells` equal parts of an axis of `texels`, by cell. An azimuth is measured in texels, a polar angle by
// solid angle: with theta = k t, d(-cos theta) = k sin(k t) dt.
std::vector<std::vector<Share>> cell_shares(uint32_t texels, uint32_t cells, bool polar) {
    std::vector<std::vector<Share>> out(cells);
    const double k = std::numbers::pi / texels;
    const auto measure = [&](double a, double b) { return polar ? 2 * std::sin(k * (a + b) / 2) * std::sin(k * (b - a) / 2) : b - a; };
    // An antiderivative of (t - from) times the measure.
    const auto slope = [&](double t, double from) { return polar ? std::sin(k * t) / k - (t - from) * std::cos(k * t) : 0.5 * (t - from) * (t - from); };
    for (uint32_t c = 0; c < cells; ++c) {
        const double begin = double(texels) * c / cells, end = double(texels) * (c + 1) / cells;
        // Between the middles of texels i and i + 1 the filter goes from the one to the other.
        for (auto i = static_cast<int64_t>(std::floor(begin - 0.5)); double(i) + 0.5 < end; ++i) {
            const double middle = double(i) + 0.5, a = std::max(begin, middle), b = std::min(end, middle + 1);
            const double second = slope(b, middle) - slope(a, middle), first = measure(a, b) - second;
            if (first > 0) out[c].push_back({i, first});
            if (second > 0) out[c].push_back({i + 1, second});
        }
    }
    return out;
}

}  // namespace

double environment_cell_solid_angle(uint32_t row, uint32_t columns, uint32_t rows) {
    return 2 * std::numbers::pi / columns * 2 * std::sin(std::numbers::pi * (row + 0.5) / rows) * std::sin(0.5 * std::numbers::pi / rows);
}

std::vector<double> environment_flux(const Environment& e, uint32_t columns, uint32_t rows) {
    std::vector<double> out(size_t(columns) * rows, 0.0);
    if (e.radiance.empty()) {
        for (size_t i = 0; i < out.size(); ++i) out[i] = environment_cell_solid_angle(static_cast<uint32_t>(i / columns), columns, rows);
        return out;
    }
    const std::vector<std::vector<Share>> across = cell_shares(e.width, columns, false), down = cell_shares(e.height, rows, true);
    std::vector<double> narrowed(size_t(columns) * e.height);  // each row of texels by columns of cells
    parallel_for(e.height, 16, [&](size_t begin, size_t end) {
        for (size_t y = begin; y < end; ++y)
            for (uint32_t c = 0; c < columns; ++c) {
                double sum = 0;
                for (const Share& share : across[c]) {
                    const glm::vec3 radiance = e.radiance[y * e.width + size_t((share.texel + int64_t(e.width)) % int64_t(e.width))];
                    sum += share.weight * image::luminance(double(radiance.r), double(radiance.g), double(radiance.b));
                }
                narrowed[y * columns + c] = sum * 2 * std::numbers::pi / e.width;
            }
    });
    parallel_for(rows, 16, [&](size_t begin, size_t end) {
        for (size_t r = begin; r < end; ++r)
            for (const Share& share : down[r]) {
                const double* row = narrowed.data() + size_t(std::clamp<int64_t>(share.texel, 0, int64_t(e.height) - 1)) * columns;
                for (uint32_t c = 0; c < columns; ++c) out[r * columns + c] += share.weight * row[c];
            }
    });
    return out;
}

}  // namespace parhelion
