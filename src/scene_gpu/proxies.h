#pragma once
// Proxies: fewer triangles that rays meet in the place of a geometry's own, which raster passes still draw.
#include <vector>

#include "scene/types.h"

namespace parhelion {

struct Proxy {
    std::vector<glm::uvec3> triangles;  // over the geometry's vertices; none: it has no proxy
    // By triangle of the geometry, how far the proxy rises over it along its normal, and along the opposite: units of the object, two floats
    // without their lower halves, rounded up, the first in the upper half. As shared::Geometry::proxy_heights.
    std::vector<uint32_t> heights;
};

// Keeps this share of the triangles, or more where others would go farther than `deviation` (units of the object, root mean square). Empty
// where that gains little (scene/simplify.h). Depends on nothing else.
Proxy make_proxy(const Primitive& primitive, float ratio, float deviation);

// Whether rays may meet the proxy of what has this material: no light table names its triangles, no ray passes it.
bool takes_proxies(const Material& material);

}  // namespace parhelion
