#pragma once
// Tangents where a normal map needs them and the file has none.
#include "scene/types.h"

namespace parhelion {

// Gives every triangle three vertices of its own and flat normals (glTF 2.0, 3.7.2.1: what a mesh without normals looks like).
void unshare_with_flat_normals(Primitive& primitive);

// Fills `tangents` from positions, normals and the given UV set: per corner, weighted by angle, projected to the vertex's tangent
// plane and summed over corners of equal position, normal, UV and handedness, as Mikkelsen 2008 ("Simulation of wrinkled surfaces
// revisited", MikkTSpace) does; a vertex whose triangles disagree in handedness is split. The tangent points along +u, the
// bitangent cross(n, t) * w along -v (up in the image). Where UVs are degenerate the tangent is zero: no normal mapping there.
void generate_tangents(Primitive& primitive, uint32_t uv_set);

}  // namespace parhelion
