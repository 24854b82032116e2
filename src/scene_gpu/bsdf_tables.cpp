#include "scene_gpu/bsdf_tables.h"

#include <cstddef>
#include <span>

#include "shared/bsdf_tables.h"

namespace parhelion {

// Embedded by CMakeLists.txt; written by tools/bsdf_tables.
namespace embedded {
extern const unsigned char bsdf_ggx[], bsdf_layers[], bsdf_glass[], bsdf_coated_glass[];
extern const size_t bsdf_ggx_size, bsdf_layers_size, bsdf_glass_size, bsdf_coated_glass_size;
}  // namespace embedded

std::vector<uint32_t> bsdf_table_words() {
    std::vector<uint32_t> words;
    words.reserve(shared::kBsdfTableWords);
    for (const auto section : {std::span(embedded::bsdf_ggx, embedded::bsdf_ggx_size), std::span(embedded::bsdf_layers, embedded::bsdf_layers_size),
                               std::span(embedded::bsdf_glass, embedded::bsdf_glass_size), std::span(embedded::bsdf_coated_glass, embedded::bsdf_coated_glass_size)})
        for (size_t i = 0; i + 4 <= section.size(); i += 4)
            words.push_back(uint32_t(section[i]) | uint32_t(section[i + 1]) << 8 | uint32_t(section[i + 2]) << 16 | uint32_t(section[i + 3]) << 24);
    return words;
}

}  // namespace parhelion
