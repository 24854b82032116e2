#version 460
// Lights a band's pixels by the samples that reuse/choose kept: a shadow ray for each, but for those that a ray of this frame has seen. Scenes of layered materials have
// two kernels: PLAIN+LAYERS where neither the surface nor the point that lights it has any.
// Reads: scene, view, identity, lists (a kernel's), reservoirs, chosen. Reads and writes: control and shadow_list (of shadow rays), sums, pending, block (path classes).
// Writes: shadow_rays.
// variants: LAYERS PLAIN+LAYERS
#extension GL_GOOGLE_include_directive : require
#ifdef PLAIN
#define ABSENT_MATERIAL_FLAGS (kMaterialTransmits | kMaterialThin | kMaterialCoated | kMaterialSheen)
#endif
#include "realtime/paths.glsl"
#include "scene/shift.glsl"
#include "wavefront/linear.glsl"
#include "wavefront/lists.glsl"

layout(set = 1, binding = 0, rgba32ui) uniform readonly uimage2D identity;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Reservoirs { PackedReservoir v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Chosen { ChosenSample v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer ShadowList { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) writeonly buffer ShadowRays { WavefrontShadowRay v[]; };
layout(push_constant, scalar) uniform Push {
    ViewBlock view;
    Control control;
    Lists lists;
    Reservoirs reservoirs;
    Chosen chosen;
    Sums sums;
    Pending pending;
    ShadowRays shadow_rays;
    ShadowList shadow_list;
    FilmBlock block;
    ReuseFrame frame;
    uint list;
} push;
#include "reuse/add_class.glsl"

// True: the pixel's light waits for its shadow ray.
bool light_pixel(uint slot) {
    const ViewData view = push.view.data;
    const uvec2 id = pixel_of(view, push.control.v.slice, slot);
    const uint pixel = id.y * view.width + id.x;
    const ChosenSample chosen = push.chosen.v[slot];
    const LightSampleRef y = unpack_sample(push.reservoirs.v[chosen.reservoir].point);
    const PathKey key = PathKey(id, push.frame.frame_index, view.seed);
    const Receiver here = receiver_at(view, key, imageLoad(identity, ivec2(id)), bsdf_share(push.frame.candidates), kNow);
    const Shifted brought = shift(view, y, here, kNow, sample_ray_key(key, y.kind));
    if (target_of(brought) <= 0.0) return false;
    const BsdfValue light = scale(brought.value, vec3(chosen.weight));
    const bool indirect = is_indirect(y.kind), of_partner = chosen.reservoir != reservoir_at(view.width * view.height, push.frame.set, pixel);
    // What a partner has is kept only if the exchange's ray came through. Of lights the exact one looks through panes, without saying how much they take; the other one stops there.
    const bool is_seen = of_partner || (y.flags & kSampleSeen) != 0u, may_lie_behind_panes = brought.passes && (scene.header.features & kScenePanes) != 0u;
    if (is_seen && (!may_lie_behind_panes || (of_partner && push.frame.keeps_offered != 0u))) {
        add_light(push.sums, slot, light.diffuse, light.specular);
        add_class(view, pixel, indirect, light);
        return false;
    }
    push.shadow_rays.v[slot] = WavefrontShadowRay(brought.ray.origin_ws, brought.ray.t_max, brought.ray.direction_ws, brought.ray.alpha_key);
    push.pending.v[slot] = LightPending(light.diffuse, pixel, light.specular, (indirect ? kLightIndirect : kLightDirect) | (brought.passes ? 0u : kLightStopsAtPanes));
    return true;
}

void main() {
    const uint i = invocation_index();
    bool waits = false;
    uint slot = 0u;
    if (i < push.control.v.count[push.list]) {
        slot = push.lists.v[list_at(push.control, push.list, i)];
        waits = light_pixel(slot);
    }
    const uint place = reserve(push.control, kListShadows, bin_if(waits), 1u);
    if (waits) push.shadow_list.v[place] = slot;
}
