#version 460
// Sorts what Extend met into one list for each kernel of Shade.
// Reads: scene, hits. Reads and writes: control, lists (rays to classes).
// optimised variants
#extension GL_GOOGLE_include_directive : require
#include "wavefront/classes.glsl"
#include "wavefront/linear.glsl"
#include "wavefront/lists.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Hits { WavefrontHit v[]; };
layout(push_constant, scalar) uniform Push {
    Control control;
    Lists lists;
    Hits hits;
    uint only_plain;  // 1: the scene has no other materials
} push;

void main() {
    const uint i = invocation_index();
    const bool lives = i < push.control.v.count[kListRays];
    const uint slot = lives ? push.lists.v[list_at(push.control, kListRays, i)] : 0u;
    uint met = kNone;
    if (lives && push.only_plain != 0u) met = push.hits.v[slot].instance_bits == kHitMiss ? kClassMiss : kClassPlain;
    else if (lives) met = class_of(push.hits.v[slot]);
    list_append(push.lists, push.control, kListClasses, met, kClassCount, slot);
}
