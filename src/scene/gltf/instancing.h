#pragma once
// Nodes under EXT_mesh_gpu_instancing.
#include <vector>

#include "scene/gltf/document.h"

namespace parhelion {

// Where the node's mesh stands, once an instance: node_from_object, from the extension's TRANSLATION, ROTATION and SCALE. Attributes
// of other names (`_ID`, ...) are for the application that wrote them and are not read.
std::vector<glm::mat4> read_instance_places(GltfDocument& document, const JsonRef& extension);

}  // namespace parhelion
