// Tracing by our own BVH: needs no ray tracing extension.
#include "scene/traverse.glsl"

Hit trace_closest(Ray ray) {
    TraversalHit found;
    if (!traverse(scene.header.top_nodes, scene.header.top_items, ray.origin_ws, ray.direction_ws, ray.t_min, ray.t_max, ray.alpha_key, false, found)) return make_miss();
    return Hit(found.instance | ((scene_instance(found.instance).flags & kInstanceDeforms) << 30), found.geometry, found.primitive, packUnorm2x16(found.barycentrics), found.t);
}

bool trace_visible(Ray ray, uint moment) {
    TraversalHit found;
    const uint64_t nodes = moment == kNow ? scene.header.top_nodes : scene.header.top_nodes_before;
    const uint64_t items = moment == kNow ? scene.header.top_items : scene.header.top_items_before;
    return !traverse(nodes, items, ray.origin_ws, ray.direction_ws, ray.t_min, ray.t_max, ray.alpha_key, true, found);
}
