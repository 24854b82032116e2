#pragma once
// Two scenes, field by field and bit by bit.
#include <string>

#include "scene/scene.h"

namespace parhelion::testing {

// The first place where `b` is not `a` as glTF can hold it, "" if there is none. Nodes are paired from the roots down and everything else by
// what uses it, so numbers of handles may differ. `b` may carry on nameless nodes of their own what shares a node, has a transform of its own or
// stands on no node in `a` (write_gltf does that); names that a reader takes from nodes or files count as none.
std::string scene_difference(const Scene& a, const Scene& b);

}  // namespace parhelion::testing
