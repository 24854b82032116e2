#include "scene/gltf/variants.h"

#include <algorithm>

#include "base/error.h"
#include "scene/types.h"

namespace parhelion {

std::vector<std::string> variant_names(const GltfDocument& document) {
    std::vector<std::string> names;
    const std::optional<JsonRef> extension = document.root().extension("KHR_materials_variants");
    if (!extension) return names;
    const JsonRef variants = extension->at("variants");
    for (size_t i = 0; i < variants.size(); ++i) names.emplace_back(variants[i].at("name").as_string());
    return names;
}

std::optional<uint32_t> find_variant(const std::vector<std::string>& names, std::string_view name, std::string_view scene) {
    if (name.empty()) return std::nullopt;
    const auto found = std::ranges::find(names, name);
    if (found != names.end()) return static_cast<uint32_t>(found - names.begin());
    constexpr size_t kMostListed = 50;
    std::string list;
    for (size_t i = 0; i < std::min(names.size(), kMostListed); ++i) list += (list.empty() ? "" : ", ") + escape_name(names[i], 60);
    if (names.size() > kMostListed) list += fmt::format(" and {} more", names.size() - kMostListed);
    throw Error(ErrorCode::Usage, fmt::format("{} has no material variant '{}'", scene, escape_name(name)), "--variant",
                names.empty() ? "it has none at all: leave the option out" : "it has: " + list);
}

std::vector<uint32_t> mapped_materials(const JsonRef& primitive) {
    std::vector<uint32_t> out;
    const std::optional<JsonRef> extension = primitive.extension("KHR_materials_variants");
    if (!extension) return out;
    const JsonRef mappings = extension->at("mappings");
    for (size_t i = 0; i < mappings.size(); ++i) out.push_back(mappings[i].at("material").as_index_of("materials"));
    return out;
}

std::vector<std::optional<uint32_t>> materials_by_variant(GltfDocument& document, const JsonRef& primitive, size_t variant_count) {
    std::vector<std::optional<uint32_t>> out;
    const std::vector<uint32_t> materials = mapped_materials(primitive);
    if (materials.empty()) return out;
    document.files().charge(uint64_t(variant_count) * (sizeof(Handle<Material>) + sizeof(std::optional<uint32_t>)), primitive.where());
    out.resize(variant_count);
    const JsonRef mappings = primitive.extension("KHR_materials_variants")->at("mappings");
    for (size_t i = 0; i < materials.size(); ++i) {
        const JsonRef variants = mappings[i].at("variants");
        for (size_t k = 0; k < variants.size(); ++k) {
            const uint64_t variant = variants[k].as_uint(0xFFFFFFFFull);
            if (variant >= variant_count) variants[k].fail(fmt::format("names variant {}, but the file has {}", variant, variant_count));
            if (out[variant])
                document.warn(variants[k], fmt::format("maps variant {} again; the first material counts", variant));
            else
                out[variant] = materials[i];
        }
    }
    return out;
}

}  // namespace parhelion
