// Tracing by our own BVH: needs no ray tracing extension.
#include "lib/traverse.glsl"
#include "scene/alpha.glsl"

layout(constant_id = 0) const uint kBvhVariant = kBvhFour;  // layout of the scene's nodes, and the loop: SceneBinding::bvh_variant

BvhAddresses bvh_at(uint moment) {
    if (moment == kNow) return BvhAddresses(scene.header.top_nodes, scene.header.top_items, scene.header.bottom_nodes, scene.header.bottom_triangles);
    return BvhAddresses(scene.header.top_nodes_before, scene.header.top_items_before, scene.header.bottom_nodes, scene.header.bottom_triangles);
}

TraversalRay to_traversal_ray(Ray ray) { return TraversalRay(ray.origin_ws, ray.t_min, ray.direction_ws, ray.t_max, 0xFFu, ray.alpha_key); }

Hit trace_closest(Ray ray) {
    TraversalHit hit;
    if (!traverse_closest(bvh_at(kNow), kBvhVariant, to_traversal_ray(ray), hit)) return make_miss();
    return Hit(hit.instance | ((scene_instance(hit.instance).flags & kInstanceDeforms) << 30), hit.geometry, hit.primitive, packUnorm2x16(hit.barycentrics), hit.t);
}

bool trace_visible(Ray ray, uint moment) { return !traverse_any(bvh_at(moment), kBvhVariant, to_traversal_ray(ray)); }
