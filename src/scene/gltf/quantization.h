#pragma once
// How a vertex attribute may be stored: glTF 2.0, 3.6.2.4 and 3.7.2.1, and more under KHR_mesh_quantization.
#include "scene/gltf/document.h"

namespace parhelion {

// Every type of 8 or 16 bits or float can be read, at any place; the user learns of what other programs may refuse. `use` names the
// accessor of the attribute (a literal: "POSITION").
void warn_of_layout(GltfDocument& document, const JsonRef& use, std::string_view attribute);

}  // namespace parhelion
