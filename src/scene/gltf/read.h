#pragma once
// glTF 2.0 (.gltf and .glb) to a SceneEdit.
#include <cstddef>
#include <span>
#include <string>

#include "scene/edit.h"
#include "scene/scene_files.h"

namespace parhelion {

struct GltfOptions {
    bool median_order = true;   // order each mesh's triangles (median_order.h)
    bool keep_encoded = false;  // images keep the files that they were decoded from (Image::encoded)
    std::string variant;        // name of the material variant to show; empty: none
};

// What a file becomes: apply the edit to an empty scene, or to one that it joins. The edit sets the scene's source too, whose
// warnings say what was left out.
// Read: the file's default scene (else its first, else all root nodes) with what it needs: node hierarchy, triangle meshes of
// all modes (also under Draco, meshopt, quantisation and instancing) with skins and morph targets, materials with their
// extensions, textures (PNG, JPEG, WebP, KTX2), cameras, punctual lights, animations. Throws Error that names file and place.
SceneEdit read_gltf(SceneFiles& files, std::span<const std::byte> file, const std::string& name, const GltfOptions& options = {});

}  // namespace parhelion
