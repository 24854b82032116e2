#version 460
// Adds what the vertices since the last Connect brought, slot by slot in the order of the path, as the reference adds them, whichever
// kernel they came through; what finished paths brought goes to their places among the slice's samples.
// Reads: control, splits. Reads and writes: slots, vertices, class_sums. Writes: samples, sample_classes.
#extension GL_GOOGLE_include_directive : require
#include "wavefront/bits.glsl"
#include "wavefront/linear.glsl"
#include "wavefront/state.glsl"

layout(push_constant, scalar) uniform Push {
    Control control;
    Slots slots;
    Vertices vertices;
    Splits splits;
    ClassSums class_sums;
    Samples samples;
    ClassSums sample_classes;
    uint round_length;
} push;

void add_by_class(inout PathRadiance sums, uint entry, WavefrontVertex vertex) {
    const WavefrontSplit split_light = push.splits.v[entry];
    const PathClass path_class = unpack_class(vertex.bits, split_light.diffuse_share);
    add_arriving(sums, path_class, vertex.arriving);
    if ((vertex.bits & kVertexEvent) != 0u)
        add_sampled(sums, path_class, vertex.sampled, BsdfValue(split_light.diffuse, split_light.specular, split_light.transmission));
}

void main() {
    const uint slot = invocation_index(), count = push.control.v.slot_count;
    if (slot >= count) return;
    const bool by_class = push.control.v.split != 0u;
    vec3 radiance = push.slots.v[slot].radiance;
    PathRadiance sums = make_path_radiance();
    if (by_class) sums = unpack_classes(push.class_sums.v[slot]);
    for (uint round = 0u; round < push.round_length; ++round) {
        const uint entry = round * count + slot;
        const WavefrontVertex vertex = push.vertices.v[entry];
        if ((vertex.bits & kVertexExists) == 0u) continue;
        push.vertices.v[entry].bits = 0u;
        radiance += vertex.arriving;
        if ((vertex.bits & kVertexEvent) != 0u) radiance += vertex.sampled;
        if (by_class) add_by_class(sums, entry, vertex);
        if ((vertex.bits & kVertexEnds) == 0u) continue;
        push.samples.v[vertex.path] = radiance;
        radiance = vec3(0.0);
        if (!by_class) continue;
        push.sample_classes.v[vertex.path] = pack_classes(sums);
        sums = make_path_radiance();
    }
    push.slots.v[slot].radiance = radiance;
    if (by_class) push.class_sums.v[slot] = pack_classes(sums);
}
