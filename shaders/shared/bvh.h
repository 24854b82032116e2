// Our own acceleration structure: a bottom level per mesh, a top level over instances, nodes of the same layout in both.
#ifndef PARHELION_SHARED_BVH_H
#define PARHELION_SHARED_BVH_H
#include "shared/types.h"
SHARED_BEGIN

// A child of a node: kBvhEmpty; or an inner node's index in its node array; or kBvhLeaf | first item, where an item is a
// BvhTriangle in a bottom level and a BvhTopItem in the top level.
SHARED_CONST uint kBvhEmpty = 0xFFFFFFFFu;
SHARED_CONST uint kBvhLeaf = 0x80000000u;
SHARED_CONST uint kBvhItemMask = 0x7FFFFFFFu;
SHARED_CONST uint kBvhMaxLeaf = 4u;  // triangles in a leaf; a leaf of the top level holds one instance

// The layouts of nodes. A device traces one of them; which, is constant 0 of its tracing programs, together with the loop.
SHARED_CONST uint kBvhBinary = 0u;   // BvhNodeBinary
SHARED_CONST uint kBvhFour = 1u;     // BvhNode
SHARED_CONST uint kBvhCompact = 2u;  // BvhNodeCompact
SHARED_CONST uint kBvhLayoutMask = 3u;
SHARED_CONST uint kBvhRounds = 4u;   // the loop: see lib/traverse.glsl

// The builder keeps every tree within this many levels of two-wide nodes, or half as many of four-wide ones. A traversal that goes
// down one level leaves at most one sibling on its stack, or three, and it is in one top and one bottom level at once: a stack of
// this size, with one entry for its end and one for the way back to the top level, cannot overflow.
SHARED_CONST uint kBvhTopLevels = 24u;
SHARED_CONST uint kBvhBottomLevels = 36u;
SHARED_CONST uint kBvhStackSize = 3u * (kBvhTopLevels + kBvhBottomLevels) / 2u + 2u;

// Four children, float boxes. Also what nodes of the other layouts are made from and read into (lib/bvh_nodes.glsl).
struct BvhNode {
    vec4 min_x, max_x, min_y, max_y, min_z, max_z;  // of the four children; empty ones have min > max
    uvec4 child;
};

// Two children, float boxes; 64 bytes.
struct BvhNodeBinary {
    vec4 x, y, z;  // minima of both children, maxima of both
    uvec2 child;
    uvec2 pad;
};

// Four children whose boxes have 8 bits a plane; 64 bytes. A plane lies at origin + n scale, rounded once: n scale is exact.
struct BvhNodeCompact {
    vec3 origin;
    uint min_x;  // n of the four children, the first in the lowest byte
    vec3 scale;  // of at most 16 significant bits
    uint max_x;
    uint min_y, max_y, min_z, max_z;
    uvec4 child;
};

// 48 bytes. What every ray needs comes first; the ids are looked at where one hits.
struct BvhTriangle {
    vec3 p0, p1, p2;  // object space
    uint rest;        // triangles of the same leaf that follow; 0 ends the leaf
    uint geometry;    // of the mesh
    uint primitive;   // of the geometry
};

// An instance in the top level. Has its own transform, so that the previous frame's top level stays traceable:
// p_object = (dot(row0, q), dot(row1, q), dot(row2, q)) with q = p_ws - origin_ws, which loses less far from the world's origin
// than a product with a 3x4 matrix does.
struct BvhTopItem {
    vec3 row0;
    uint instance;
    vec3 row1;
    uint root;      // of its bottom level, in the node array
    vec3 row2;
    uint mask;      // rays whose mask shares no bit pass by
    vec3 origin_ws; // where the object's origin lies
    uint pad;       // 64 bytes, four aligned loads
};

// Where the levels lie on the device.
struct BvhAddresses {
    uint64_t top_nodes, top_items;            // nodes of one layout, BvhTopItem[]
    uint64_t bottom_nodes, bottom_triangles;  // nodes of the same layout, BvhTriangle[]
};

struct TraversalRay {
    vec3 origin_ws;
    float t_min;
    vec3 direction_ws;  // of any length but zero: t counts in it
    float t_max;        // hits have t_min < t < t_max
    uint mask;          // sees the instances whose mask shares a bit
    uint alpha_key;     // for alpha tests (accept_hit)
};

struct TraversalHit {
    uint instance;
    uint geometry;      // of the mesh
    uint primitive;     // of the geometry
    vec2 barycentrics;  // weights of corners 1 and 2
    float t;
};

SHARED_END
#endif
