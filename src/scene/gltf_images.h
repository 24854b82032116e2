#pragma once
// Images of a glTF file: found by URI or buffer view, decoded in parallel within the memory budget.
#include <map>
#include <set>

#include "scene/edit.h"
#include "scene/gltf_document.h"

namespace parhelion {

// Decodes the images with these numbers and adds them to the edit. Throws Error for one that cannot be decoded.
std::map<uint32_t, Handle<Image>> add_images(GltfDocument& document, SceneEdit& edit, const std::set<uint32_t>& images);

}  // namespace parhelion
