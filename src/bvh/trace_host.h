#pragma once
// The traversal on the host: shaders/lib/traverse.glsl compiled as C++. For tests against brute force and for questions that the
// host asks about a scene; one ray at a time, so not fast.
#include <functional>

#include "bvh/bvh.h"

namespace parhelion::bvh {

// Whether a candidate counts (accept_hit of the shaders). Empty: all do.
using AcceptHit = std::function<bool(uint32_t instance, uint32_t geometry, uint32_t primitive, glm::vec2 barycentrics, bool front_facing)>;

// The nearest hit with t_min < t < t_max; false for none, `hit` then undefined. Equal distances: the smallest (instance,
// geometry, primitive).
bool trace_closest_host(const Bottoms& bottoms, const Top& top, const shared::TraversalRay& ray, shared::TraversalHit& hit, const AcceptHit& accept = {});
bool trace_any_host(const Bottoms& bottoms, const Top& top, const shared::TraversalRay& ray, const AcceptHit& accept = {});

}  // namespace parhelion::bvh
