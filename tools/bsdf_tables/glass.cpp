// Section bsdf_glass.bin.
#include <algorithm>

#include "glass.h"
#include "shared/bsdf_tables.h"
#include "tables.h"

namespace tables {

using namespace parhelion::shared;

namespace {

struct Losses {
    double full = 0, none = 0;
};

// What rough glass scatters more than once, seen from cos_o.
Losses glass_losses(double cos_o, double alpha, double eta) {
    Losses out;
    if (alpha == 0) return out;
    out = {1, 1};
    glass_lobe(cos_o, alpha, eta, [&](bool, double, double full, double none) { out.full -= full, out.none -= none; });
    return out;
}

}  // namespace

Words make_glass() {
    Words words, averages;
    for (const bool leaving : {false, true})
        for (uint32_t e = 0; e < kGlassIndices; ++e)
            for (uint32_t r = 0; r < kGlassRoughness; ++r) {
                const double index = glass_index_at(e, kGlassIndices), alpha = std::pow(at(r, kGlassRoughness), 4);
                std::vector<double> full, none;
                for (uint32_t m = 0; m < kGlassMu; ++m) {
                    const Losses losses = glass_losses(std::max(std::pow(at(m, kGlassMu), 4), 1e-9), alpha, leaving ? 1 / index : index);
                    words.push_back(pack(losses.full, losses.none));
                    full.push_back(low_of(words.back()));
                    none.push_back(high_of(words.back()));
                }
                averages.push_back(float_word(cosine_average_fourth_root(full)));
                averages.push_back(float_word(cosine_average_fourth_root(none)));
            }
    words.insert(words.end(), averages.begin(), averages.end());
    return words;
}

}  // namespace tables
