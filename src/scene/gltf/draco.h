#pragma once
// Primitives under KHR_draco_mesh_compression.
#include <vector>

#include "scene/gltf/document.h"

namespace parhelion {

struct DracoGeometry {
    std::vector<glm::uvec3> triangles;         // every index is below the count of the primitive's POSITION accessor
    GltfDocument::DecodedAccessors accessors;  // of those attributes that are in the compressed data
};

// Decodes the data of a primitive. Its accessors say how many elements of which type there are; memory is counted against the
// scene's budget before Draco asks for it. Throws Error for damaged data, and for data with more vertices, faces or attributes
// than the accessors and the budget leave room for.
DracoGeometry decode_draco(GltfDocument& document, const JsonRef& primitive, const JsonRef& extension);

}  // namespace parhelion
