#pragma once
// What deforms meshes: skins, joints and weights of vertices, morph targets (glTF 2.0, 3.7.2.2 and 3.7.3).
#include <map>

#include "scene/gltf/document.h"
#include "scene/types.h"

namespace parhelion {

// JOINTS_n and WEIGHTS_n of all sets; weights come to sum 1. `out` has its positions.
void read_influences(GltfDocument& document, const JsonRef& attributes, Primitive& out);

// The morph targets of a primitive whose attributes are read: deltas of those that it has.
void read_targets(GltfDocument& document, const JsonRef& primitive, Primitive& out);

// Bytes that targets, joints and weights take for each vertex.
uint64_t deformation_bytes(const Primitive& primitive);
inline bool deforms(const Primitive& primitive) { return primitive.influence_count != 0 || !primitive.targets.empty(); }

// Default weights and names of a mesh's targets; its primitives are read and must have as many targets each.
void read_target_list(GltfDocument& document, const JsonRef& json, Mesh& mesh);

// `weights` of a node or a mesh with that many morph targets; empty if it has none.
std::vector<float> read_weights(GltfDocument& document, const JsonRef& owner, size_t target_count);

// How many joints a skin must have for this mesh; 0: none of its primitives is skinned.
uint32_t joints_needed(const Mesh& mesh);

// The nodes of a skin's joints, by their numbers in the file.
std::vector<uint32_t> joints_of(const JsonRef& skin);

// `nodes`: by their numbers in the file; all joints are among them.
Skin read_skin(GltfDocument& document, const JsonRef& json, const std::map<uint32_t, Handle<Node>>& nodes);

}  // namespace parhelion
