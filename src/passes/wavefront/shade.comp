#version 460
// Shades vertices of one class of materials, or of all: what arrives there, which light it asks for, where the path goes on.
// Reads: scene, view, slots, hits, lists (a class or the rays). Reads and writes: control, shadow_list, rays, paths, extras, status,
// vertices, shadow_rays, splits. Writes: firsts (what is known of first surfaces). Documents 002, 003.
// variants: MISS EMITTER PLAIN RAY_CONES EMITTER+RAY_CONES PLAIN+RAY_CONES LAYERS MISS+LAYERS EMITTER+LAYERS PLAIN+LAYERS COATED+LAYERS TRANSMISSIVE+LAYERS LAYERS+RAY_CONES EMITTER+LAYERS+RAY_CONES PLAIN+LAYERS+RAY_CONES COATED+LAYERS+RAY_CONES TRANSMISSIVE+LAYERS+RAY_CONES
// optimised variants
#extension GL_GOOGLE_include_directive : require
#include "shared/wavefront.h"
#if defined(EMITTER)
#define ABSENT_MATERIAL_FLAGS (kMaterialTransmits | kMaterialThin | kMaterialCoated | kMaterialSheen)
#elif defined(PLAIN)
#define ABSENT_MATERIAL_FLAGS (kMaterialTransmits | kMaterialThin | kMaterialCoated | kMaterialSheen | kMaterialUnlit)
#elif defined(COATED)
#define ABSENT_MATERIAL_FLAGS (kMaterialTransmits | kMaterialThin | kMaterialUnlit)
#endif
#if defined(MISS) || defined(EMITTER) || defined(PLAIN) || defined(COATED) || defined(TRANSMISSIVE)
const uint kClassesHere = 1u;
#else
const uint kClassesHere = kClassCount;
#endif
#include "scene/vertex.glsl"
#include "wavefront/classes.glsl"
#include "wavefront/counts.glsl"
#include "wavefront/linear.glsl"
#include "wavefront/lists.glsl"
#include "wavefront/paths.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Hits { WavefrontHit v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer ShadowList { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) writeonly buffer ShadowRays { WavefrontShadowRay v[]; };
layout(push_constant, scalar) uniform Push {
    ViewBlock view;
    Control control;
    Lists lists;
    ShadowList shadow_list;
    Rays rays;
    Hits hits;
    Paths paths;
    Extras extras;
    Slots slots;
    Status status;
    Vertices vertices;
    ShadowRays shadow_rays;
    Splits splits;
    Firsts firsts;
    uint has_firsts;
    uint list;
    uint round, round_length;  // vertices of a slot since the last Connect, and until the next
} push;

VertexResult vertex_of(ViewData view, PathKey key, WavefrontHit met, inout PathState path, inout FirstHit first) {
#if defined(MISS)
    return end_in_sky(view, path, first);
#else
#if defined(EMITTER)
    view.max_bounces = 0u;  // nothing is scattered here
#elif !defined(PLAIN) && !defined(COATED) && !defined(TRANSMISSIVE)
    if (met.instance_bits == kHitMiss) return end_in_sky(view, path, first);
#endif
    return shade_vertex(view, key, Hit(met.instance_bits, met.geometry, met.primitive, 0u, 0.0), path, first);
#endif
}

// Keeps the light of the vertex by path class too.
void keep_split(uint slot, uint entry, PathClass before, PathState path, VertexResult vertex) {
    const uint carried = push.round_length * push.control.v.slot_count + slot;  // the path's diffuse share, from one vertex to the next
    const BsdfValue sampled = vertex.event.exists ? vertex.event.value : kNoBsdfValue;
    const vec3 share = push.splits.v[carried].diffuse_share;
    push.splits.v[entry] = WavefrontSplit(share, sampled.diffuse, sampled.specular, sampled.transmission);
    if (before.bounce == 0u && path.path_class.bounce == 1u) push.splits.v[carried].diffuse_share = path.path_class.diffuse_share;
}

// What the vertex leaves for Connect and Finalize.
void keep_vertex(uint number, uint entry, PathClass before, VertexResult vertex) {
    const uint bits = pack_bits(before) | kVertexExists | (vertex.event.exists ? kVertexEvent : 0u) | (vertex.goes_on ? 0u : kVertexEnds);
    const vec3 sampled = vertex.event.exists ? total(vertex.event.value) : vec3(0.0);
    push.vertices.v[entry] = WavefrontVertex(vertex.arriving, bits, sampled, number);
    if (!vertex.event.exists) return;
    const Ray ray = vertex.event.ray;
    push.shadow_rays.v[entry] = WavefrontShadowRay(ray.origin_ws, ray.t_max, ray.direction_ws, ray.alpha_key);
}

// True: what is known of the first surface is known now; every path has one such vertex.
bool tells_first_hit(PathClass before, PathState path, VertexResult vertex) {
    const bool seen_before = before.bounce != 0u || before.transmitted;
    const bool seen_later = vertex.goes_on && path.path_class.bounce == 0u && !path.path_class.transmitted;
    return !seen_before && !seen_later;
}

VertexResult shade(uint slot, WavefrontHit met, uint entry, out uint bounce) {
    const ViewData view = push.view.data;
    const WavefrontRay ray = push.rays.v[slot];
    const uint number = push.slots.v[slot].path;  // of the slice
    WavefrontExtra extra = kNoExtra;
    if (kHasExtra) extra = push.extras.v[slot];
    PathState path = unpack_path(ray, push.paths.v[slot], extra);
    const PathClass before = path.path_class;
    bounce = before.bounce;
    FirstHit first = FirstHit(vec3(0.0), vec3(0.0), vec3(0.0), 0.0);
    const VertexResult vertex = vertex_of(view, path_key(view, push.control, number), met, path, first);
    if (push.has_firsts != 0u && tells_first_hit(before, path, vertex)) push.firsts.v[number] = WavefrontFirst(first.albedo, first.normal_ws, first.emission, first.roughness);
    keep_vertex(number, entry, before, vertex);
    if (push.control.v.split != 0u) keep_split(slot, entry, before, path, vertex);
    if (vertex.goes_on) {
        push.rays.v[slot] = pack_ray(path);
        push.paths.v[slot] = WavefrontPath(path.throughput, path.pdf);
        if (kHasExtra) push.extras.v[slot] = pack_extra(path);
    }
    return vertex;
}

// Lists the entries whose shadow rays wait for Connect.
void ask(bool asks, uint entry) {
    const uint i = reserve(push.control, kListShadows, bin_if(asks), 1u);
    if (asks && has_room(push.control, kListShadows, push.control.v.shadow_capacity, i)) push.shadow_list.v[i] = entry;
}

void main() {
    begin_counts();
    const uint i = invocation_index();
    const bool lives = i < push.control.v.count[push.list];
    bool asks = false;
    uint entry = 0u, bounce = 0u, class_here = 0u;
    if (lives) {
        const uint slot = push.lists.v[list_at(push.control, push.list, i)];
        entry = push.round * push.control.v.slot_count + slot;
        const WavefrontHit met = push.hits.v[slot];
        const VertexResult vertex = shade(slot, met, entry, bounce);
        push.status.v[slot] = vertex.goes_on ? kSlotLives : kSlotFree;
        asks = vertex.event.exists;
        if (kClassesHere != 1u) class_here = class_of(met);
    }
    ask(asks, entry);
    count_vertex(push.control, lives, bounce, class_here, asks);
    end_counts(push.control, kClassesHere == 1u ? push.list - kListClasses : 0u);
}
