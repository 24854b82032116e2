#pragma once
// Meshes of a glTF file: triangles of every mode, attributes, missing normals and tangents.
#include "scene/gltf/document.h"
#include "scene/gltf/materials.h"

namespace parhelion {

// The material numbers that a mesh uses, in any of the file's variants; std::nullopt stands for the default material.
std::set<std::optional<uint32_t>> materials_of(const JsonRef& mesh);

struct MeshOptions {
    bool median_order = true;         // see median_order.h
    size_t variant_count = 0;         // of the file (KHR_materials_variants)
    std::optional<uint32_t> variant;  // the one whose materials count; none: the primitives' own
};

// Primitives without triangles or positions are left out, with a warning.
Mesh read_mesh(GltfDocument& document, const JsonRef& json, const MaterialHandles& materials, const MeshOptions& options);

}  // namespace parhelion
