#pragma once
// Order of triangles within a mesh.
#include "scene/types.h"

namespace parhelion {

// Puts the triangles into the order of a recursive object-median split: the list's first half lies on one side of the median
// centroid along the longest axis of the centroids' box, and so on in each half. Builders that halve lists by index (Mesa
// lavapipe's) get a good tree from that, others lose nothing, and triangles that are near in space are near in memory.
// The set of triangles and each one's corner order stay the same. Deterministic.
void order_triangles_by_median(Primitive& primitive);

}  // namespace parhelion
