#version 460
// Begins the next path of the slice in slots that are free, at the camera; then lists all slots that have a ray. Going through the
// slots in order keeps neighbours together: their camera rays, and less so the others. Paths go across the picture, so that a slice
// ends with a few of them left, not with whole pixels.
// Reads: scene, view. Reads and writes: control, lists (rays), status, rays, paths, extras, slots.
// variants: LAYERS RAY_CONES LAYERS+RAY_CONES
// optimised variants
#extension GL_GOOGLE_include_directive : require
#include "scene/begin_path.glsl"
#include "wavefront/linear.glsl"
#include "wavefront/lists.glsl"
#include "wavefront/paths.glsl"

layout(push_constant, scalar) uniform Push {
    ViewBlock view;
    Control control;
    Lists lists;
    Rays rays;
    Paths paths;
    Extras extras;
    Slots slots;
    Status status;
} push;

// The slot's status.
uint begin_next(uint slot, uint number) {
    if (number >= push.control.v.pixel_count * push.control.v.slice.sample_count) return kSlotRetires;
    const PathState path = begin_path(push.view.data, path_key(push.view.data, push.control, number));
    push.rays.v[slot] = pack_ray(path);
    push.paths.v[slot] = WavefrontPath(path.throughput, path.pdf);
    if (kHasExtra) push.extras.v[slot] = pack_extra(path);
    push.slots.v[slot].path = number;
    return kSlotLives;
}

void main() {
    const uint slot = invocation_index();
    const uint before = slot < push.control.v.slot_count ? push.status.v[slot] : kSlotRetires;
    const uint number = reserve(push.control, kCountPaths, bin_if(before == kSlotFree), 1u);
    uint status = before;
    if (before == kSlotFree) push.status.v[slot] = status = begin_next(slot, number);
    list_append(push.lists, push.control, kListRays, bin_if(status == kSlotLives && before != kSlotLives), 1u, slot);
    list_append(push.lists, push.control, kListRays, bin_if(before == kSlotLives), 1u, slot);
}
