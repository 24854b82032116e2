#version 460
// Lights a band's pixels by their reservoirs' samples: a shadow ray for each, but for those that a ray of this frame has seen.
// Reads: scene, view, identity, reservoirs. Reads and writes: control and shadow_list (of shadow rays), sums, pending, block (path classes).
// Writes: shadow_rays.
// variants: LAYERS
#extension GL_GOOGLE_include_directive : require
#include "realtime/paths.glsl"
#include "scene/shift.glsl"
#include "wavefront/linear.glsl"
#include "wavefront/lists.glsl"

layout(set = 1, binding = 0, rgba32ui) uniform readonly uimage2D identity;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Reservoirs { PackedReservoir v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer ShadowList { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) writeonly buffer ShadowRays { WavefrontShadowRay v[]; };
layout(push_constant, scalar) uniform Push {
    ViewBlock view;
    Control control;
    Reservoirs reservoirs;
    Sums sums;
    Pending pending;
    ShadowRays shadow_rays;
    ShadowList shadow_list;
    FilmBlock block;
    ReuseFrame frame;
} push;

// Without a ray.
void add_seen(ViewData view, uint slot, uint pixel, bool indirect, BsdfValue light) {
    add_light(push.sums, slot, light.diffuse, light.specular);
    PathRadiance by_class = make_path_radiance();
    if (indirect) {
        by_class.indirect_diffuse = light.diffuse;
        by_class.indirect_specular = light.specular;
    } else add_sampled(by_class, PathClass(0u, false, vec3(0.0)), total(light), light);
    film_add_path_classes(push.block, view, pixel, by_class);
}

// True: the pixel's light waits for its shadow ray.
bool light_pixel(uint slot) {
    const ViewData view = push.view.data;
    const uvec2 id = pixel_of(view, push.control.v.slice, slot);
    const uint pixel = id.y * view.width + id.x;
    if (push.frame.set == 0u) push.sums.v[slot] = LightSums(vec3(0.0), vec3(0.0));
    const uvec4 which = imageLoad(identity, ivec2(id));
    if (which.x == kHitMiss) return false;
    const Reservoir own = unpack_reservoir(push.reservoirs.v[push.frame.set * view.width * view.height + pixel]);
    if (own.point.kind == kSampleNone || own.weight <= 0.0) return false;
    const uint kAfterReuse = 0x20000u;
    const PathKey key = PathKey(id, push.frame.frame_index, view.seed);
    const Receiver here = receiver_at(view, key, which, push.frame.candidates == 0u ? 1.0 : 1.0 / float(push.frame.candidates), kNow);
    const Shifted brought = shift(view, own.point, here, kNow, alpha_key(key, kAfterReuse + push.frame.set, kRayShadow));
    if (target_of(brought) <= 0.0) return false;
    const BsdfValue light = scale(brought.value, vec3(own.weight));
    const bool indirect = is_indirect(own.point.kind);
    if ((own.point.flags & kSampleSeen) != 0u && (scene.header.features & kScenePanes) == 0u) {
        add_seen(view, slot, pixel, indirect, light);
        return false;
    }
    push.shadow_rays.v[slot] = WavefrontShadowRay(brought.ray.origin_ws, brought.ray.t_max, brought.ray.direction_ws, brought.ray.alpha_key);
    push.pending.v[slot] = LightPending(light.diffuse, pixel, light.specular, (indirect ? kLightIndirect : kLightDirect) | (brought.passes ? 0u : kLightStopsAtPanes));
    return true;
}

void main() {
    const uint slot = invocation_index();
    const bool waits = slot < push.control.v.pixel_count && light_pixel(slot);
    const uint place = reserve(push.control, kListShadows, bin_if(waits), 1u);
    if (waits) push.shadow_list.v[place] = slot;
}
