// Rough glass in double precision, for the generators that average over its lobes. Formulas as in shaders/lib/glass.glsl.
#pragma once
#include <algorithm>

#include "shared/bsdf_tables.h"
#include "tables.h"

namespace tables {

// Index of refraction, denser over rarer, at a point of its axis.
inline double glass_index_at(uint32_t point, uint32_t count) {
    const double r = square(at(point, count)) * parhelion::shared::kGlassMaxReflection;
    return std::max((1 + r) / (1 - r), 1 + 1e-6);
}

inline double fresnel(double cos_o, double cos_i, double eta) {
    const double s = (cos_o - eta * cos_i) / (cos_o + eta * cos_i), p = (eta * cos_o - cos_i) / (eta * cos_o + cos_i);
    return (s * s + p * p) / 2;
}

// Masking and shadowing of directions on opposite sides: ggx_masking_across() of shaders/lib/glass.glsl.
inline double masking_across(double lambda_a, double lambda_b) {
    const double x = 2 + lambda_a, y = 2 + lambda_b, sum = x + y;
    const auto stirling = [](double z) { return (1.0 / 12 - (1.0 / 360 - 1.0 / 1260 / (z * z)) / (z * z)) / z; };
    const double exponent = x * std::log(x / sum) + y * std::log(y / sum) + stirling(x) + stirling(y) - stirling(sum);
    return std::sqrt(2 * std::numbers::pi * sum / (x * y)) * std::exp(exponent) * (sum - 2) * (sum - 1) / ((x - 1) * (y - 1));
}

// What rough glass scatters once, seen from cos_o (alpha > 0): calls visit(crosses, cosine of the direction, weight with all of
// Fresnel's reflectance, weight with none but where it is total). Directions are a lattice of the numbers that the sampling of visible
// normals maps, Fibonacci's, which takes the edges (the horizon, the critical angle) best.
template <class Visit>
void glass_lobe(double cos_o, double alpha, double eta, Visit visit) {
    constexpr int kPoints = 10946, kStep = 6765;
    const double sin_o = std::sqrt(1 - cos_o * cos_o), a2 = alpha * alpha;
    const auto lambda = [&](double c) { return (std::sqrt(1 + a2 * std::fmax(1 - c * c, 0.0) / (c * c)) - 1) / 2; };
    const double stretch = std::sqrt(cos_o * cos_o + a2 * sin_o * sin_o), w_x = alpha * sin_o / stretch, w_z = cos_o / stretch, lambda_o = lambda(cos_o);
    static const auto lattice = [] {
        std::vector<std::pair<double, double>> points;
        for (int k = 0; k < kPoints; ++k) points.push_back({std::cos(std::numbers::pi * (k + 0.5) / kPoints), (k * kStep % kPoints + 0.5) / kPoints});
        return points;
    }();
    for (const auto& [cos_phi, u] : lattice) {
        const double z = u * (1 + w_z) - w_z, s = std::sqrt(std::fmax(0.0, 1 - z * z));
        const double h_x = alpha * (s * cos_phi + w_x), h_y2 = a2 * s * s * (1 - cos_phi * cos_phi), h_z = z + w_z, length = std::sqrt(h_x * h_x + h_y2 + h_z * h_z);
        const double cos_h = h_z / length, cos_oh = std::fmin((h_x * sin_o + h_z * cos_o) / length, 1.0);
        const double turned = (eta - 1) * (eta + 1) + cos_oh * cos_oh, refracted = std::sqrt(std::fmax(turned, 0.0)), reflectance = turned > 0 ? fresnel(cos_oh, refracted / eta, eta) : 1.0;
        const double up = std::fmin(2 * cos_oh * cos_h - cos_o, 1.0), down = std::fmin((cos_o + (refracted - cos_oh) * cos_h) / eta, 1.0);
        if (up > 0) {
            const double weight = (1 + lambda_o) / (1 + lambda_o + lambda(up)) / kPoints;
            visit(false, up, reflectance * weight, turned > 0 ? 0.0 : weight);
        }
        if (turned > 0 && down > 0) {
            const double weight = (1 + lambda_o) * masking_across(lambda_o, lambda(down)) / kPoints;
            visit(true, down, (1 - reflectance) * weight, weight);
        }
    }
}

// The mean of 2 cos f over [0, 1] of a table that is linear between its points in the fourth root of the cosine: exact.
inline double cosine_average_fourth_root(const std::vector<double>& points) {
    static const auto nodes = gauss(5);
    const double cells = double(points.size() - 1);
    double sum = 0;
    for (size_t k = 0; k + 1 < points.size(); ++k)
        for (const auto& [x, w] : nodes) sum += w / cells * 8 * std::pow((k + x) / cells, 7) * (points[k] + (points[k + 1] - points[k]) * x);  // 2 mu dmu = 8 t^7 dt
    return sum;
}

}  // namespace tables
