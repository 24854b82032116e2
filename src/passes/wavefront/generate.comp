#version 460
// Begins the next path of slots that are free, at the camera; then lists all slots that have a ray. Going through the slots in order
// keeps neighbours together: their camera rays, and less so the others. A slot draws a few samples of a pixel (a visit), then takes
// the next visit that no slot has taken. Visits go across the picture, so that a slice ends with a few paths left, not with whole
// pixels; one begins when all samples of its pixel before it are in the film.
// Reads: scene, view, finished. Reads and writes: control, lists (rays), status, rays, paths, extras, slots.
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
    Finished finished;  // samples of the slice that are in the film, by pixel of it
} push;

// Pixels in strips of eight rows, along the columns: 64 that follow one another are a square.
uint pixel_of(ViewData view, Slice slice, uint index) {
    const uint strip = index / (8u * view.width), in_strip = index % (8u * view.width);
    const uint height = min(8u, slice.row_count - 8u * strip);
    return (slice.first_row + 8u * strip + in_strip % height) * view.width + in_strip / height;
}

// The next visit for every invocation that wants one: pixel of the slice and its first sample; kNoPixel where there is none left.
uvec2 take_visit(bool wanted) {
    const uint index = reserve(push.control, kCountVisits, bin_if(wanted), 1u);
    const uint pixels = push.control.v.pixel_count, first_sample = index / pixels * push.control.v.visit;
    return wanted && first_sample < push.control.v.slice.sample_count ? uvec2(index % pixels, first_sample) : uvec2(kNoPixel, 0u);
}

void begin_sample(uint slot, uint pixel, uint sample_offset) {
    const PathState path = begin_path(push.view.data, slot_key(push.view.data, push.control, pixel, sample_offset));
    push.rays.v[slot] = pack_ray(path, sample_offset);
    push.paths.v[slot] = WavefrontPath(path.throughput, path.pdf);
    if (kHasExtra) push.extras.v[slot] = pack_extra(path);
    push.slots.v[slot].pixel = pixel;
    push.status.v[slot] = kSlotLives;
}

// Begins the visit if it may; returns the slot's status.
uint begin_visit(uint slot, uint pixel_of_slice, uint first_sample) {
    uint status = kSlotRetires;
    if (pixel_of_slice != kNoPixel) {
        const uint pixel = pixel_of(push.view.data, push.control.v.slice, pixel_of_slice);
        if (push.finished.v[pixel] == first_sample) {
            begin_sample(slot, pixel, first_sample);
            return kSlotLives;
        }
        status = kSlotWaits;
        push.slots.v[slot].pixel = pixel_of_slice;
        push.rays.v[slot].bits = first_sample << kPathSampleShift;
    }
    push.status.v[slot] = status;
    return status;
}

void main() {
    const uint slot = invocation_index();
    const uint before = slot < push.control.v.slot_count ? push.status.v[slot] : kSlotRetires;
    const uint pixel = before == kSlotFree || before == kSlotWaits ? push.slots.v[slot].pixel : kNoPixel;
    const uint sample_offset = pixel != kNoPixel ? push.rays.v[slot].bits >> kPathSampleShift : 0u;
    const uint next_sample = sample_offset + 1u;
    const bool stays = before == kSlotFree && pixel != kNoPixel && next_sample % push.control.v.visit != 0u && next_sample < push.control.v.slice.sample_count;
    const uvec2 visit = take_visit(before == kSlotFree && !stays);
    uint status = before;
    if (stays) {
        begin_sample(slot, pixel, next_sample);
        status = kSlotLives;
    } else if (before == kSlotWaits) status = begin_visit(slot, pixel, sample_offset);
    else if (before == kSlotFree) status = begin_visit(slot, visit.x, visit.y);
    list_append(push.lists, push.control, kListRays, bin_if(status == kSlotLives && before != kSlotLives), 1u, slot);
    list_append(push.lists, push.control, kListRays, bin_if(before == kSlotLives), 1u, slot);
    reserve(push.control, kCountWaiting, bin_if(status == kSlotWaits), 1u);
}
