#include "image/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "base/error.h"
#include "base/parallel.h"
#include "image/convolve.h"
#include "image/tonemap.h"

namespace parhelion::image {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr size_t kPixelsPerTask = 16384;

// ---- colour spaces (2020 paper, 4.1) ----

// XYZ of linear Rec.709 and its white, by which both opponent spaces divide.
constexpr std::array<Rgb, 3> kXyzFromRgb = {{{10135552.0f / 24577794.0f, 8788810.0f / 24577794.0f, 4435075.0f / 24577794.0f},
                                             {2613072.0f / 12288897.0f, 8788810.0f / 12288897.0f, 887015.0f / 12288897.0f},
                                             {1425312.0f / 73733382.0f, 8788810.0f / 73733382.0f, 70074185.0f / 73733382.0f}}};
constexpr std::array<Rgb, 3> kRgbFromXyz = {
    {{3.241003275f, -1.537398934f, -0.498615861f}, {-0.969224334f, 1.875930071f, 0.041554224f}, {0.055639423f, -0.204011202f, 1.057148933f}}};
constexpr Rgb kWhite = {kXyzFromRgb[0][0] + kXyzFromRgb[0][1] + kXyzFromRgb[0][2], 1.0f, kXyzFromRgb[2][0] + kXyzFromRgb[2][1] + kXyzFromRgb[2][2]};

Rgb multiply(const std::array<Rgb, 3>& m, const Rgb& v) {
    Rgb out;
    for (size_t i = 0; i < 3; ++i) out[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
    return out;
}

// Relative to white: white is (1, 1, 1).
Rgb relative_xyz(const Rgb& rgb) {
    const Rgb xyz = multiply(kXyzFromRgb, rgb);
    return {xyz[0] / kWhite[0], xyz[1], xyz[2] / kWhite[2]};
}

// YCxCz, the linear opponent space in which the eye's blur is applied.
Rgb opponent_from_rgb(const Rgb& rgb) {
    const Rgb xyz = relative_xyz(rgb);
    return {116.0f * xyz[1] - 16.0f, 500.0f * (xyz[0] - xyz[1]), 200.0f * (xyz[1] - xyz[2])};
}

Rgb rgb_from_opponent(const Rgb& opponent) {
    const float y = (opponent[0] + 16.0f) / 116.0f;
    return multiply(kRgbFromXyz, {(opponent[1] / 500.0f + y) * kWhite[0], y, (y - opponent[2] / 200.0f) * kWhite[2]});
}

// CIE L*a*b*, a* and b* scaled by lightness (the Hunt effect).
Rgb hunt_lab_from_rgb(const Rgb& rgb) {
    static constexpr float kDelta = 6.0f / 29.0f;
    Rgb f = relative_xyz(rgb);
    for (float& t : f) t = t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3.0f * kDelta * kDelta) + 4.0f / 29.0f;
    const float lightness = 116.0f * f[1] - 16.0f, hunt = 0.01f * lightness;
    return {lightness, hunt * 500.0f * (f[0] - f[1]), hunt * 200.0f * (f[1] - f[2])};
}

// The HyAB distance (Abasi et al. 2019), to the power 0.7 that the paper compresses large distances with.
float color_distance(const Rgb& a, const Rgb& b) {
    const float chroma = std::sqrt((a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
    return std::pow(std::abs(a[0] - b[0]) + chroma, 0.7f);
}

// Distances to [0,1]: the smaller ones, up to 0.4 of the largest (green to blue), take 0.95 of the range.
float redistribute(float distance) {
    static const float kLargest = color_distance(hunt_lab_from_rgb({0, 1, 0}), hunt_lab_from_rgb({0, 0, 1}));
    static constexpr float kShare = 0.4f, kRange = 0.95f;
    const float limit = kShare * kLargest;
    return distance < limit ? kRange / limit * distance : kRange + (distance - limit) / (kLargest - limit) * (1.0f - kRange);
}

// ---- filters ----

// A Gaussian of the contrast sensitivity functions, amplitude a and width b in degrees (2020 paper, table 1), sampled at pixels.
// The whole two-dimensional filter is a sum of these, each separable; `share` is its part of the filter's sum.
struct Blur {
    Kernel kernel;
    double share;
};

// Weights below this fraction of the middle one move no result by 1e-6 and are left out.
constexpr double kNegligible = 1e-8;

std::vector<Blur> contrast_blurs(std::initializer_list<std::array<double, 2>> gaussians, double ppd, int radius) {
    std::vector<Blur> blurs;
    double total = 0;
    for (const auto& [a, b] : gaussians) {
        const double sigma = std::sqrt(b / (2.0 * kPi * kPi)) * ppd;
        const int reach = std::min(radius, static_cast<int>(std::ceil(sigma * std::sqrt(-2.0 * std::log(kNegligible)))));
        double sum = 0;
        for (int x = -reach; x <= reach; ++x) sum += std::exp(-0.5 * x * x / (sigma * sigma));
        blurs.push_back({gaussian_kernel(sigma, reach), a * std::sqrt(kPi / b) * sum * sum});
        total += blurs.back().share;
    }
    for (Blur& blur : blurs) blur.share /= total;
    return blurs;
}

struct Filters {
    std::array<std::vector<Blur>, 3> contrast;  // of Y, Cx, Cz
    Kernel gaussian, edge, point;               // of features: a Gaussian, its first and its second derivative

    explicit Filters(double ppd) {
        const int radius = static_cast<int>(std::ceil(3.0 * std::sqrt(0.04 / (2.0 * kPi * kPi)) * ppd));
        contrast = {contrast_blurs({{1.0, 0.0047}}, ppd, radius), contrast_blurs({{1.0, 0.0053}}, ppd, radius),
                    contrast_blurs({{34.1, 0.04}, {13.5, 0.025}}, ppd, radius)};
        const double sigma = 0.5 * 0.082 * ppd;  // features of 0.082 degrees
        const int reach = static_cast<int>(std::ceil(3.0 * sigma));
        gaussian = gaussian_kernel(sigma, reach);
        edge = derivative(reach, [](double x) { return -x; });
        point = derivative(reach, [&](double x) { return x * x / (sigma * sigma) - 1.0; });
    }

private:
    // gaussian * factor with positive weights of sum 1 and negative of sum -1.
    template <class Factor>
    Kernel derivative(int reach, const Factor& factor) const {
        Kernel kernel;
        double positive = 0, negative = 0;
        for (int x = -reach; x <= reach; ++x) {
            const double weight = factor(x) * gaussian[static_cast<size_t>(x + reach)];
            (weight > 0 ? positive : negative) += std::abs(weight);
            kernel.push_back(static_cast<float>(weight));
        }
        for (float& weight : kernel) weight = static_cast<float>(weight / (weight > 0 ? positive : negative));
        return kernel;
    }
};

using Planes3 = std::array<Plane, 3>;

// What an image contributes to the difference.
struct Percept {
    Planes3 lab;          // Hunt-adjusted, blurred as the eye does
    Plane edges, points;  // strengths of the two features
};

void add_scaled(Plane& sum, const Plane& plane, float scale) {
    if (sum.empty()) sum.resize(plane.size());
    for (size_t i = 0; i < plane.size(); ++i) sum[i] += scale * plane[i];
}

// The magnitude of (d/dx, d/dy) of y by `kernel`; `smooth` is the Gaussian across, `smooth_rows` is y filtered with it along rows.
Plane feature_strength(const Plane& y, const Plane& smooth_rows, uint32_t width, uint32_t height, const Kernel& kernel, const Kernel& smooth) {
    Plane rows, dx, dy;
    filter_rows(y, rows, width, height, kernel);
    filter_columns(rows, dx, width, height, smooth);
    filter_columns(smooth_rows, dy, width, height, kernel);
    for (size_t i = 0; i < dx.size(); ++i) dx[i] = std::sqrt(dx[i] * dx[i] + dy[i] * dy[i]);
    return dx;
}

// rgb: linear, in [0,1]; used up.
Percept perceive(Planes3 rgb, uint32_t width, uint32_t height, const Filters& filters) {
    const size_t pixels = rgb[0].size();
    Plane y(pixels);
    parallel_for(pixels, kPixelsPerTask, [&](size_t begin, size_t end) {
        for (size_t p = begin; p < end; ++p) {
            const Rgb opponent = opponent_from_rgb({rgb[0][p], rgb[1][p], rgb[2][p]});
            for (size_t c = 0; c < 3; ++c) rgb[c][p] = opponent[c];
            y[p] = (opponent[0] + 16.0f) / 116.0f;
        }
    });

    Percept out;
    Plane rows, blurred;
    filter_rows(y, rows, width, height, filters.gaussian);
    out.edges = feature_strength(y, rows, width, height, filters.edge, filters.gaussian);
    out.points = feature_strength(y, rows, width, height, filters.point, filters.gaussian);

    for (size_t c = 0; c < 3; ++c)
        for (const Blur& blur : filters.contrast[c]) {
            filter_rows(rgb[c], rows, width, height, blur.kernel);
            filter_columns(rows, blurred, width, height, blur.kernel);
            add_scaled(out.lab[c], blurred, static_cast<float>(blur.share));
        }
    parallel_for(pixels, kPixelsPerTask, [&](size_t begin, size_t end) {
        for (size_t p = begin; p < end; ++p) {
            Rgb seen = rgb_from_opponent({out.lab[0][p], out.lab[1][p], out.lab[2][p]});
            for (float& component : seen) component = std::clamp(component, 0.0f, 1.0f);
            const Rgb lab = hunt_lab_from_rgb(seen);
            for (size_t c = 0; c < 3; ++c) out.lab[c][p] = lab[c];
        }
    });
    return out;
}

// Raises `map` to the difference where that is larger.
void raise_to_difference(const Percept& a, const Percept& b, std::vector<float>& map) {
    static constexpr float kInvSqrt2 = 0.70710678f;
    parallel_for(map.size(), kPixelsPerTask, [&](size_t begin, size_t end) {
        for (size_t p = begin; p < end; ++p) {
            const float color = redistribute(color_distance({a.lab[0][p], a.lab[1][p], a.lab[2][p]}, {b.lab[0][p], b.lab[1][p], b.lab[2][p]}));
            const float feature = std::sqrt(kInvSqrt2 * std::max(std::abs(a.edges[p] - b.edges[p]), std::abs(a.points[p] - b.points[p])));
            const float error = color > 0.0f ? std::pow(color, std::max(0.0f, 1.0f - feature)) : 0.0f;
            map[p] = std::max(map[p], std::min(error, 1.0f));
        }
    });
}

double mean_of(const std::vector<float>& values) {
    return values.empty() ? 0.0 : std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

// ---- HDR ----

// The papers' tone curve for HDR-FLIP: Narkowicz's fit of ACES (2015) of 0.6 x.
constexpr std::array<double, 5> kCurve = {0.36 * 2.51, 0.6 * 0.03, 0.36 * 2.43, 0.6 * 0.59, 0.14};

float flip_tone_curve(float x) {
    static constexpr float kTop = 1e6f;  // white by far; keeps the squares finite
    x = std::min(x, kTop);
    const float value = (static_cast<float>(kCurve[0]) * x * x + static_cast<float>(kCurve[1]) * x) /
                        (static_cast<float>(kCurve[2]) * x * x + static_cast<float>(kCurve[3]) * x + static_cast<float>(kCurve[4]));
    return std::clamp(value, 0.0f, 1.0f);
}

// Where the curve reaches 85 %: the quadratic's larger root.
double luminance_at_85_percent() {
    const double t = 0.85, a = kCurve[0] - t * kCurve[2], b = kCurve[1] - t * kCurve[3], c = -t * kCurve[4];
    return (-b + std::sqrt(b * b - 4.0 * a * c)) / (2.0 * a);
}

float usable(float v) { return std::isfinite(v) && v > 0.0f ? v : 0.0f; }

struct Exposures {
    double start = 0.0, stop = 0.0;
    uint32_t count = 0;  // 0: everything is black
};

Exposures choose_exposures(const RgbPlanes& image) {
    static constexpr double kMaxStops = 40.0;
    std::vector<float> values(image.r.size());
    for (size_t p = 0; p < values.size(); ++p) values[p] = luminance(usable(image.r[p]), usable(image.g[p]), usable(image.b[p]));
    const auto middle = [&] { return values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2); };
    std::nth_element(values.begin(), middle(), values.end());
    if (values.empty() || *middle() <= 0.0f) {
        values.erase(std::remove(values.begin(), values.end(), 0.0f), values.end());
        if (values.empty()) return {};
        std::nth_element(values.begin(), middle(), values.end());
    }
    const double median = *middle(), brightest = *std::max_element(middle(), values.end()), target = luminance_at_85_percent();
    Exposures out{.start = std::log2(target / brightest), .stop = std::log2(target / median)};
    out.stop = std::min(out.stop, out.start + kMaxStops);
    out.count = std::max(2u, static_cast<uint32_t>(std::ceil(out.stop - out.start)));
    return out;
}

// The three planes with `map` applied to each value.
template <class Map>
Planes3 map_planes(const RgbPlanes& image, const Map& map) {
    Planes3 out;
    const std::array<std::span<const float>, 3> in = {image.r, image.g, image.b};
    for (size_t c = 0; c < 3; ++c) {
        out[c].resize(in[c].size());
        parallel_for(out[c].size(), kPixelsPerTask, [&](size_t begin, size_t end) {
            for (size_t p = begin; p < end; ++p) out[c][p] = map(in[c][p]);
        });
    }
    return out;
}

Planes3 expose(const RgbPlanes& image, double exposure) {
    const auto scale = static_cast<float>(std::exp2(exposure));
    return map_planes(image, [&](float v) { return flip_tone_curve(usable(v) * scale); });
}

Planes3 clamp_planes(const RgbPlanes& image) {
    return map_planes(image, [](float v) { return v > 0.0f ? std::min(v, 1.0f) : 0.0f; });
}

void check_sizes(const RgbPlanes& reference, const RgbPlanes& test, uint32_t width, uint32_t height) {
    const size_t pixels = size_t{width} * height;
    PARHELION_CHECK(pixels > 0 && reference.r.size() == pixels && test.r.size() == pixels, "FLIP of {} and {} pixels at {}x{}", reference.r.size(),
                    test.r.size(), width, height);
}

}  // namespace

Flip flip_ldr(const RgbPlanes& reference, const RgbPlanes& test, uint32_t width, uint32_t height, double pixels_per_degree) {
    check_sizes(reference, test, width, height);
    const Filters filters(pixels_per_degree);
    Flip out;
    out.map.resize(reference.r.size());
    raise_to_difference(perceive(clamp_planes(reference), width, height, filters), perceive(clamp_planes(test), width, height, filters), out.map);
    out.mean = mean_of(out.map);
    return out;
}

Flip flip_hdr(const RgbPlanes& reference, const RgbPlanes& test, uint32_t width, uint32_t height, double pixels_per_degree) {
    check_sizes(reference, test, width, height);
    Exposures exposures = choose_exposures(reference);
    if (exposures.count == 0) exposures = choose_exposures(test);
    const Filters filters(pixels_per_degree);
    Flip out{.start_exposure = exposures.start, .stop_exposure = exposures.stop, .exposures = exposures.count};
    out.map.resize(reference.r.size());
    for (uint32_t i = 0; i < exposures.count; ++i) {
        const double exposure = exposures.start + (exposures.stop - exposures.start) * i / (exposures.count - 1);
        raise_to_difference(perceive(expose(reference, exposure), width, height, filters), perceive(expose(test, exposure), width, height, filters), out.map);
    }
    out.mean = mean_of(out.map);
    return out;
}

Picture8 flip_picture(const Flip& flip, uint32_t width, uint32_t height) {
    // sRGB values at equal steps; lightness rises all the way.
    static constexpr std::array<Rgb, 7> kColors = {{{0.00f, 0.00f, 0.02f}, {0.18f, 0.06f, 0.36f}, {0.44f, 0.12f, 0.50f}, {0.74f, 0.22f, 0.46f},
                                                    {0.95f, 0.43f, 0.36f}, {1.00f, 0.72f, 0.48f}, {0.99f, 0.99f, 0.78f}}};
    Picture8 out{.width = width, .height = height};
    out.rgb.resize(3 * flip.map.size());
    for (size_t p = 0; p < flip.map.size(); ++p) {
        const float position = std::clamp(flip.map[p], 0.0f, 1.0f) * static_cast<float>(kColors.size() - 1);
        const size_t i = std::min(static_cast<size_t>(position), kColors.size() - 2);
        const float t = position - static_cast<float>(i);
        for (size_t c = 0; c < 3; ++c) out.rgb[3 * p + c] = static_cast<uint8_t>(std::lround(255.0f * ((1.0f - t) * kColors[i][c] + t * kColors[i + 1][c])));
    }
    return out;
}

}  // namespace parhelion::image
