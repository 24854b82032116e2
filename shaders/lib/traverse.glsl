// Traversal of our own two-level BVH (shared/bvh.h): one loop, one stack, nearest child first. Also compiled as C++
// (shared/functions.h), which is how it is tested against brute force. No shared memory, barrier or subgroup operation.
// The stack cannot overflow: the builder bounds both depths. No ray slips between the triangles of a closed mesh: the triangle
// test is watertight, and boxes are tested with margins for every rounding on the way (lib/bvh_boxes.glsl).
#ifndef PARHELION_LIB_TRAVERSE_GLSL
#define PARHELION_LIB_TRAVERSE_GLSL
#include "lib/bvh_boxes.glsl"
#include "lib/ray_triangle.glsl"
SHARED_BEGIN

// Whether a candidate counts: alpha and culling. Defined by whoever includes this file (scene/alpha.glsl). Front and back are
// judged in object space, as glTF wants it: a mirrored instance keeps its front side.
SHARED_FN bool accept_hit(uint alpha_key, uint instance, uint geometry_of_mesh, uint primitive, vec2 barycentrics, bool front_facing);

// On the stack: the end of an instance, back to the top level. No child has this number, as it would be leaf 2^31 - 2.
SHARED_CONST uint kBvhReturn = 0xFFFFFFFEu;

// Equal distances go to the smaller (instance, geometry, primitive), so that the answer does not depend on the order of visits.
SHARED_FN bool is_nearer(bool found, TraversalHit best, float t, uint instance, uint geometry, uint primitive) {
    if (t != best.t || !found) return t < best.t;
    if (instance != best.instance) return instance < best.instance;
    return geometry != best.geometry ? geometry < best.geometry : primitive < best.primitive;
}

// The triangles of a leaf; returns whether one of them is the nearest hit so far, in `best`.
SHARED_FN bool intersect_leaf(uint64_t triangles, uint index, bool in_pairs, ShearedRay sheared, TraversalRay ray, uint instance, bool any, bool found, SHARED_INOUT(TraversalHit) best) {
    uint rest = 1u;
    for (; rest != 0u; ++index) {
        const uint64_t address = row_address(triangles, index, 48u);
        const uvec4 first = fetch_row(address, 0u, in_pairs), second = fetch_row(address, 1u, in_pairs), third = fetch_row(address, 2u, in_pairs);
        rest = third.y;
        TriangleHit hit;
        if (!intersect_watertight(sheared, to_floats(first.x, first.y, first.z), to_floats(first.w, second.x, second.y), to_floats(second.z, second.w, third.x), hit)) continue;
        if (!(hit.t > ray.t_min) || hit.t > best.t) continue;
        if (!is_nearer(found, best, hit.t, instance, third.z, third.w)) continue;
        if (!accept_hit(ray.alpha_key, instance, third.z, third.w, hit.barycentrics, hit.front_facing)) continue;
        best.instance = instance;
        best.geometry = third.z;
        best.primitive = third.w;
        best.barycentrics = hit.barycentrics;
        best.t = hit.t;
        found = true;
        if (any) break;
    }
    return found;
}

// variant: layout of the nodes, and kBvhRounds for a loop in which a ray looks at one node and then, if that brought it to a leaf, at
// the leaf, whatever the rays beside it do. Without it, rays that have found a leaf wait for the others of their subgroup: nodes
// then are looked at by all that have none, leaves by all.
// any: ends at the first hit that counts. Returns whether there is a hit, in `best`.
SHARED_FN bool traverse(BvhAddresses bvh, uint variant, TraversalRay ray, bool any, SHARED_INOUT(TraversalHit) best) {
    const uint layout_of_nodes = variant & kBvhLayoutMask;
    const bool rounds = (variant & kBvhRounds) != 0u, in_pairs = reads_pairs(layout_of_nodes);
    uint stack[kBvhStackSize];
    float stack_t[kBvhStackSize];
    const float always = uintBitsToFloat(0xFF800000u);  // minus infinity: not beyond any distance, however broken the ray
    stack[0] = kBvhEmpty;  // the end
    stack_t[0] = always;
    uint height = 1u, current = 0u, instance = 0u;
    bool found = false, in_bottom = false;
    uint64_t nodes = bvh.top_nodes;
    BoxRay box_ray = make_box_ray(ray.origin_ws, ray.direction_ws);
    ShearedRay sheared = make_sheared_ray(ray.origin_ws, ray.direction_ws);
    best.t = ray.t_max;
    while (true) {
        bool pop = (current & kBvhLeaf) != 0u;
        do {
            if (!pop) {
                const EnteredChildren entered = enter_children(nodes, current, layout_of_nodes, box_ray, ray.t_min, best.t);
                if (entered.t.w < kBvhInfinity) { stack[height] = entered.child.w; stack_t[height++] = entered.t.w; }
                if (entered.t.z < kBvhInfinity) { stack[height] = entered.child.z; stack_t[height++] = entered.t.z; }
                if (entered.t.y < kBvhInfinity) { stack[height] = entered.child.y; stack_t[height++] = entered.t.y; }
                current = entered.child.x;
                pop = !(entered.t.x < kBvhInfinity);
            }
            if (pop) {
                // The next node that may still hold something nearer. Equal distances are visited, for is_nearer.
                do --height; while (stack_t[height] > best.t * 1.000001f);
                current = stack[height];
                pop = false;
            }
        } while (!rounds && (current & kBvhLeaf) == 0u);
        if (rounds && (current & kBvhLeaf) == 0u) continue;
        if (current == kBvhEmpty) return found;
        if (current == kBvhReturn) {
            in_bottom = false;
            nodes = bvh.top_nodes;
            box_ray = make_box_ray(ray.origin_ws, ray.direction_ws);
        } else if (in_bottom) {
            found = intersect_leaf(bvh.bottom_triangles, current & kBvhItemMask, in_pairs, sheared, ray, instance, any, found, best);
            if (any && found) return true;
        } else {
            const uint64_t address = row_address(bvh.top_items, current & kBvhItemMask, 64u);
            const uvec4 row0 = fetch_row(address, 0u, in_pairs), row1 = fetch_row(address, 1u, in_pairs), row2 = fetch_row(address, 2u, in_pairs), place = fetch_row(address, 3u, in_pairs);
            if ((row2.w & ray.mask) != 0u) {
                const vec3 m0 = to_floats(row0.x, row0.y, row0.z), m1 = to_floats(row1.x, row1.y, row1.z), m2 = to_floats(row2.x, row2.y, row2.z);
                const vec3 p = ray.origin_ws - to_floats(place.x, place.y, place.z), d = ray.direction_ws;
                SHARED_PRECISE const vec3 origin = vec3(dot(m0, p), dot(m1, p), dot(m2, p));
                SHARED_PRECISE const vec3 direction = vec3(dot(m0, d), dot(m1, d), dot(m2, d));
                box_ray = make_box_ray(origin, direction);
                sheared = make_sheared_ray(origin, direction);
                instance = row0.w;
                nodes = bvh.bottom_nodes;
                current = row1.w;
                stack[height] = kBvhReturn;
                stack_t[height++] = always;
                in_bottom = true;
            }
        }
    }
}

// The nearest hit; false for none, `hit` then undefined.
SHARED_FN bool traverse_closest(BvhAddresses bvh, uint variant, TraversalRay ray, SHARED_INOUT(TraversalHit) hit) { return traverse(bvh, variant, ray, false, hit); }

// Whether there is any hit.
SHARED_FN bool traverse_any(BvhAddresses bvh, uint variant, TraversalRay ray) {
    TraversalHit hit;
    return traverse(bvh, variant, ray, true, hit);
}

SHARED_END
#endif
