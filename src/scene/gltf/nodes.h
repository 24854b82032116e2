#pragma once
// The node hierarchy of a glTF file as a checked forest, and the things that nodes carry.
#include <vector>

#include "scene/gltf/document.h"
#include "scene/types.h"

namespace parhelion {

struct GltfNode {
    uint32_t index;   // in the file
    uint32_t parent;  // in this list; kNoParent for roots
    static constexpr uint32_t kNoParent = 0xFFFFFFFFu;
    bool drawn = true;  // false: in the scene for its place alone
};

// Where a light's `extras` have its angular radius (Light::angular_radius, radians), for which KHR_lights_punctual has no word.
constexpr std::string_view kAngularRadiusKey = "parhelion_angularRadius";

// The nodes of the file's default scene, parents before children. Throws Error for cycles, nodes with two parents and scenes that
// name a node which is not a root.
std::vector<GltfNode> collect_nodes(GltfDocument& document);

// Adds the nodes that the skins of these need as joints and that are not among them (another scene has them), with their parents:
// not drawn.
void add_joint_nodes(GltfDocument& document, std::vector<GltfNode>& nodes);

Transform read_transform(GltfDocument& document, const JsonRef& node);
Camera read_camera(GltfDocument& document, const JsonRef& json);
Light read_light(GltfDocument& document, const JsonRef& json);

}  // namespace parhelion
