#pragma once
// KHR_materials_*: what a material's extensions add to it.
#include "scene/gltf/fields.h"

namespace parhelion {

// `json`: the material; its core fields are in `material` already.
void read_material_extensions(const MaterialFields& fields, const JsonRef& json, Material& material);

}  // namespace parhelion
