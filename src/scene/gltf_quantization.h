#pragma once
// Which component types an attribute may have: glTF 2.0, 3.7.2.1, and more under KHR_mesh_quantization.
#include "scene/gltf_document.h"

namespace parhelion {

// Every type of 8 or 16 bits or float can be read; the user learns of those that other programs may refuse. `use` names the accessor
// of the attribute (a literal: "POSITION").
void warn_of_component_type(GltfDocument& document, const JsonRef& use, std::string_view attribute);

}  // namespace parhelion
