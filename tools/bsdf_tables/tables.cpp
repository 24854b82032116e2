#include "tables.h"

#include <bit>
#include <fstream>
#include <iterator>

namespace tables {

Words read_section(const char* name) {
    std::ifstream in(folder + "/bsdf_" + name + ".bin", std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(in)), {});
    Words words(bytes.size() / 4);
    for (size_t i = 0; i < words.size() * 4; ++i) words[i / 4] |= uint32_t(static_cast<unsigned char>(bytes[i])) << 8 * (i % 4);
    return words;
}

uint32_t pack(double low, double high) {
    const auto unorm = [](double v) { return static_cast<uint32_t>(std::lround(std::fmin(std::fmax(v, 0.0), 1.0) * 65535)); };
    return unorm(low) | unorm(high) << 16;
}
double low_of(uint32_t word) { return (word & 0xFFFF) / 65535.0; }
double high_of(uint32_t word) { return (word >> 16) / 65535.0; }
uint32_t float_word(double value) { return std::bit_cast<uint32_t>(static_cast<float>(value)); }

std::vector<std::pair<double, double>> gauss(int count) {
    std::vector<std::pair<double, double>> out;
    for (int k = 0; k < count; ++k) {
        double x = std::cos(std::numbers::pi * (k + 0.75) / (count + 0.5)), slope = 0;
        for (int step = 0; step < 50; ++step) {  // Newton on the Legendre polynomial
            double p = 1, before = 0;
            for (int n = 1; n <= count; ++n) before = std::exchange(p, ((2 * n - 1) * x * p - (n - 1) * before) / n);
            slope = count * (x * p - before) / (x * x - 1);
            x -= p / slope;
        }
        out.push_back({(1 - x) / 2, 1 / ((1 - x * x) * slope * slope)});
    }
    return out;
}

double cosine_average(const std::vector<double>& points) {
    static const auto nodes = gauss(4);
    double sum = 0;
    const double cells = double(points.size() - 1);
    for (size_t k = 0; k + 1 < points.size(); ++k)
        for (const auto& [x, w] : nodes) {
            const double t = (k + x) / cells;
            sum += w / cells * 4 * t * t * t * (points[k] + (points[k + 1] - points[k]) * x);  // 2 mu dmu = 4 t^3 dt
        }
    return sum;
}

}  // namespace tables
