// Deformed meshes: morph targets and skins put the vertices of a mesh at rest elsewhere (glTF 2.0, 3.7.2.2 and 3.7.3.3).
#ifndef PARHELION_SHARED_DEFORM_H
#define PARHELION_SHARED_DEFORM_H
#include "shared/chunks.h"
#include "shared/types.h"
SHARED_BEGIN

// One joint of a vertex.
struct JointInfluence {
    uint joint;
    float weight;
};

// What one morph target adds to each vertex at weight 1: addresses of vec3[], 0 where it adds nothing.
struct ActiveTarget {
    uint64_t positions, normals, tangents;
    float weight;
};

// One geometry of one deformed mesh.
struct DeformJob {
    uint64_t rest_positions, rest_attributes;  // vec3[], VertexAttributes[]
    uint64_t positions, attributes;            // the same, to be made
    uint64_t influences;                       // JointInfluence[], influence_count a vertex
    uint vertex_count, influence_count;        // no influences: morphed only
    uint joint;                                // its first row of the palette
    uint target, target_count;                 // its rows of targets
};

SHARED_END
#endif
