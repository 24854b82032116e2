// What the generators of the BSDF's tables share: quadrature, quantisation, microfacets in double precision.
// Formulas as in shaders/lib/microfacet.glsl; how the tables are laid out: shaders/shared/bsdf_tables.h.
#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace tables {

using Words = std::vector<uint32_t>;

inline std::string folder;  // of the files

Words read_section(const char* name);  // a section that is written already

// The sections.
Words make_ggx();
Words make_layers();  // reads what make_ggx() wrote
Words make_glass();
Words make_coated_glass();

inline double square(double x) { return x * x; }
inline double schlick(double cosine) { return square(square(1 - cosine)) * (1 - cosine); }
// Value of an axis' point.
inline double at(uint32_t index, uint32_t count) { return double(index) / (count - 1); }
inline double mu_at(uint32_t index, uint32_t count) { return square(at(index, count)); }

uint32_t pack(double low, double high);  // two numbers in [0, 1]
double low_of(uint32_t word);            // as the shader unpacks them
double high_of(uint32_t word);
uint32_t float_word(double value);

// Nodes and weights of Gauss-Legendre quadrature on [0, 1].
std::vector<std::pair<double, double>> gauss(int count);

// int 2 cos f(cos) dcos over [0, 1] of a table that is linear between its points in sqrt(cos): exact.
double cosine_average(const std::vector<double>& points);

// The white GGX lobe (reflectance 1, scattered once) seen from cos_o > 0: calls visit(cos_i, cos_h, weight), cos_h being the cosine to
// the microfacet, for directions whose weights sum up to its albedo. They are a grid of side^2 in the numbers that the bounded
// sampling of visible normals maps (Eto and Tokuyoshi 2023).
template <class Visit>
void ggx_lobe(double cos_o, double alpha, int side, Visit visit) {
    if (alpha == 0) return visit(cos_o, cos_o, 1.0);
    const double sin_o = std::sqrt(1 - cos_o * cos_o), a2 = alpha * alpha;
    const auto stretched = [&](double c) { return std::sqrt(c * c + a2 * (1 - c * c)); };
    const double t_o = stretched(cos_o), s2 = square(1 + sin_o), k = (1 - a2) * s2 / (s2 + a2 * cos_o * cos_o), bound = k * cos_o / t_o;
    for (int column = 0; column < side; ++column) {
        const double cos_phi = std::cos(std::numbers::pi * (column + 0.5) / side);
        for (int row = 0; row < side; ++row) {
            const double z = (row + 0.5) / side * (1 + bound) - bound, s = std::sqrt(std::fmax(0.0, 1 - z * z));
            const double h_x = alpha * (s * cos_phi + alpha * sin_o / t_o), h_y2 = a2 * s * s * (1 - cos_phi * cos_phi), h_z = z + cos_o / t_o;
            const double length = std::sqrt(h_x * h_x + h_y2 + h_z * h_z);
            const double cos_h = (h_x * sin_o + h_z * cos_o) / length, cos_i = 2 * cos_h * h_z / length - cos_o;
            if (cos_i <= 0) continue;
            // D V cos_i over the density D / (2 (k cos_o + t_o)); V = 1 / (2 (cos_i t_o + cos_o t_i)).
            visit(std::fmin(cos_i, 1.0), std::fmin(cos_h, 1.0), cos_i * (k * cos_o + t_o) / (cos_i * t_o + cos_o * stretched(cos_i)) / (double(side) * side));
        }
    }
}

}  // namespace tables
