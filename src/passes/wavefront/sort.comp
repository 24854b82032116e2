#version 460
// Sorts what Extend met into one list for each kernel of Shade.
// Reads: scene, hits. Reads and writes: control, lists (rays to classes).
#extension GL_GOOGLE_include_directive : require
#include "wavefront/classes.glsl"
#include "wavefront/linear.glsl"
#include "wavefront/lists.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Hits { WavefrontHit v[]; };
layout(push_constant, scalar) uniform Push {
    Control control;
    Lists lists;
    Hits hits;
    uint classes;  // bit c: the scene has materials of class c
} push;

void main() {
    const uint i = invocation_index();
    const bool lives = i < push.control.v.count[kListRays];
    const uint slot = lives ? push.lists.v[list_at(push.control, kListRays, i)] : 0u;
    const uint met = lives ? class_of(push.hits.v[slot]) : kNone;
    for (uint c = 0u; c < kClassCount; ++c)
        if ((push.classes >> c & 1u) != 0u) list_append(push.lists, push.control, kListClasses + c, met == c, slot);
}
