#pragma once
// The animations of a glTF file.
#include <map>
#include <vector>

#include "scene/edit.h"
#include "scene/gltf/document.h"

namespace parhelion {

// A node that channels may move.
struct AnimatedNode {
    Handle<Node> node;
    uint32_t target_count = 0;  // of its mesh
};

// What the scene has, by numbers in the file. Every node that names a light or camera has one of its own.
struct AnimatedObjects {
    std::map<uint32_t, AnimatedNode> nodes;
    std::map<uint32_t, std::vector<Handle<Light>>> lights;
    std::map<uint32_t, std::vector<Handle<Camera>>> cameras;
};

// All animations, in the order of the file, so that numbers stay what they are. Channels of what is not among `objects`, of no node, and
// of what stands still here (animation_pointer.h) are left out. Throws Error for keys that are out of
// order, negative times, channels of one animation that move the same, and numbers that do not fit.
void add_animations(GltfDocument& document, SceneEdit& edit, const AnimatedObjects& objects);

}  // namespace parhelion
