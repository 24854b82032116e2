// Our own acceleration structure: a bottom level per mesh, a top level over instances, the same 4-wide nodes in both.
// Four-wide float boxes are the fastest layout on the CPU device and close to the best on a GPU without ray tracing hardware.
#ifndef PARHELION_SHARED_BVH_H
#define PARHELION_SHARED_BVH_H
#include "shared/scene.h"
SHARED_BEGIN

// BvhNode::child: kBvhEmpty, an inner node's index, or a leaf: kBvhLeaf | (count - 1) << kBvhCountShift | first item.
SHARED_CONST uint kBvhEmpty = 0xFFFFFFFFu;
SHARED_CONST uint kBvhLeaf = 0x80000000u;
SHARED_CONST uint kBvhCountShift = 29u;
SHARED_CONST uint kBvhFirstMask = 0x1FFFFFFFu;
SHARED_CONST uint kBvhMaxLeaf = 4u;

// The builder keeps every tree within this many levels of 4-wide nodes; a traversal pushes at most three nodes a level. A ray is
// in one top and one bottom level at once.
SHARED_CONST uint kBvhMaxDepth = 20u;
SHARED_CONST uint kBvhStackSize = 2u * 3u * kBvhMaxDepth + 2u;

struct BvhNode {
    vec4 min_x, min_y, min_z, max_x, max_y, max_z;  // of the four children; empty children have min > max
    uvec4 child;
};

// Object-space corners beside the ids: a leaf is read in one go.
struct BvhTriangle {
    vec3 p0;
    uint geometry;   // of the mesh
    vec3 p1;
    uint primitive;  // of the geometry
    vec3 p2;
    uint pad;
};

// A leaf of the top level. Holds its own transform, so that the previous frame's top level stays traceable.
struct BvhTopItem {
    Affine object_from_world;
    uint instance;
    uint root;  // of the bottom level, in the node array
};

SHARED_END
#endif
