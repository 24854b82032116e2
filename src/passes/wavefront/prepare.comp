#version 460
// Turns the lists' counts into the sizes of the next kernels' work, and empties the lists that they will fill. One thread.
// Reads and writes: control, rays (of the film: path and shadow rays so far). Writes: sizes.
#extension GL_GOOGLE_include_directive : require
#include "wavefront/state.glsl"

layout(local_size_x = 1) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Sizes { WavefrontSize v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer RayCounts { uint v[]; };
layout(push_constant, scalar) uniform Push {
    Control control;
    Sizes sizes;
    RayCounts rays;
    uint steps;               // of shared/wavefront.h
    uint tracing_group, row;  // invocations of a group of the tracing kernels; most groups in one row
} push;

void set_size(uint size, uint list, uint group) {
    const uint groups = (push.control.v.count[list] + group - 1u) / group, x = min(groups, push.row);
    push.sizes.v[size] = WavefrontSize(x, x == 0u ? 1u : (groups + x - 1u) / x, 1u);
}

// 64 bits in two words.
void add_rays(uint kind, uint count) {
    const uint before = push.rays.v[2u * kind];
    push.rays.v[2u * kind] = before + count;
    if (before + count < before) push.rays.v[2u * kind + 1u] += 1u;
}

bool does(uint step) { return (push.steps & step) != 0u; }

void main() {
    if (does(kSizeOfRays)) {
        const uint count = push.control.v.count[kListRays];
        push.control.v.live = count;
        push.control.v.iterations += uint(count != 0u);
        add_rays(kRayPath, count);
        set_size(kListRays, kListRays, push.tracing_group);
        set_size(kSizeHits, kListRays, kWavefrontGroup);
    }
    if (does(kSizeOfClasses))
        for (uint i = 0u; i < kClassCount; ++i) set_size(kListClasses + i, kListClasses + i, kWavefrontGroup);
    if (does(kSizeOfShadows)) {
        push.control.v.count[kListShadows] = min(push.control.v.count[kListShadows], push.control.v.shadow_capacity);
        set_size(kListShadows, kListShadows, push.tracing_group);
    }
    if (does(kCountShadows)) add_rays(kRayShadow, push.control.v.count[kListShadows]);
    if (does(kEmptyRays)) push.control.v.count[kListRays] = 0u;
    if (does(kEmptyClasses))
        for (uint i = 0u; i < kClassCount; ++i) push.control.v.count[kListClasses + i] = 0u;
    if (does(kEmptyShadows)) push.control.v.count[kListShadows] = 0u;
}
