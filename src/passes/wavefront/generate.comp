#version 460
// Gives slots whose path is over the next sample of their pixel, after its last one the next pixel that no slot has taken, and begins
// that path at the camera; then lists all slots that have a ray. Going through the slots in order keeps neighbours together: their
// camera rays, and less so the others.
// Reads: scene, view. Reads and writes: control, lists (rays), status, rays, paths, extras, slots.
// variants: LAYERS RAY_CONES LAYERS+RAY_CONES
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

// Pixels in strips of eight rows, along the columns: 64 that follow one another are a square.
uint pixel_of(ViewData view, Slice slice, uint index) {
    const uint strip = index / (8u * view.width), in_strip = index % (8u * view.width);
    const uint height = min(8u, slice.row_count - 8u * strip);
    return (slice.first_row + 8u * strip + in_strip % height) * view.width + in_strip / height;
}

// The next pixel for every invocation that wants one, kNoPixel where there is none left.
uint take_pixel(bool wanted) {
    const uvec4 ballot = subgroupBallot(wanted);
    uint first = 0u;
    if (subgroupElect() && subgroupBallotBitCount(ballot) != 0u) first = atomicAdd(push.control.v.next_pixel, subgroupBallotBitCount(ballot));
    const uint index = subgroupBroadcastFirst(first) + subgroupBallotExclusiveBitCount(ballot);
    return wanted && index < push.control.v.pixel_count ? pixel_of(push.view.data, push.control.v.slice, index) : kNoPixel;
}

// Begins the slot's next path; false: there is none.
bool begin_next(uint slot, uint pixel, uint sample_offset) {
    if (pixel == kNoPixel) {
        push.status.v[slot] = kSlotRetires;
        return false;
    }
    const PathState path = begin_path(push.view.data, slot_key(push.view.data, push.control, pixel, sample_offset));
    push.rays.v[slot] = pack_ray(path, sample_offset);
    push.paths.v[slot] = WavefrontPath(path.throughput, path.pdf);
    if (kHasExtra) push.extras.v[slot] = pack_extra(path);
    push.slots.v[slot].pixel = pixel;
    return true;
}

void main() {
    const uint slot = invocation_index();
    const uint status = slot < push.control.v.slot_count ? push.status.v[slot] : kSlotRetires;
    const bool waits = status == kSlotWaits;
    uint pixel = waits ? push.slots.v[slot].pixel : kNoPixel;
    uint sample_offset = pixel == kNoPixel ? 0u : (push.rays.v[slot].bits >> kPathSampleShift) + 1u;
    const bool wants_pixel = waits && (pixel == kNoPixel || sample_offset == push.control.v.slice.sample_count);
    const uint next_pixel = take_pixel(wants_pixel);
    if (wants_pixel) {
        pixel = next_pixel;
        sample_offset = 0u;
    }
    const bool begins = waits && begin_next(slot, pixel, sample_offset);
    list_append(push.lists, push.control, kListRays, begins, slot);
    list_append(push.lists, push.control, kListRays, status == kSlotLives, slot);
}
