#pragma once
// Images of a glTF file: found by URI or buffer view, decoded in parallel within the memory budget.
#include <map>
#include <optional>
#include <set>
#include <string>

#include "scene/edit.h"
#include "scene/gltf/document.h"

namespace parhelion {

// Decodes the images with these numbers and adds them to the edit; the format is found by content, a mimeType that says something
// else is a warning. `keep_encoded`: fills Image::encoded. Throws Error for an image that cannot be decoded.
std::map<uint32_t, Handle<Image>> add_images(GltfDocument& document, SceneEdit& edit, const std::set<uint32_t>& images, bool keep_encoded = false);

// What in a KTX2 image is not read, in words ("Basis Universal texels"); none for images that are, and for those of other formats.
std::optional<std::string> obstacle_of_image(GltfDocument& document, uint32_t index);

// The image that a texture shows: of KHR_texture_basisu or EXT_texture_webp, else its plain source. Where the KTX2 of the former
// cannot be read, the plain source stands in, with a warning; without one the texture is left out with a warning (none is returned),
// or is an Error if the file requires the extension.
std::optional<uint32_t> image_of_texture(GltfDocument& document, const JsonRef& texture);

}  // namespace parhelion
