// The pixels that the kernel of plain materials gives up, and what it gives up on.
#ifndef PARHELION_REALTIME_LISTED_GLSL
#define PARHELION_REALTIME_LISTED_GLSL
#include "scene/lights.glsl"
#include "shared/realtime.h"

// The work size first, for vkCmdDispatchIndirect and vkCmdTraceRaysIndirectKHR.
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer PixelList {
    uint size[3];
    uint count;
    uint pixels[];
};

const uint kLayeredFlags = kMaterialTransmits | kMaterialThin | kMaterialCoated | kMaterialSheen;

bool is_layered_hit(Hit hit) { return (scene_flags(hit_instance(hit), hit.geometry) & kLayeredFlags) != 0u; }
bool is_layered_light(uint emitter) {
    if (emitter == kNone) return false;
    const Emitter e = scene_emitter(emitter);
    return e.kind == kEmitterMesh && (scene_geometry(e.geometry).flags & kLayeredFlags) != 0u;
}

// `group`: invocations of a work group of who draws the list.
void list_pixel(PixelList list, uint pixel, uint group) {
    const uint kRow = 1u << 15;  // groups of a row, below the 65,535 that every device takes
    const uint i = atomicAdd(list.count, 1u), at = i / group;
    list.pixels[i] = pixel;
    if (i % group != 0u) return;
    atomicMax(list.size[0], min(at + 1u, kRow));
    atomicMax(list.size[1], at / kRow + 1u);
}
#endif
