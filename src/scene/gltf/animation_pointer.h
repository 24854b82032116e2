#pragma once
// What KHR_animation_pointer points to, as far as an animation can move it here.
#include <optional>

#include "scene/gltf/document.h"
#include "scene/types.h"

namespace parhelion {

struct AnimatedProperty {
    AnimatedPath path;
    uint32_t object;  // number in the file of the node, light or camera that it is of
};

// `target`: that of a channel whose path is "pointer". Nothing: it points to something that stands still here. Throws Error where it does not
// point to anything of the file.
std::optional<AnimatedProperty> read_animation_pointer(GltfDocument& document, const JsonRef& target);

}  // namespace parhelion
