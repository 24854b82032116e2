#pragma once
// Fewer triangles in the place of many: what rays meet where a scene is traced by proxies (scene_gpu/proxies.cpp).
#include <vector>

#include "scene/types.h"

namespace parhelion {

struct SimplifyLimits {
    float ratio = 1.0f;      // share of the triangles that is to stay, in (0, 1)
    float deviation = 0.0f;  // of the simplified surface from the whole one at most, in units of the object, by error quadrics
};

// Triangles over the vertices of the primitive that they were made from.
struct SimplifiedTriangles {
    std::vector<glm::uvec3> triangles;
    float deviation = 0.0f;  // by error quadrics: the root mean square where it is largest. Single points may be some times as far off
};

// Edges are collapsed, cheapest first, until one of the limits is reached. Open borders stay as they are, so that no gap comes to be between
// primitives that touch; seams of UVs and normals are kept together. Empty if fewer than a fifth of the triangles would go. The result
// depends on the input alone.
SimplifiedTriangles simplify_triangles(const Primitive& primitive, const SimplifyLimits& limits);

}  // namespace parhelion
