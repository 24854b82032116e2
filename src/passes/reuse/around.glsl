// Pixels around that see a surface like a pixel's own. A pass that includes it declares images `summary` and `depth`, and push constants with
// `frame`.
#ifndef PARHELION_REUSE_AROUND_GLSL
#define PARHELION_REUSE_AROUND_GLSL
#include "reuse/site.glsl"

Site site_of(ViewData view, ivec2 at, uvec4 seen) { return site_at(view.camera, view.jitter, vec2(view.width, view.height), at, seen, imageLoad(depth, at).x); }

// False: none of the first few is.
bool find_neighbour(ViewData view, uvec2 id, Site here, uint index, out ivec2 found, out Site there) {
    const uint kTries = 4u;
    for (uint i = 0u; i < kTries; ++i) {
        const vec4 u = reuse_numbers(view, id, push.frame, 16u + kTries * index + i);
        found = ivec2(floor(vec2(id) + 0.5 + push.frame.radius_px * sample_concentric_disk(u.xy)));
        if (found == ivec2(id) || any(lessThan(found, ivec2(0))) || any(greaterThanEqual(found, ivec2(view.width, view.height)))) continue;
        const uvec4 seen = imageLoad(summary, found);
        if (!sees_surface(seen)) continue;
        there = site_of(view, found, seen);
        if (are_similar(here.normal_ws, there.normal_ws, here.position_ws, there.position_ws, here.distance)) return true;
    }
    return false;
}
#endif
