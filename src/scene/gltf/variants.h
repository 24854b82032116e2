#pragma once
// KHR_materials_variants: named sets of materials, of which each primitive says what it wears in which.
#include <string>
#include <vector>

#include "scene/gltf/document.h"

namespace parhelion {

// The names of all variants of the file.
std::vector<std::string> variant_names(const GltfDocument& document);

// The number of the variant `name`; none for "". Throws a usage Error that lists the names where it is not there.
std::optional<uint32_t> find_variant(const std::vector<std::string>& names, std::string_view name, std::string_view scene);

// The material numbers that a primitive has in any variant besides its own one.
std::vector<uint32_t> mapped_materials(const JsonRef& primitive);

// The primitive's material number by variant; empty where it has none in any besides its own one.
std::vector<std::optional<uint32_t>> materials_by_variant(GltfDocument& document, const JsonRef& primitive, size_t variant_count);

}  // namespace parhelion
