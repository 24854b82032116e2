#include "scene/gltf/extensions.h"

#include <algorithm>
#include <iterator>

namespace parhelion {

namespace {

struct Row {
    std::string_view name;
    ExtensionUse use;
};

// In the order of their names, one a line.
constexpr Row kExtensions[] = {
    {"EXT_mesh_gpu_instancing", ExtensionUse::Read},
    {"EXT_meshopt_compression", ExtensionUse::Read},
    {"EXT_texture_webp", ExtensionUse::Read},
    {"KHR_animation_pointer", ExtensionUse::Read},
    {"KHR_draco_mesh_compression", ExtensionUse::Read},
    {"KHR_lights_punctual", ExtensionUse::Read},
    {"KHR_materials_anisotropy", ExtensionUse::Read},
    {"KHR_materials_clearcoat", ExtensionUse::Read},
    {"KHR_materials_dispersion", ExtensionUse::Read},
    {"KHR_materials_emissive_strength", ExtensionUse::Read},
    {"KHR_materials_ior", ExtensionUse::Read},
    {"KHR_materials_iridescence", ExtensionUse::Read},
    {"KHR_materials_pbrSpecularGlossiness", ExtensionUse::Read},
    {"KHR_materials_sheen", ExtensionUse::Read},
    {"KHR_materials_specular", ExtensionUse::Read},
    {"KHR_materials_transmission", ExtensionUse::Read},
    {"KHR_materials_unlit", ExtensionUse::Read},
    {"KHR_materials_variants", ExtensionUse::Read},
    {"KHR_materials_volume", ExtensionUse::Read},
    {"KHR_mesh_quantization", ExtensionUse::Read},
    {"KHR_meshopt_compression", ExtensionUse::Read},
    {"KHR_node_visibility", ExtensionUse::Read},
    {"KHR_texture_basisu", ExtensionUse::Read},  // as far as image_of_texture() says
    {"KHR_texture_transform", ExtensionUse::Read},
    {"KHR_xmp", ExtensionUse::Harmless},
    {"KHR_xmp_json_ld", ExtensionUse::Harmless},
};

}  // namespace

ExtensionUse extension_use(std::string_view name) {
    const auto* found = std::ranges::find(kExtensions, name, &Row::name);
    return found == std::end(kExtensions) ? ExtensionUse::Unknown : found->use;
}

}  // namespace parhelion
