// Section bsdf_layers.bin: sheen, and averages of the layers' albedos over lobes below them.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "shared/bsdf_tables.h"
#include "tables.h"

namespace tables {

using namespace parhelion::shared;

namespace {

// An albedo over sqrt(cosine), linear between its points.
struct Curve {
    std::vector<double> points;
    double operator()(double cosine) const {
        const double x = std::sqrt(cosine) * (points.size() - 1);
        const size_t i = std::min(static_cast<size_t>(x), points.size() - 2);
        return points[i] + (points[i + 1] - points[i]) * (x - i);
    }
    // int 2 cos this(cos) weight(cos) dcos, both linear in sqrt(cos) between points of the finer one.
    double average(const Curve& weight) const {
        const auto nodes = gauss(4);
        const size_t cells = std::max(points.size(), weight.points.size()) - 1;
        double sum = 0;
        for (size_t k = 0; k < cells; ++k)
            for (const auto& [x, w] : nodes) {
                const double t = (k + x) / cells;
                sum += w / cells * 4 * t * t * t * (*this)(t * t) * weight(t * t);
            }
        return sum;
    }
};

// ---- GGX, from its section as shaders read it ----

struct Ggx {
    Words words = read_section("ggx");
    Curve row(double roughness, bool high) const {
        const double y = roughness * (kGgxRoughness - 1);
        const uint32_t j = std::min(static_cast<uint32_t>(y), kGgxRoughness - 2);
        const auto value = [&](uint32_t m, uint32_t r) { return high ? high_of(words[r * kGgxMu + m]) : low_of(words[r * kGgxMu + m]); };
        Curve out;
        for (uint32_t m = 0; m < kGgxMu; ++m) out.points.push_back(std::lerp(value(m, j), value(m, j + 1), y - j));
        return out;
    }
    Curve loss(double roughness) const { return row(roughness, false); }
    Curve grazing(double roughness) const { return row(roughness, true); }
    // Albedo of the clear coat, compensation included (lib/layers.glsl).
    Curve coat(double roughness) const {
        const Curve l = loss(roughness), g = grazing(roughness);
        const double average = kCoatF0 + (1 - kCoatF0) / 21, lost = cosine_average(l.points), again = average * average * (1 - lost) / (1 - average * lost);
        Curve out;
        for (uint32_t m = 0; m < kGgxMu; ++m) out.points.push_back(kCoatF0 * (1 - l.points[m] - g.points[m]) + g.points[m] + again * l.points[m]);
        return out;
    }
};

// ---- sheen: Estevez and Kulla 2017, "Production Friendly Microfacet Sheen BRDF" ----

// place: on the sheen's axis.
double sheen_alpha(double place) { return square(std::lerp(double(kMinSheenRoughness), 1.0, place)); }

double sheen_lambda(double cosine, double alpha) {
    const double blend = square(1 - alpha);
    const auto fit = [&](double x) {
        return std::lerp(21.5473, 25.3245, blend) / (1 + std::lerp(3.82987, 3.32435, blend) * std::pow(x, std::lerp(0.19823, 0.16801, blend))) +
               std::lerp(-1.97760, -1.27393, blend) * x + std::lerp(-4.32054, -4.85967, blend);
    };
    return cosine < 0.5 ? std::exp(fit(cosine)) : std::exp(2 * fit(0.5) - fit(1 - cosine));
}

// visit(cos_i, weight): the lobe seen from cos_o, the weights' sum is its albedo. Gauss in sqrt(cos_i), midpoints in azimuth.
template <class Visit>
void sheen_lobe(double cos_o, double alpha, Visit visit) {
    static const auto nodes = gauss(64);
    constexpr int kAzimuths = 96;
    const double sin_o = std::sqrt(1 - cos_o * cos_o), lambda_o = sheen_lambda(cos_o, alpha);
    for (const auto& [t, w] : nodes) {
        const double cos_i = t * t, sin_i = std::sqrt(1 - cos_i * cos_i);
        double distribution = 0;
        for (int k = 0; k < kAzimuths; ++k) {
            const double cosine = cos_o * cos_i + sin_o * sin_i * std::cos(std::numbers::pi * (k + 0.5) / kAzimuths);
            const double sin2 = std::max(0.0, 1 - square(cos_o + cos_i) / (2 + 2 * cosine));
            distribution += (2 + 1 / alpha) * std::pow(sin2, 0.5 / alpha) / (2 * std::numbers::pi) / kAzimuths;
        }
        visit(cos_i, w * 2 * t * 2 * std::numbers::pi * distribution / ((1 + lambda_o + sheen_lambda(cos_i, alpha)) * 4 * cos_o));
    }
}

struct Sheen {
    Curve albedo, cap;
};
Sheen make_sheen(double place, uint32_t points) {
    const double alpha = sheen_alpha(place);
    const auto cos_at = [&](uint32_t m) { return std::max(mu_at(m, points), 1e-7); };
    Sheen out;
    for (uint32_t m = 0; m < points; ++m) {
        double all = 0;
        sheen_lobe(cos_at(m), alpha, [&](double, double weight) { all += weight; });
        out.cap.points.push_back(std::min(1.0, 1 / all));
    }
    for (uint32_t m = 0; m < points; ++m) {
        double all = 0;
        sheen_lobe(cos_at(m), alpha, [&](double cos_i, double weight) { all += weight * out.cap(cos_i); });
        out.albedo.points.push_back(all * out.cap.points[m]);
    }
    return out;
}

// ---- averages over lobes below ----

void add_over_ggx(const std::vector<Curve>& layers, Words& words) {
    constexpr int kSide = 128;
    const size_t first = words.size();
    words.resize(first + kLayerMu * kLayerBelow * kLayerRoughness);
    for (uint32_t below = 0; below < kLayerBelow; ++below)
        for (uint32_t m = 0; m < kLayerMu; ++m) {
            std::vector<std::pair<double, double>> sums(kLayerRoughness);
            ggx_lobe(std::max(mu_at(m, kLayerMu), 1e-7), square(at(below, kLayerBelow)), kSide, [&](double cos_i, double cos_h, double weight) {
                for (uint32_t r = 0; r < kLayerRoughness; ++r) {
                    const double s = weight * layers[r](cos_i);
                    sums[r].first += s * (1 - schlick(cos_h));
                    sums[r].second += s * schlick(cos_h);
                }
            });
            for (uint32_t r = 0; r < kLayerRoughness; ++r) words[first + (r * kLayerBelow + below) * kLayerMu + m] = pack(sums[r].first, sums[r].second);
        }
}

void add_over_loss(const Ggx& ggx, const std::vector<Curve>& layers, Words& words) {
    for (const Curve& layer : layers)
        for (uint32_t below = 0; below < kLayerBelow; ++below) {
            const Curve loss = ggx.loss(at(below, kLayerBelow)), grazing = ggx.grazing(at(below, kLayerBelow));
            const double lost = cosine_average(loss.points);
            words.push_back(pack(lost > 0 ? layer.average(loss) / lost : layer(0), layer.average(grazing)));
        }
}

void add_coat_over_sheen(const std::vector<Curve>& coats, Words& words) {
    const size_t first = words.size();
    words.resize(first + kLayerMu * kLayerRoughness * kLayerRoughness);
    for (uint32_t r = 0; r < kLayerRoughness; ++r) {
        const Sheen sheen = make_sheen(at(r, kLayerRoughness), kSheenMu);
        for (uint32_t m = 0; m < kLayerMu; ++m) {
            std::vector<double> sums(coats.size());
            const double cos_o = std::max(mu_at(m, kLayerMu), 1e-7);
            sheen_lobe(cos_o, sheen_alpha(at(r, kLayerRoughness)), [&](double cos_i, double weight) {
                for (size_t c = 0; c < coats.size(); ++c) sums[c] += weight * sheen.cap(cos_i) * coats[c](cos_i);
            });
            for (size_t c = 0; c < coats.size(); ++c) words[first + (c * kLayerRoughness + r) * kLayerMu + m] = pack(sums[c] * sheen.cap(cos_o), 0);
        }
    }
}

}  // namespace

Words make_layers() {
    const Ggx ggx;
    Words words, averages;
    for (uint32_t r = 0; r < kSheenRoughness; ++r) {
        const Sheen sheen = make_sheen(at(r, kSheenRoughness), kSheenMu);
        std::vector<double> albedos;
        for (uint32_t m = 0; m < kSheenMu; ++m) {
            words.push_back(pack(sheen.albedo.points[m], sheen.cap.points[m]));
            albedos.push_back(low_of(words.back()));
        }
        averages.push_back(float_word(cosine_average(albedos)));
        averages.push_back(float_word(0));
    }
    words.insert(words.end(), averages.begin(), averages.end());
    std::vector<Curve> coats, sheens;
    for (uint32_t r = 0; r < kLayerRoughness; ++r) {
        coats.push_back(ggx.coat(at(r, kLayerRoughness)));
        sheens.push_back(make_sheen(at(r, kLayerRoughness), kSheenMu).albedo);
    }
    add_over_ggx(coats, words);
    add_over_ggx(sheens, words);
    add_over_loss(ggx, coats, words);
    add_over_loss(ggx, sheens, words);
    add_coat_over_sheen(coats, words);
    return words;
}

}  // namespace tables
