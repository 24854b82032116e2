#version 460
// Adds what the vertices since the last Connect brought, slot by slot in the order of the path, and finished samples to the film: as
// the reference adds them, whichever slot and kernel they came through.
// Reads: view. Reads and writes: control, slots, vertices, splits, class_sums, block (the film's running block), finished.
#extension GL_GOOGLE_include_directive : require
#include "scene/film.glsl"
#include "wavefront/bits.glsl"
#include "wavefront/linear.glsl"
#include "wavefront/state.glsl"

layout(push_constant, scalar) uniform Push {
    ViewBlock view;
    FilmBlock block;
    Control control;
    Slots slots;
    Vertices vertices;
    Splits splits;
    ClassSums class_sums;
    Finished finished;
    uint round_length;
} push;

// A sample's light by path class, from one round to the next.
PathRadiance kept_classes(uint slot) {
    const WavefrontClassSums kept = push.class_sums.v[slot];
    return PathRadiance(vec3(0.0), kept.emission, kept.direct_diffuse, kept.direct_specular, kept.indirect_diffuse, kept.indirect_specular, kept.transmission);
}
void keep_classes(uint slot, PathRadiance sums) {
    push.class_sums.v[slot] =
        WavefrontClassSums(sums.emission, sums.direct_diffuse, sums.direct_specular, sums.indirect_diffuse, sums.indirect_specular, sums.transmission);
}

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
    const ViewData view = push.view.data;
    const bool by_class = push.control.v.split != 0u;
    vec3 radiance = push.slots.v[slot].radiance;
    PathRadiance sums = make_path_radiance();
    if (by_class) sums = kept_classes(slot);
    for (uint round = 0u; round < push.round_length; ++round) {
        const uint entry = round * count + slot;
        const WavefrontVertex vertex = push.vertices.v[entry];
        if ((vertex.bits & kVertexExists) == 0u) continue;
        push.vertices.v[entry].bits = 0u;
        radiance += vertex.arriving;
        if ((vertex.bits & kVertexEvent) != 0u) radiance += vertex.sampled;
        if (by_class) add_by_class(sums, entry, vertex);
        if ((vertex.bits & kVertexEnds) == 0u) continue;
        film_add_beauty(push.block, view, vertex.pixel, radiance);
        push.finished.v[vertex.pixel] += 1u;
        radiance = vec3(0.0);
        if (!by_class) continue;
        film_add_path_classes(push.block, view, vertex.pixel, sums);
        sums = make_path_radiance();
    }
    push.slots.v[slot].radiance = radiance;
    if (by_class) keep_classes(slot, sums);
}
