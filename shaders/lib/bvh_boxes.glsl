// Rays against the children's boxes of a node, of each layout (shared/bvh.h). Also compiled as C++ (shared/functions.h).
#ifndef PARHELION_LIB_BVH_BOXES_GLSL
#define PARHELION_LIB_BVH_BOXES_GLSL
#include "lib/bvh_nodes.glsl"
SHARED_BEGIN

const float kBvhInfinity = 3.4e38f;

// A ray prepared for boxes.
struct BoxRay {
    vec3 inverse;  // of the direction, finite
    vec3 near_offset, far_offset;  // a plane's distance is plane * inverse + offset
    vec3 origin, margin;           // or (plane - origin) * inverse, -+ margin
};

// The margins: the near planes come nearer and the far ones go farther by 1e-6 of the origin's coordinate, and the far distance
// grows by 2e-6. Together they cover the roundings of offset, product and sum (a plane's coordinate is at most the
// origin's plus the way to it), a division good to 2.5 units in the last place at both ends, and what the ray lost on its way into
// object space. A ray in a face's plane meets the box. (Ize 2013, "Robust BVH Ray Traversal")
SHARED_FN BoxRay make_box_ray(vec3 origin, vec3 direction) {
    const float tiny = 1e-25f;  // stands for a zero component: keeps products finite
    BoxRay ray;
    ray.inverse.x = 1.0f / (abs(direction.x) > tiny ? direction.x : tiny);
    ray.inverse.y = 1.0f / (abs(direction.y) > tiny ? direction.y : tiny);
    ray.inverse.z = 1.0f / (abs(direction.z) > tiny ? direction.z : tiny);
    ray.origin = origin;
    ray.margin = (abs(origin) * 1e-6f + 1e-16f) * abs(ray.inverse);
    const vec3 offset = -origin * ray.inverse;
    ray.near_offset = offset - ray.margin;
    ray.far_offset = offset + ray.margin;
    return ray;
}

// The distances at which boxes are entered; kBvhInfinity for those that are missed.
SHARED_FN vec4 entered_at(vec4 near, vec4 far, uvec4 child) {
    const vec4 last = far * 1.000002f;
    return vec4(near.x <= last.x && child.x != kBvhEmpty ? near.x : kBvhInfinity, near.y <= last.y && child.y != kBvhEmpty ? near.y : kBvhInfinity,
                near.z <= last.z && child.z != kBvhEmpty ? near.z : kBvhInfinity, near.w <= last.w && child.w != kBvhEmpty ? near.w : kBvhInfinity);
}

SHARED_FN vec4 intersect_four(BvhNode node, BoxRay ray, float t_min, float t_max) {
    const bool back_x = ray.inverse.x < 0.0f, back_y = ray.inverse.y < 0.0f, back_z = ray.inverse.z < 0.0f;
    const vec4 near_x = (back_x ? node.max_x : node.min_x) * ray.inverse.x + ray.near_offset.x;
    const vec4 near_y = (back_y ? node.max_y : node.min_y) * ray.inverse.y + ray.near_offset.y;
    const vec4 near_z = (back_z ? node.max_z : node.min_z) * ray.inverse.z + ray.near_offset.z;
    const vec4 far_x = (back_x ? node.min_x : node.max_x) * ray.inverse.x + ray.far_offset.x;
    const vec4 far_y = (back_y ? node.min_y : node.max_y) * ray.inverse.y + ray.far_offset.y;
    const vec4 far_z = (back_z ? node.min_z : node.max_z) * ray.inverse.z + ray.far_offset.z;
    return entered_at(max(max(near_x, near_y), max(near_z, vec4(t_min))), min(min(far_x, far_y), min(far_z, vec4(t_max))), node.child);
}

// Planes are not computed: the distance of plane n is n * (scale / d) + (node's origin - ray's origin) / d. Where these cancel, up to
// five roundings (2^-24) of 255 scale remain, 8e-5 scale in all: 1e-4 scale more of margin.
SHARED_FN vec4 intersect_compact(BvhNodeCompact node, BoxRay ray, float t_min, float t_max) {
    const bool back_x = ray.inverse.x < 0.0f, back_y = ray.inverse.y < 0.0f, back_z = ray.inverse.z < 0.0f;
    const vec3 step = node.scale * ray.inverse, base = (node.origin - ray.origin) * ray.inverse, margin = abs(step) * 1e-4f + ray.margin;
    const vec3 near_base = base - margin, far_base = base + margin;
    const vec4 near_x = unpack_bytes(back_x ? node.max_x : node.min_x) * step.x + near_base.x;
    const vec4 near_y = unpack_bytes(back_y ? node.max_y : node.min_y) * step.y + near_base.y;
    const vec4 near_z = unpack_bytes(back_z ? node.max_z : node.min_z) * step.z + near_base.z;
    const vec4 far_x = unpack_bytes(back_x ? node.min_x : node.max_x) * step.x + far_base.x;
    const vec4 far_y = unpack_bytes(back_y ? node.min_y : node.max_y) * step.y + far_base.y;
    const vec4 far_z = unpack_bytes(back_z ? node.min_z : node.max_z) * step.z + far_base.z;
    return entered_at(max(max(near_x, near_y), max(near_z, vec4(t_min))), min(min(far_x, far_y), min(far_z, vec4(t_max))), node.child);
}

SHARED_FN vec2 intersect_binary(BvhNodeBinary node, BoxRay ray, float t_min, float t_max) {
    const bool back_x = ray.inverse.x < 0.0f, back_y = ray.inverse.y < 0.0f, back_z = ray.inverse.z < 0.0f;
    const vec2 min_x = vec2(node.x.x, node.x.y), max_x = vec2(node.x.z, node.x.w);
    const vec2 min_y = vec2(node.y.x, node.y.y), max_y = vec2(node.y.z, node.y.w);
    const vec2 min_z = vec2(node.z.x, node.z.y), max_z = vec2(node.z.z, node.z.w);
    const vec2 near_x = (back_x ? max_x : min_x) * ray.inverse.x + ray.near_offset.x, far_x = (back_x ? min_x : max_x) * ray.inverse.x + ray.far_offset.x;
    const vec2 near_y = (back_y ? max_y : min_y) * ray.inverse.y + ray.near_offset.y, far_y = (back_y ? min_y : max_y) * ray.inverse.y + ray.far_offset.y;
    const vec2 near_z = (back_z ? max_z : min_z) * ray.inverse.z + ray.near_offset.z, far_z = (back_z ? min_z : max_z) * ray.inverse.z + ray.far_offset.z;
    const vec2 near = max(max(near_x, near_y), max(near_z, vec2(t_min))), last = min(min(far_x, far_y), min(far_z, vec2(t_max))) * 1.000002f;
    return vec2(near.x <= last.x && node.child.x != kBvhEmpty ? near.x : kBvhInfinity, near.y <= last.y && node.child.y != kBvhEmpty ? near.y : kBvhInfinity);
}

// The children that a ray enters, the nearest first: their distances, kBvhInfinity from the first that is missed on.
struct EnteredChildren {
    vec4 t;
    uvec4 child;
};

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

SHARED_FN EnteredChildren enter_children(uint64_t nodes, uint index, uint layout_of_nodes, BoxRay ray, float t_min, float t_max) {
    EnteredChildren entered;
    if (layout_of_nodes == kBvhBinary) {
        const BvhNodeBinary node = fetch_binary(nodes, index);
        const vec2 t = intersect_binary(node, ray, t_min, t_max);
        entered.t = vec4(t.x, t.y, kBvhInfinity, kBvhInfinity);
        entered.child = uvec4(node.child.x, node.child.y, kBvhEmpty, kBvhEmpty);
        order_pair(entered.t.x, entered.child.x, entered.t.y, entered.child.y);
        return entered;
    }
    if (layout_of_nodes == kBvhCompact) {
        const BvhNodeCompact node = fetch_compact(nodes, index);
        entered.t = intersect_compact(node, ray, t_min, t_max);
        entered.child = node.child;
    } else {
        const BvhNode node = fetch_four(nodes, index);
        entered.t = intersect_four(node, ray, t_min, t_max);
        entered.child = node.child;
    }
    order_pair(entered.t.x, entered.child.x, entered.t.z, entered.child.z);
    order_pair(entered.t.y, entered.child.y, entered.t.w, entered.child.w);
    order_pair(entered.t.x, entered.child.x, entered.t.y, entered.child.y);
    order_pair(entered.t.z, entered.child.z, entered.t.w, entered.child.w);
    order_pair(entered.t.y, entered.child.y, entered.t.z, entered.child.z);
    return entered;
}

SHARED_END
#endif
