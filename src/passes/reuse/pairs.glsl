// Pixels in pairs, for spatial reuse: each asks how much the other's sample brings to it, and what the other has found out about its own is the other half of
// what both must know to weigh their samples. So a pair costs two rays where each by itself would take two. Which pixels are a pair changes in every frame. A
// pass that includes it declares images `summary` and `depth`, and push constants with `frame`.
#ifndef PARHELION_REUSE_PAIRS_GLSL
#define PARHELION_REUSE_PAIRS_GLSL
#include "reuse/partner.glsl"
#include "reuse/site.glsl"

Site site_of(ViewData view, ivec2 at, uvec4 seen) { return site_at(view.camera, view.jitter, vec2(view.width, view.height), at, seen, imageLoad(depth, at).x); }

// The same both ways.
bool may_pair(ViewData view, uvec2 id, Site here, uint index, uint turn, out ivec2 found, out Site there) {
    found = partner_of(view, push.frame, id, index, turn);
    if (any(lessThan(found, ivec2(0))) || any(greaterThanEqual(found, ivec2(view.width, view.height)))) return false;
    const uvec4 seen = imageLoad(summary, found);
    if (!sees_surface(seen)) return false;
    there = site_of(view, found, seen);
    return are_similar(here.normal_ws, there.normal_ws, here.position_ws, there.position_ws, here.distance) &&
           are_similar(there.normal_ws, here.normal_ws, there.position_ws, here.position_ws, there.distance);
}

// The turn in which a pixel finds its partner, the second one if neither has found one in the first; kNoPartner: it stays alone.
uint find_partner(ViewData view, uvec2 id, Site here, uint index, out ivec2 found, out Site there) {
    if (may_pair(view, id, here, index, 0u, found, there)) return 0u;
    ivec2 of_other;
    Site its_site;
    if (may_pair(view, id, here, index, 1u, found, there) && !may_pair(view, uvec2(found), there, index, 0u, of_other, its_site)) return 1u;
    return kNoPartner;
}
#endif
