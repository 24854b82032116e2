#version 460
// Shades a vertex of each listed path: what arrives there, which light it asks for, where it goes on. The light is one sample out of
// several, more of them at the first surface than later; behind it paths end in the world cache (CACHE), in the sky, or by themselves. Without the cache this is the
// reference's estimate, and without light tiles too it has the reference's samples of the frame's index.
// Scenes of layered materials (glass, coats, sheen) have two kernels: PLAIN+LAYERS for surfaces that are plain.
// Reads: scene, view, identity (what paths meet first), hits (later), lists (a kernel's), tiles. Reads and writes: control, lists (rays),
// rays, paths, inside, sums, emission, block (path classes, debug layers), with CACHE cache (cells that are missed, and longer lives), and with
// REUSE reservoirs (what may be shared of the light goes there), offered (all of that) and reuse (second vertices).
// Writes: shadow_list, shadow_rays, pending, distances (to what the first ray met); REUSE: offers and brings (of the shadow rays).
// variants: CACHE LAYERS LAYERS+CACHE PLAIN+LAYERS+CACHE REUSE CACHE+REUSE LAYERS+REUSE LAYERS+CACHE+REUSE PLAIN+LAYERS+CACHE+REUSE
#extension GL_GOOGLE_include_directive : require
#define OWN_SCATTERING
#ifdef PLAIN
#define ABSENT_MATERIAL_FLAGS (kMaterialTransmits | kMaterialThin | kMaterialCoated | kMaterialSheen)
#endif
#include "lib/packed_light.glsl"
#include "lights/candidates.glsl"
#include "realtime/paths.glsl"
#include "scene/begin_path.glsl"
#include "scene/follow.glsl"
#include "wavefront/linear.glsl"
#include "wavefront/lists.glsl"
#ifdef CACHE
#include "realtime/end_in_cache.glsl"
#endif
#ifdef REUSE
#include "realtime/second_vertex.glsl"
#endif

layout(set = 1, binding = 0, rgba32ui) uniform readonly uimage2D identity;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Hits { WavefrontHit v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer ShadowList { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) writeonly buffer ShadowRays { WavefrontShadowRay v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Light { PackedLight v[]; };
#ifdef REUSE
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Reuse { LightReuse v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) writeonly buffer LightOffers { PackedReservoir v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) writeonly buffer Brings { LightSums v[]; };
#endif
layout(push_constant, scalar) uniform Push {
    ViewBlock view;
    Control control;
    Lists lists;
    Rays rays;
    LightPaths paths;
    Inside inside;
    Hits hits;
    Sums sums;
    Light emission;
    FilmBlock block;
    ShadowList shadow_list;
    ShadowRays shadow_rays;
    Pending pending;
    Distances distances;
    Tiles tiles;
#ifdef CACHE
    Cache cache;
#endif
#ifdef REUSE
    Reservoirs reservoirs;
    Reuse reuse;
    LightOffers offers;
    Brings brings;
    Sums offered;
#endif
    RealtimeFrame frame;
    uint list;
    uint round;  // rays that each path has traced
} push;

Footprint footprint;
vec3 from_cache = vec3(0.0);  // what the vertex got from there
#ifdef REUSE
#include "realtime/share.glsl"
#endif
#include "realtime/keep_light.glsl"

// Light samples that a vertex' one is chosen from; 0: it is one of all lights.
uint candidates_at(bool first) { return push.frame.tiles == 0u ? 0u : first ? push.frame.candidates : push.frame.later_candidates; }

NextEvent ask_for_light(ViewData view, PathKey key, PathState path, Shading shading, VertexNumbers u, bool first) {
    const uint shadow_key = alpha_key(key, path.path_class.bounce, kRayShadow);
    const uint candidates = candidates_at(first);
    const bool resampled = candidates != 0u;
    vec4 u_light = u.light;
    Candidate kept = Candidate(0u, kNone, 0u, 1.0);
    LightPick pick;
    if (resampled) {
        kept = choose_candidate(view, key, shading, path.path_class.bounce, push.tiles, candidates);
        pick = LightPick(kept.emitter, kept.triangle, kept.scale > 0.0 ? pick_probability(kept.emitter, kept.triangle) : 0.0);
        u_light = tile_numbers(kept.place, key.sample_index, key.seed, 1u);
    } else pick = pick_light(shading.s.position_ws, shading.s.n_geometric_ws, u.pick);
    if (path.path_class.bounce == 0u) film_add(push.block, view, kFilmDebugLight, key.pixel.y * view.width + key.pixel.x, vec3(float(pick.emitter == kNone ? 0u : pick.emitter + 1u)));
#ifdef REUSE
    const bool of_sky = pick.emitter == scene.header.environment.emitter;
    if (push.round == 0u && may_share(shading.s)) {
        if (!of_sky) u_light.xy = unpack_place(pack_place(u_light.xy));  // as others will have it
        asked = sample_of_light(pick, u_light);
        asked_rough = is_rough(shading.s);
    }
#endif
    const LightSample light = sample_light(pick, shading.s.position_ws, u_light);
    NextEvent event = next_event(view, path, shading, light, resampled ? 1.0 / float(candidates) : 1.0, shadow_key);
    if (resampled) {
        event.value = scale(event.value, vec3(kept.scale));
        event.light *= kept.scale;
    }
#ifdef REUSE
    if (asked.kind != kSampleNone && of_sky) asked = sample_of_direction(kSampleSky, pick.emitter, event.ray.direction_ws, light.radiance);
    if (asked.kind != kSampleNone) asked_density = (of_sky ? light.pdf : pick.probability) / kept.scale;
#endif
    return event;
}

void scatter_at(ViewData view, PathKey key, Shading shading, VertexNumbers u, inout PathState path, inout VertexResult result) {
    const uint bounce = path.path_class.bounce, next_key = alpha_key(key, bounce + 1u, kRayPath);
    const bool straight = (footprint.flags & kLobeStraight) != 0u, mirror = straight && push.round + 1u < kMostFollowed && is_mirror(shading.s);
    const bool first = bounce == 0u || straight;
    footprint.flags &= ~kLobeFirst;
    if (!mirror) footprint.flags = footprint.flags & ~kLobeStraight | (first ? kLobeFirst : 0u) | (straight && bounce != 0u ? kLobeBehind : 0u);
    bool ended = false;
    float density = 0.0;
#ifdef REUSE
    if (!straight) note_second(path, shading);
    const float factor = max_component(path.throughput) / arrived;
    const vec3 diffuse_share = path.path_class.diffuse_share;
    const bool splits = (first && !mirror) || (push.round == 1u && is_second());
#else
    const bool splits = first && !mirror;
#endif
#ifdef CACHE
    advance(footprint, path.travelled + shading.s.t);
    const bool last = !first && footprint.reflections >= push.frame.path_bounces && may_end_in_cache(shading);
    ended = !first && end_in_cache(push.cache, view, key, path, shading, u, footprint, last, from_cache);
#ifdef REUSE
    cached = (push.round == 1u ? vec3(factor) : path.throughput) * from_cache;
    if (ended) second.bits |= push.round == 1u ? kReuseGlossy : 0u;
#endif
    from_cache *= path.throughput;
    float glossy_share = 1.0;
    if (ended && (last || !keep_glossy(path, shading, key, glossy_share))) return;
#endif
    if (!mirror) result.event = ask_for_light(view, key, path, shading, u, first);
#ifdef CACHE
    if (ended) {
        result.event.value.diffuse = vec3(0.0);
        result.event.exists = result.event.exists && max_component(total(result.event.value)) > 0.0;
    }
#endif
#ifdef REUSE
    note_event(path, shading, result.event);
#endif
#ifdef CACHE
    if (last) return;
    result.goes_on = ended ? scatter_glossy(path, shading, u, glossy_share, next_key, density) : scatter(path, shading, u.scatter, true, splits, next_key);
    spread(footprint, path.pdf, mirror || dot(path.ray.direction_ws, shading.n_geometric_ws) < 0.0);
#else
    result.goes_on = scatter(path, shading, u.scatter, true, splits, next_key);
#endif
#ifdef REUSE
    const vec3 second_diffuse = ended ? vec3(0.0) : path.path_class.diffuse_share;
    if (push.round == 1u && is_second()) path.path_class.diffuse_share = diffuse_share;
    note_scattering(path, shading, factor, ended ? density : path.pdf, second_diffuse);
#endif
    // One BSDF sample stands against all candidates.
    if (candidates_at(first) != 0u && path.pdf > 0.0) path.pdf /= float(candidates_at(first));
}

// The path that a slot has, and what it met.
PathState take_path(ViewData view, PathKey key, uint slot, out WavefrontHit met) {
    if (push.round == 0u) {
        const uvec4 which = imageLoad(identity, ivec2(key.pixel));
        met = WavefrontHit(which.x, which.y, which.z);
        footprint = Footprint(RayCone(view.pixel_width, view.pixel_spread), 0.0, push.frame.follows != 0u ? kLobeStraight : 0u, 0u);
        return begin_path(view, key);
    }
    met = push.hits.v[slot];
    const LightPath kept = push.paths.v[slot];
    LightPathInside inside = kOutside;
    if (kLayers) inside = push.inside.v[slot];
    footprint = unpack_footprint(kept);
    return unpack_light_path(push.rays.v[slot], kept, inside);
}

VertexResult shade(uint slot) {
    const ViewData view = push.view.data;
    const PathKey key = path_key(view, push.control, slot);
    const uint pixel = key.pixel.y * view.width + key.pixel.x;
    WavefrontHit met;
    PathState path = take_path(view, key, slot, met);
    const PathClass before = path.path_class;
    const uint lobes = footprint.flags;
    FirstHit first;
    VertexResult vertex;
#ifdef REUSE
    const vec3 came_by = path.ray.direction_ws;
    const float came_with = path.pdf;
    const float of_roulette = begin_sharing(view, key, slot, path);
#endif
    if (met.instance_bits == kHitMiss) vertex = end_in_sky(view, path, first);
    else vertex = shade_vertex(view, key, Hit(met.instance_bits, met.geometry, met.primitive, 0u, 0.0), path, first);
    if (push.round != 0u) film_add(push.block, view, kFilmDebugRays, pixel, vec3(1.0));
    if (push.round == 0u || (lobes & kLobeFirst) != 0u) push.distances.v[pixel] = push.round == 0u ? 0u : pack_distance(vertex.t, before);
#ifdef REUSE
    path.radiance_scale /= of_roulette;
#endif
    PathClass of_arriving = before, of_cached = before, of_event = before;
#ifdef REUSE
    share_arriving(view, key, slot, met, came_by, came_with, vertex, of_arriving);
    share_cached(view, key, slot, of_cached);
#endif
    keep_arriving(view, slot, pixel, of_arriving, of_cached, lobes, vertex.arriving);
#ifdef REUSE
    if (vertex.event.exists) share_event(slot, vertex.event, of_event);
#endif
    if (vertex.event.exists) keep_event(slot, pixel, of_event, lobes, vertex.event);
    if (vertex.goes_on) {
        push.rays.v[slot] = pack_ray(path);
        push.paths.v[slot] = pack_light_path(path, footprint);
        if (kLayers) push.inside.v[slot] = pack_inside(path);
#ifdef REUSE
        keep_second(slot);
#endif
    }
    return vertex;
}

void main() {
    const uint i = invocation_index();
    bool asks = false, goes_on = false;
    uint slot = 0u;
    if (i < push.control.v.count[push.list]) {
        slot = push.lists.v[list_at(push.control, push.list, i)];
        const VertexResult vertex = shade(slot);
        asks = vertex.event.exists;
        goes_on = vertex.goes_on;
    }
    list_append(push.lists, push.control, kListRays, bin_if(goes_on), 1u, slot);
    const uint place = reserve(push.control, kListShadows, bin_if(asks), 1u);
    if (asks) push.shadow_list.v[place] = slot;
}
