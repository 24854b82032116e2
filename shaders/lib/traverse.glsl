// Traversal of our own two-level BVH (shared/bvh.h): one loop, one stack, nearest child first. Also compiled as C++
// (shared/functions.h), which is how it is tested against brute force. No shared memory, barrier or subgroup operation.
// The stack cannot overflow: the builder bounds both depths. No ray slips between the triangles of a closed mesh: the triangle
// test is watertight, and boxes are tested with margins for every rounding on the way (Ize 2013, "Robust BVH Ray Traversal").
#ifndef PARHELION_LIB_TRAVERSE_GLSL
#define PARHELION_LIB_TRAVERSE_GLSL
#include "lib/bvh_nodes.glsl"
#include "lib/ray_triangle.glsl"
SHARED_BEGIN

SHARED_ARRAY_16(BvhTriangles, BvhTriangle)
SHARED_ARRAY_16(BvhTopItems, BvhTopItem)

// Whether a candidate counts: alpha and culling. Defined by whoever includes this file (scene/alpha.glsl). Front and back are
// judged in object space, as glTF wants it: a mirrored instance keeps its front side.
SHARED_FN bool accept_hit(uint alpha_key, uint instance, uint geometry_of_mesh, uint primitive, vec2 barycentrics, bool front_facing);

// A ray prepared for boxes: a plane's distance is plane * inverse + offset.
struct BoxRay {
    vec3 inverse;  // of the direction, finite
    vec3 near_offset, far_offset;
};

const float kBvhInfinity = 3.4e38f;

// The margins: the near planes come nearer and the far ones go farther by 1e-6 of the origin's coordinate, and the far distance
// grows by 1e-6. Together they cover the roundings of offset, product and sum (a plane's coordinate is at most the
// origin's plus the way to it), a division good to 2.5 units in the last place at both ends, and what the ray lost on its way into
// object space. A ray in a face's plane meets the box.
SHARED_FN BoxRay make_box_ray(vec3 origin, vec3 direction) {
    const float tiny = 1e-25f;  // stands for a zero component: keeps products finite
    BoxRay ray;
    ray.inverse.x = 1.0f / (abs(direction.x) > tiny ? direction.x : tiny);
    ray.inverse.y = 1.0f / (abs(direction.y) > tiny ? direction.y : tiny);
    ray.inverse.z = 1.0f / (abs(direction.z) > tiny ? direction.z : tiny);
    const vec3 offset = -origin * ray.inverse, margin = (abs(origin) * 1e-6f + 1e-16f) * abs(ray.inverse);
    ray.near_offset = offset - margin;
    ray.far_offset = offset + margin;
    return ray;
}

// Distances at which a node's four children are entered; kBvhInfinity for those that are missed.
SHARED_FN vec4 intersect_children(BvhNode node, BoxRay ray, float t_min, float t_max) {
    const bool back_x = ray.inverse.x < 0.0f, back_y = ray.inverse.y < 0.0f, back_z = ray.inverse.z < 0.0f;
    const vec4 near_x = (back_x ? node.max_x : node.min_x) * ray.inverse.x + ray.near_offset.x;
    const vec4 near_y = (back_y ? node.max_y : node.min_y) * ray.inverse.y + ray.near_offset.y;
    const vec4 near_z = (back_z ? node.max_z : node.min_z) * ray.inverse.z + ray.near_offset.z;
    const vec4 far_x = (back_x ? node.min_x : node.max_x) * ray.inverse.x + ray.far_offset.x;
    const vec4 far_y = (back_y ? node.min_y : node.max_y) * ray.inverse.y + ray.far_offset.y;
    const vec4 far_z = (back_z ? node.min_z : node.max_z) * ray.inverse.z + ray.far_offset.z;
    const vec4 t_near = max(max(near_x, near_y), max(near_z, vec4(t_min)));
    const vec4 t_far = min(min(far_x, far_y), min(far_z, vec4(t_max))) * 1.000001f;
    return vec4(t_near.x <= t_far.x && node.child.x != kBvhEmpty ? t_near.x : kBvhInfinity,
                t_near.y <= t_far.y && node.child.y != kBvhEmpty ? t_near.y : kBvhInfinity,
                t_near.z <= t_far.z && node.child.z != kBvhEmpty ? t_near.z : kBvhInfinity,
                t_near.w <= t_far.w && node.child.w != kBvhEmpty ? t_near.w : kBvhInfinity);
}

SHARED_FN void order_pair(SHARED_INOUT(float) t_a, SHARED_INOUT(uint) child_a, SHARED_INOUT(float) t_b, SHARED_INOUT(uint) child_b) {
    if (t_b < t_a) {
        const float t = t_a;
        t_a = t_b;
        t_b = t;
        const uint child = child_a;
        child_a = child_b;
        child_b = child;
    }
}

// Equal distances go to the smaller (instance, geometry, primitive), so that the answer does not depend on the order of visits.
SHARED_FN bool is_nearer(bool found, TraversalHit best, float t, uint instance, uint geometry, uint primitive) {
    if (t != best.t || !found) return t < best.t;
    if (instance != best.instance) return instance < best.instance;
    return geometry != best.geometry ? geometry < best.geometry : primitive < best.primitive;
}

// The triangles of a leaf; returns whether one of them is the nearest hit so far, in `best`.
SHARED_FN bool intersect_leaf(uint64_t triangles, uint index, ShearedRay sheared, TraversalRay ray, uint instance, bool any, bool found, SHARED_INOUT(TraversalHit) best) {
    uint rest = 1u;
    for (; rest != 0u; ++index) {
        const BvhTriangle triangle = BvhTriangles(row_address(triangles, index, 48u)).v[0];
        rest = triangle.rest;
        TriangleHit hit;
        if (!intersect_watertight(sheared, triangle.p0, triangle.p1, triangle.p2, hit)) continue;
        if (!(hit.t > ray.t_min) || !is_nearer(found, best, hit.t, instance, triangle.geometry, triangle.primitive)) continue;
        if (!accept_hit(ray.alpha_key, instance, triangle.geometry, triangle.primitive, hit.barycentrics, hit.front_facing)) continue;
        best.instance = instance;
        best.geometry = triangle.geometry;
        best.primitive = triangle.primitive;
        best.barycentrics = hit.barycentrics;
        best.t = hit.t;
        found = true;
        if (any) break;
    }
    return found;
}

// any: ends at the first hit that counts. Returns whether there is a hit, in `best`.
SHARED_FN bool traverse(BvhAddresses bvh, uint layout_of_nodes, TraversalRay ray, bool any, SHARED_INOUT(TraversalHit) best) {
    uint stack[kBvhStackSize];
    float stack_t[kBvhStackSize];
    uint height = 0u, bottom_height = 0u, current = 0u, instance = 0u;
    bool found = false, in_bottom = false;
    uint64_t nodes = bvh.top_nodes;
    BoxRay box_ray = make_box_ray(ray.origin_ws, ray.direction_ws);
    ShearedRay sheared = make_sheared_ray(ray.origin_ws, ray.direction_ws);
    best.t = ray.t_max;
    while (true) {
        if ((current & kBvhLeaf) == 0u) {
            const BvhNode node = fetch_node(nodes, current, layout_of_nodes);
            vec4 t = intersect_children(node, box_ray, ray.t_min, best.t);
            uvec4 child = node.child;
            order_pair(t.x, child.x, t.z, child.z);
            order_pair(t.y, child.y, t.w, child.w);
            order_pair(t.x, child.x, t.y, child.y);
            order_pair(t.z, child.z, t.w, child.w);
            order_pair(t.y, child.y, t.z, child.z);
            if (t.w < kBvhInfinity) { stack[height] = child.w; stack_t[height++] = t.w; }
            if (t.z < kBvhInfinity) { stack[height] = child.z; stack_t[height++] = t.z; }
            if (t.y < kBvhInfinity) { stack[height] = child.y; stack_t[height++] = t.y; }
            current = t.x < kBvhInfinity ? child.x : kBvhEmpty;
            if ((current & kBvhLeaf) == 0u) continue;
        }
        // Not `else`: a leaf that was just found is looked at in the same round, together with the leaves of other rays.
        if (current != kBvhEmpty && !in_bottom) {
            const BvhTopItem item = BvhTopItems(row_address(bvh.top_items, current & kBvhItemMask, 64u)).v[0];
            if ((item.mask & ray.mask) != 0u) {
                const vec3 p = ray.origin_ws - item.origin_ws, d = ray.direction_ws;
                SHARED_PRECISE const vec3 origin = vec3(dot(item.row0, p), dot(item.row1, p), dot(item.row2, p));
                SHARED_PRECISE const vec3 direction = vec3(dot(item.row0, d), dot(item.row1, d), dot(item.row2, d));
                box_ray = make_box_ray(origin, direction);
                sheared = make_sheared_ray(origin, direction);
                instance = item.instance;
                nodes = bvh.bottom_nodes;
                current = item.root;
                bottom_height = height;
                in_bottom = true;
                continue;
            }
        } else if (current != kBvhEmpty) {
            found = intersect_leaf(bvh.bottom_triangles, current & kBvhItemMask, sheared, ray, instance, any, found, best);
            if (any && found) return true;
        }
        // The next node that may still hold something nearer. Equal distances are visited, for is_nearer.
        do {
            if (in_bottom && height == bottom_height) {
                in_bottom = false;
                nodes = bvh.top_nodes;
                box_ray = make_box_ray(ray.origin_ws, ray.direction_ws);
            }
            if (height == 0u) return found;
            --height;
        } while (stack_t[height] > best.t * 1.000001f);
        current = stack[height];
    }
}

// The nearest hit; false for none, `hit` then undefined.
SHARED_FN bool traverse_closest(BvhAddresses bvh, uint layout_of_nodes, TraversalRay ray, SHARED_INOUT(TraversalHit) hit) { return traverse(bvh, layout_of_nodes, ray, false, hit); }

// Whether there is any hit.
SHARED_FN bool traverse_any(BvhAddresses bvh, uint layout_of_nodes, TraversalRay ray) {
    TraversalHit hit;
    return traverse(bvh, layout_of_nodes, ray, true, hit);
}

SHARED_END
#endif
