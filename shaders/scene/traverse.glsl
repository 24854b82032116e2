// Traversal of our own two-level BVH: one loop, one stack, ordered by distance. No shared memory, no subgroup operations.
// The stack cannot overflow: the builder bounds both depths (shared/bvh.h).
#ifndef PARHELION_SCENE_TRAVERSE_GLSL
#define PARHELION_SCENE_TRAVERSE_GLSL
#include "lib/affine.glsl"
#include "lib/ray_triangle.glsl"
#include "scene/alpha.glsl"
#include "shared/bvh.h"

layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer BvhNodes { BvhNode v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer BvhTriangles { BvhTriangle v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer BvhTopItems { BvhTopItem v[]; };

struct TraversalHit {
    uint instance, geometry, primitive;
    vec2 barycentrics;
    float t;
};

// Distances at which the four children are entered; infinite for a miss. The far side is widened by two roundings (Ize 2013), so
// a box never loses a ray that its triangle would catch.
vec4 intersect_boxes(BvhNode node, vec3 origin, vec3 inv_direction, float t_min, float t_max) {
    const vec4 x0 = (node.min_x - origin.x) * inv_direction.x, x1 = (node.max_x - origin.x) * inv_direction.x;
    const vec4 y0 = (node.min_y - origin.y) * inv_direction.y, y1 = (node.max_y - origin.y) * inv_direction.y;
    const vec4 z0 = (node.min_z - origin.z) * inv_direction.z, z1 = (node.max_z - origin.z) * inv_direction.z;
    const vec4 near = max(max(min(x0, x1), min(y0, y1)), max(min(z0, z1), vec4(t_min)));
    const vec4 far = min(min(max(x0, x1), max(y0, y1)), min(max(z0, z1), vec4(t_max))) * 1.00000036;
    return mix(vec4(3.4e38), near, lessThanEqual(near, far));
}

// Direction components of zero would make 0 x infinity; a tiny one makes the same decisions.
vec3 safe_inverse(vec3 d) {
    const vec3 tiny = vec3(1e-30);
    return 1.0 / mix(d, tiny, lessThan(abs(d), tiny));
}

// Does the triangle count for this ray? Equal distances go to the smaller (instance, geometry, primitive), so that the answer
// does not depend on the order of traversal.
bool is_nearer(TraversalHit best, float t, uint instance, BvhTriangle triangle) {
    if (t != best.t) return t < best.t;
    if (instance != best.instance) return instance < best.instance;
    return triangle.geometry != best.geometry ? triangle.geometry < best.geometry : triangle.primitive < best.primitive;
}

// any: stops at the first hit. Returns whether there is one, in `best`.
bool traverse(uint64_t top_nodes, uint64_t top_items, vec3 origin_ws, vec3 direction_ws, float t_min, float t_max, uint alpha_key, bool any, inout TraversalHit best) {
    uint stack[kBvhStackSize];
    float stack_t[kBvhStackSize];
    uint height = 0u, bottom_height = 0u;
    uint instance = kNone;  // kNone: in the top level
    uint64_t nodes = top_nodes;
    vec3 origin = origin_ws, direction = direction_ws, inv_direction = safe_inverse(direction_ws);
    ShearedRay sheared;
    bool found = false;
    best = TraversalHit(kNone, kNone, kNone, vec2(0.0), t_max);
    uint current = 0u;
    while (true) {
        if ((current & kBvhLeaf) == 0u) {
            const BvhNode node = BvhNodes(nodes).v[current];
            vec4 near = intersect_boxes(node, origin, inv_direction, t_min, best.t);
            uvec4 child = node.child;
            near = mix(near, vec4(3.4e38), equal(child, uvec4(kBvhEmpty)));
            // Sorting network, farthest first, so that the nearest is on top of the stack.
            if (near.x < near.z) { near.xz = near.zx; child.xz = child.zx; }
            if (near.y < near.w) { near.yw = near.wy; child.yw = child.wy; }
            if (near.x < near.y) { near.xy = near.yx; child.xy = child.yx; }
            if (near.z < near.w) { near.zw = near.wz; child.zw = child.wz; }
            if (near.y < near.z) { near.yz = near.zy; child.yz = child.zy; }
            for (int i = 0; i < 3; ++i)
                if (near[i] < 3.4e38) {
                    stack[height] = child[i];
                    stack_t[height] = near[i];
                    ++height;
                }
            if (near.w < 3.4e38) {
                current = child.w;
                continue;
            }
        } else if (instance == kNone) {
            // A top leaf holds one instance: go down into its bottom level.
            const BvhTopItem item = BvhTopItems(top_items).v[current & kBvhFirstMask];
            instance = item.instance;
            origin = transform_point(item.object_from_world, origin_ws);
            direction = transform_vector(item.object_from_world, direction_ws);
            inv_direction = safe_inverse(direction);
            sheared = make_sheared_ray(origin, direction);
            nodes = scene.header.bottom_nodes;
            bottom_height = height;
            current = item.root;
            continue;
        } else {
            const uint first = current & kBvhFirstMask, count = ((current >> kBvhCountShift) & 3u) + 1u;
            for (uint i = first; i < first + count; ++i) {
                const BvhTriangle triangle = BvhTriangles(scene.header.bottom_triangles).v[i];
                float t;
                vec2 barycentrics;
                // best.t itself stays in: equal distances are settled by is_nearer.
                if (!intersect_watertight(sheared, triangle.p0, triangle.p1, triangle.p2, t_min, uintBitsToFloat(floatBitsToUint(best.t) + 1u), t, barycentrics)) continue;
                if (t >= t_max || !is_nearer(best, t, instance, triangle)) continue;
                const bool front = dot(cross(triangle.p1 - triangle.p0, triangle.p2 - triangle.p0), direction) < 0.0;
                if (!accept_hit(alpha_key, instance, triangle.geometry, triangle.primitive, barycentrics, front)) continue;
                best = TraversalHit(instance, triangle.geometry, triangle.primitive, barycentrics, t);
                found = true;
                if (any) return true;
            }
        }
        // The next node that may still hold something nearer.
        do {
            if (instance != kNone && height == bottom_height) {
                instance = kNone;
                nodes = top_nodes;
                origin = origin_ws;
                direction = direction_ws;
                inv_direction = safe_inverse(direction_ws);
            }
            if (height == 0u) return found;
            --height;
        } while (stack_t[height] > best.t);
        current = stack[height];
    }
}
#endif
