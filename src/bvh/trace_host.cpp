#include "bvh/trace_host.h"

#include "base/error.h"
#include "lib/traverse.glsl"

namespace parhelion::shared {

namespace {
thread_local const bvh::AcceptHit* current_accept = nullptr;  // of the trace call that this thread is in
}

bool accept_hit(uint, uint instance, uint geometry_of_mesh, uint primitive, vec2 barycentrics, bool front_facing) {
    return !*current_accept || (*current_accept)(instance, geometry_of_mesh, primitive, barycentrics, front_facing);
}

}  // namespace parhelion::shared

namespace parhelion::bvh {

namespace {

template <class T>
uint64_t address(const std::vector<T>& v) {
    return reinterpret_cast<uint64_t>(v.data());
}

shared::BvhAddresses addresses(const Bottoms& bottoms, const Top& top) {
    return {address(top.nodes.words), address(top.items), address(bottoms.nodes.words), address(bottoms.triangles)};
}

uint32_t layout_of(const Bottoms& bottoms, const Top& top) {
    PARHELION_CHECK(bottoms.nodes.layout == top.nodes.layout, "a top level of layout {} over bottom levels of layout {}", layout_name(top.nodes.layout), layout_name(bottoms.nodes.layout));
    return static_cast<uint32_t>(top.nodes.layout);
}

}  // namespace

bool trace_closest_host(const Bottoms& bottoms, const Top& top, const shared::TraversalRay& ray, shared::TraversalHit& hit, const AcceptHit& accept) {
    shared::current_accept = &accept;
    return shared::traverse_closest(addresses(bottoms, top), layout_of(bottoms, top), ray, hit);
}

bool trace_any_host(const Bottoms& bottoms, const Top& top, const shared::TraversalRay& ray, const AcceptHit& accept) {
    shared::current_accept = &accept;
    return shared::traverse_any(addresses(bottoms, top), layout_of(bottoms, top), ray);
}

}  // namespace parhelion::bvh
