// Section bsdf_coated_glass.bin: means of the functions that the layers' albedo is interpolated with, over the lobes of rough glass.
#include <array>

#include "glass.h"

namespace tables {

using namespace parhelion::shared;

namespace {

using Basis = std::array<double, kTurnedBasis>;

// phi_k of x = sqrt(cosine): parabolas through three points of the axis each.
Basis basis(double cosine) {
    constexpr int kPieces = (kTurnedBasis - 1) / 2;
    const double x = std::sqrt(std::fmax(cosine, 0.0)) * kPieces;
    const int piece = std::min(static_cast<int>(x), kPieces - 1);
    const double t = 2 * (x - piece);  // 0, 1, 2 at the three points
    Basis out{};
    out[2 * piece] = (t - 1) * (t - 2) / 2;
    out[2 * piece + 1] = t * (2 - t);
    out[2 * piece + 2] = t * (t - 1) / 2;
    return out;
}

struct Pair {
    Basis full{}, none{};
};
Basis scaled(Basis b, double by) {
    for (double& v : b) v *= by;
    return b;
}
void add(Basis& to, const Basis& phi, double weight) {
    for (uint32_t k = 0; k < kTurnedBasis; ++k) to[k] += weight * phi[k];
}

struct Lobes {
    Pair crossing, reflected;
    double loss_full = 1, loss_none = 1;
};
Lobes lobes_from(double cos_o, double alpha, double eta) {
    Lobes out;
    glass_lobe(cos_o, alpha, eta, [&](bool crosses, double cosine, double full, double none) {
        Pair& pair = crosses ? out.crossing : out.reflected;
        const Basis phi = basis(cosine);
        add(pair.full, phi, full), add(pair.none, phi, none);
        out.loss_full -= full, out.loss_none -= none;
    });
    return out;
}

uint32_t pack_signed(double full, double none) { return pack((full + 0.2) / 1.2, (none + 0.2) / 1.2); }

// The critical angle's cosine; 0 where there is none.
double critical_cosine(double eta) { return std::sqrt(std::fmax(1 - eta * eta, 0.0)); }

// The cosine at a place on the axis, and the slope there.
std::pair<double, double> cosine_at(double x, double eta) {
    const double c = critical_cosine(eta), above = 2 * x - 1, turn = 2 * std::numbers::pi * x;
    if (c == 0) return {std::pow(x, 4), 4 * std::pow(x, 3)};
    return above > 0 ? std::pair(c + (1 - c) * square(above), 4 * (1 - c) * above) : std::pair(c * (1 - std::cos(turn)) / 2, std::numbers::pi * c * std::sin(turn));
}

// (cosine, weight) for int 2 cos f, f known with its kink at the critical angle.
std::vector<std::pair<double, double>> cosines(double eta) {
    std::vector<std::pair<double, double>> out;
    for (const double half : {0.0, 0.5})
        for (const auto& [x, w] : gauss(16)) {
            const auto [cosine, slope] = cosine_at(half + x / 2, eta);
            out.push_back({cosine, w / 2 * slope * 2 * cosine});
        }
    return out;
}

double turned_roughness(uint32_t r) { return std::max(std::pow(at(r, kTurnedRoughness), 2), 1e-2); }  // below there are no lobes, only mirrors

void add_bodies(Words& crossing, Words& reflected, Words& losses, bool leaving) {
    std::vector<Lobes> over_mu;
    std::vector<Pair> over_loss;
    for (uint32_t e = 0; e < kTurnedIndices; ++e)
        for (uint32_t r = 0; r < kTurnedRoughness; ++r) {
            const double index = glass_index_at(e, kTurnedIndices), eta = leaving ? 1 / index : index, alpha = square(turned_roughness(r));
            for (uint32_t m = 0; m < kTurnedMu; ++m) over_mu.push_back(lobes_from(std::clamp(cosine_at(at(m, kTurnedMu), eta).first, 1e-9, 1.0), alpha, eta));
            Pair loss;
            double loss_full = 0, loss_none = 0;
            for (const auto& [cosine, weight] : cosines(eta)) {
                const Lobes lobes = lobes_from(cosine, alpha, eta);
                const Basis phi = basis(cosine);
                add(loss.full, phi, weight * lobes.loss_full), add(loss.none, phi, weight * lobes.loss_none);
                loss_full += weight * lobes.loss_full, loss_none += weight * lobes.loss_none;
            }
            over_loss.push_back({scaled(loss.full, 1 / loss_full), scaled(loss.none, 1 / loss_none)});
        }
    for (uint32_t k = 0; k < kTurnedBasis; ++k) {
        for (const Lobes& l : over_mu) {
            crossing.push_back(pack_signed(l.crossing.full[k], l.crossing.none[k]));
            reflected.push_back(pack_signed(l.reflected.full[k], l.reflected.none[k]));
        }
        for (const Pair& p : over_loss) losses.push_back(pack_signed(p.full[k], p.none[k]));
    }
}

void add_walls(Words& words) {
    std::vector<Basis> over_mu, over_loss;
    for (uint32_t r = 0; r < kTurnedRoughness; ++r) {
        const double alpha = square(turned_roughness(r));
        const auto lobe = [&](double cos_o, double& loss) {
            Basis sum{};
            loss = 1;
            ggx_lobe(cos_o, alpha, 128, [&](double cos_i, double, double weight) { add(sum, basis(cos_i), weight), loss -= weight; });
            return sum;
        };
        double lost = 0;
        for (uint32_t m = 0; m < kTurnedMu; ++m) over_mu.push_back(lobe(std::max(std::pow(at(m, kTurnedMu), 4), 1e-9), lost));
        Basis loss{};
        double average = 0;
        for (const auto& [cosine, weight] : cosines(1)) {
            lobe(cosine, lost);
            add(loss, basis(cosine), weight * lost);
            average += weight * lost;
        }
        over_loss.push_back(scaled(loss, 1 / average));
    }
    for (uint32_t k = 0; k < kTurnedBasis; ++k)
        for (const Basis& b : over_mu) words.push_back(pack_signed(b[k], 0));
    for (uint32_t k = 0; k < kTurnedBasis; ++k)
        for (const Basis& b : over_loss) words.push_back(pack_signed(b[k], 0));
}

}  // namespace

Words make_coated_glass() {
    Words words, reflected, losses;
    for (const bool leaving : {false, true}) add_bodies(words, reflected, losses, leaving);
    for (const Words* part : {&reflected, &losses}) words.insert(words.end(), part->begin(), part->end());
    add_walls(words);
    return words;
}

}  // namespace tables
