#include "sampling/sobol.h"

namespace parhelion::sampling {

const std::vector<uint32_t>& sobol_table() {
    static const std::vector<uint32_t> table = [] {
        std::vector<uint32_t> words;
        for (const SobolDimension& dimension : kSobolData) {
            const SobolDirections v = expand_directions(dimension);
            words.insert(words.end(), v.begin(), v.end());
        }
        return words;
    }();
    return table;
}

}  // namespace parhelion::sampling
