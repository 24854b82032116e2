#version 460
// Test shader: traces rays through our own BVH, closest and any hit. Reads: levels, rays. Writes: hits.
#extension GL_GOOGLE_include_directive : require
#include "lib/traverse.glsl"

layout(constant_id = 0) const uint kBvhVariant = kBvhFour;
layout(local_size_x = 8, local_size_y = 4) in;
layout(buffer_reference, scalar) readonly buffer Rays { TraversalRay v[]; };
layout(buffer_reference, scalar) writeonly buffer Hits { TraversalHit v[]; };
layout(push_constant, scalar) uniform Push {
    BvhAddresses bvh;
    Rays rays;
    Hits hits;  // t < 0: nothing
    uint width;
    uint any;   // 1: any hit, of which only the sign of t is written
};

// Refuses every third candidate of a ray whose key is 1.
bool accept_hit(uint alpha_key, uint instance, uint geometry_of_mesh, uint primitive, vec2 barycentrics, bool front_facing) {
    return alpha_key == 0u || (instance + geometry_of_mesh + primitive + uint(front_facing)) % 3u != 0u;
}

void main() {
    const uint i = gl_GlobalInvocationID.y * width + gl_GlobalInvocationID.x;
    const TraversalRay ray = rays.v[i];
    TraversalHit hit;
    if (any != 0u ? !traverse_any(bvh, kBvhVariant, ray) : !traverse_closest(bvh, kBvhVariant, ray, hit)) hit = TraversalHit(0u, 0u, 0u, vec2(0.0), -1.0);
    else if (any != 0u) hit = TraversalHit(0u, 0u, 0u, vec2(0.0), 1.0);
    hits.v[i] = hit;
}
