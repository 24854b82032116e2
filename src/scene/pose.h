#pragma once
// Scenes at a moment of their animations: nodes moved, meshes morphed and skinned on the host.
#include <functional>
#include <string_view>

#include "scene/scene.h"

namespace parhelion {

// What brings the scene to `seconds` of its animations (`animation`: see choose_animations); what none of them moves stays as it
// is. The edit moves, shows and hides nodes, changes lights and cameras, sets morph weights, and gives every instance that a skin or a weight other than 0 deforms a posed mesh
// (Instance::posed) in its own object space, a form of its mesh (Mesh::rest) without targets and joints; morph targets act before the
// skin (glTF 2.0, 3.7.2.2).
// Instances without skin that share mesh and weights share the posed mesh. Posed meshes that this leaves without a user are removed.
// A skin puts vertices into the world whatever the transform of the instance (3.7.3.3); if that cannot be inverted, the instance
// cannot be seen, which is logged as a warning. Front faces stay front faces where joints mirror.
// `charge` is told the bytes of each posed mesh before it is made, and may throw. Throws Error where a node leaves the range of
// coordinates, or a mesh names a joint that its skin does not have.
SceneEdit pose_at(const Scene& scene, double seconds, std::string_view animation = {},
                  const std::function<void(uint64_t bytes)>& charge = {});

// A camera as it is at `seconds` of the animations, with its place, whatever the scene's own moment. Throws as pose_at does.
Camera camera_at(const Scene& scene, Handle<Camera> camera, double seconds, std::string_view animation = {});

}  // namespace parhelion
