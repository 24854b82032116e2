#pragma once
// Morph targets and skins (glTF 2.0, 3.7.2.2 and 3.7.3.3) on the host: the oracle of what the device does (scene_gpu/deform.comp), and for
// those who need a deformed shape here.
#include "scene/scene.h"

namespace parhelion {

// Some joint turns the mesh inside out: front faces then wind the other way, which no MeshDeformation of a scene may do.
bool any_mirrors(const MeshDeformation& deformation);

// The primitive without targets and joints, deformed in its own object space; a primitive without joints is morphed only. Computed in
// double. Where joints mirror, triangles turn over whose corners mostly do, so that front faces stay front faces. All joints must exist.
Primitive deformed(const Primitive& rest, const MeshDeformation& deformation);
// A form of the mesh `handle` whose arrays are made here.
Mesh deformed(const Mesh& rest, Handle<Mesh> handle, const MeshDeformation& deformation);

// A box that holds the deformed primitive, as large as its joints' boxes at rest make it. Needs what Scene keeps of primitives.
Bounds deformed_bounds(const Primitive& rest, const MeshDeformation& deformation);

// The arrays of a mesh's primitive as it is drawn: its own, or, of a form with a deformation, made into `storage`.
const Primitive& drawn_shape(const Scene& scene, const Mesh& mesh, size_t primitive, Primitive& storage);

namespace detail {
// Fills in what Scene keeps of a primitive with arrays, for deformed_bounds() and all others.
void keep_bounds(Primitive& primitive);
}  // namespace detail

}  // namespace parhelion
