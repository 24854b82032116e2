// Section bsdf_ggx.bin.
#include <algorithm>

#include "shared/bsdf_tables.h"
#include "tables.h"

namespace tables {

using namespace parhelion::shared;

// From cos_o = 0 nothing can be sampled: the limit is taken close to it.
Words make_ggx() {
    constexpr int kSide = 320;
    Words words, averages;
    for (uint32_t r = 0; r < kGgxRoughness; ++r) {
        std::vector<double> losses, grazings;
        for (uint32_t m = 0; m < kGgxMu; ++m) {
            double all = 0, grazing = 0;
            ggx_lobe(std::max(mu_at(m, kGgxMu), 1e-7), square(at(r, kGgxRoughness)), kSide, [&](double, double cos_h, double weight) {
                all += weight;
                grazing += weight * schlick(cos_h);
            });
            words.push_back(pack(1 - all, grazing));
            losses.push_back(low_of(words.back()));
            grazings.push_back(high_of(words.back()));
        }
        // Of the table as it is read, so that what is lost and what is given back agree to the last digit.
        averages.push_back(float_word(cosine_average(losses)));
        averages.push_back(float_word(cosine_average(grazings)));
    }
    words.insert(words.end(), averages.begin(), averages.end());
    return words;
}

}  // namespace tables
