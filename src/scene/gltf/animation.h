#pragma once
// The animations of a glTF file.
#include <map>

#include "scene/edit.h"
#include "scene/gltf/document.h"

namespace parhelion {

// A node that channels may move.
struct AnimatedNode {
    Handle<Node> node;
    uint32_t target_count = 0;  // of its mesh
};

// All animations, in the order of the file, so that numbers stay what they are; `nodes` by their numbers in the file. Channels of
// nodes that are not among them, of no node, and of KHR_animation_pointer are left out. Throws Error for keys that are out of
// order, negative times, channels of one animation that move the same, and numbers that do not fit.
void add_animations(GltfDocument& document, SceneEdit& edit, const std::map<uint32_t, AnimatedNode>& nodes);

}  // namespace parhelion
