#version 460
// Sorts the band's paths by the kernel of Shade that what they met is for. FIRST: all of them, by what their pixels' identities say.
// Reads: scene, view and identity (FIRST), or hits. Reads and writes: control, lists.
// variants: FIRST
// optimised variants
#extension GL_GOOGLE_include_directive : require
#include "shared/realtime.h"
#include "wavefront/classes.glsl"
#include "wavefront/linear.glsl"
#include "wavefront/lists.glsl"
#include "wavefront/pixels.glsl"

#ifdef FIRST
layout(set = 1, binding = 0, rgba32ui) uniform readonly uimage2D identity;
#endif
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Hits { WavefrontHit v[]; };
layout(push_constant, scalar) uniform Push {
#ifdef FIRST
    ViewBlock view;
#endif
    Control control;
    Lists lists;
#ifndef FIRST
    Hits hits;
#endif
    uint layers;  // 1: the scene has layered materials
} push;

uint kernel_for(WavefrontHit met) {
    if (push.layers == 0u) return met.instance_bits == kHitMiss ? kShadeRest : kShadePlain;
    const uint met_class = class_of(met);
    return met_class == kClassCoated || met_class == kClassTransmissive ? kShadeRest : kShadePlain;
}

void main() {
    const uint i = invocation_index();
    uint slot = i, kernel = kNone;
#ifdef FIRST
    if (i < push.control.v.pixel_count) {
        const uvec4 which = imageLoad(identity, ivec2(pixel_of(push.view.data, push.control.v.slice, slot)));
        kernel = kernel_for(WavefrontHit(which.x, which.y, which.z));
    }
#else
    if (i < push.control.v.count[kListRays]) {
        slot = push.lists.v[list_at(push.control, kListRays, i)];
        kernel = kernel_for(push.hits.v[slot]);
    }
#endif
    list_append(push.lists, push.control, kListClasses, kernel, kShadeKernels, slot);
}
