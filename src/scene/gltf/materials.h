#pragma once
// Materials, textures, samplers and images of a glTF file, added to an edit.
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "scene/edit.h"
#include "scene/gltf/document.h"

namespace parhelion {

// Where a material's `extras` have its Material::nested_priority, for which KHR_materials_volume has no word.
constexpr const char* kNestedPriorityKey = "nested_priority";

// Adds the materials with these numbers, and the textures and images that they use (decoded in parallel), to the edit.
// Returns their handles; with `needs_default`, a default material (glTF 2.0, 3.9) is added under the key std::nullopt. With
// `keep_encoded`, images keep their files.
using MaterialHandles = std::map<std::optional<uint32_t>, Handle<Material>>;
MaterialHandles add_materials(GltfDocument& document, SceneEdit& edit, const std::set<uint32_t>& materials, bool needs_default,
                             bool keep_encoded = false);

// True if the material or its clear coat has a normal map that is drawn: its meshes need tangents. The UV set goes to `uv_set`.
bool has_normal_map(const GltfDocument& document, std::optional<uint32_t> material, uint32_t& uv_set);

}  // namespace parhelion
