// Refit of our own bottom levels: a deformed mesh gets the tree of its mesh at rest with boxes around its own triangles.
#ifndef PARHELION_SHARED_REFIT_H
#define PARHELION_SHARED_REFIT_H
#include "shared/chunks.h"
#include "shared/types.h"
SHARED_BEGIN

// The plan of a mesh at rest: its tree without boxes, whatever the layout of nodes. Node 0 is the root.
struct RefitNode {
    uvec4 child;  // as in shared/bvh.h, of the plan
    uint parent;  // kBvhEmpty: the root
};
// Triangles leaf by leaf, as in BvhTriangle.
struct RefitTriangle {
    uint geometry, primitive, rest;
};

// Where a geometry of a deformed mesh lies: addresses of vec3[] and uvec3[].
struct RefitPart {
    uint64_t positions, indices;
};

// One deformed mesh: the first rows of its plan, of what is made, of its parts, and of its scratch memory.
struct RefitJob {
    uint plan_node, plan_triangle;
    uint node_count, triangle_count;
    uint node, triangle;
    uint part, scratch;
};

// A geometry whose boxes are measured (scene_gpu/decay.comp): addresses of vec3[] and uvec3[].
struct DecayJob {
    uint64_t positions, indices;
    uint triangle_count;
};

SHARED_END
#endif
