#version 460
// Empties the slots for a new slice.
// Reads: control. Writes: status, slots, vertices, class_sums.
#extension GL_GOOGLE_include_directive : require
#include "wavefront/linear.glsl"
#include "wavefront/state.glsl"

layout(push_constant, scalar) uniform Push {
    Control control;
    Status status;
    Slots slots;
    Vertices vertices;
    ClassSums class_sums;
    uint round_length;  // vertices of a slot between two Connects
} push;

void main() {
    const uint slot = invocation_index(), count = push.control.v.slot_count;
    if (slot >= count) return;
    push.slots.v[slot] = WavefrontSlot(vec3(0.0), 0u);
    push.status.v[slot] = kSlotFree;
    for (uint i = 0u; i < push.round_length; ++i) push.vertices.v[i * count + slot].bits = 0u;
    if (push.control.v.split != 0u) push.class_sums.v[slot] = WavefrontClassSums(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0));
}
