#version 460
// Adds what the vertices since the last Connect brought, slot by slot in the order of the path, and finished samples to the film: as
// the reference adds them, whichever slot and kernel they came through.
// Reads: view. Reads and writes: control, slots, vertices, splits, block (the film's running block), finished.
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
    Finished finished;
    uint round_length;
} push;

void add_by_class(ViewData view, uint entry, WavefrontVertex vertex) {
    const WavefrontSplit split_light = push.splits.v[entry];
    const PathClass path_class = unpack_class(vertex.bits, split_light.diffuse_share);
    PathRadiance radiance = make_path_radiance();
    add_arriving(radiance, path_class, vertex.arriving);
    if ((vertex.bits & kVertexEvent) != 0u)
        add_sampled(radiance, path_class, vertex.sampled, BsdfValue(split_light.diffuse, split_light.specular, split_light.transmission));
    film_add_path_classes(push.block, view, vertex.pixel, radiance);
}

void main() {
    const uint slot = invocation_index(), count = push.control.v.slot_count;
    if (slot >= count) return;
    const ViewData view = push.view.data;
    vec3 radiance = push.slots.v[slot].radiance;
    for (uint round = 0u; round < push.round_length; ++round) {
        const uint entry = round * count + slot;
        const WavefrontVertex vertex = push.vertices.v[entry];
        if ((vertex.bits & kVertexExists) == 0u) continue;
        push.vertices.v[entry].bits = 0u;
        radiance += vertex.arriving;
        if ((vertex.bits & kVertexEvent) != 0u) radiance += vertex.sampled;
        if (push.control.v.split != 0u) add_by_class(view, entry, vertex);
        if ((vertex.bits & kVertexEnds) == 0u) continue;
        film_add_beauty(push.block, view, vertex.pixel, radiance);
        push.finished.v[vertex.pixel] += 1u;
        radiance = vec3(0.0);
    }
    push.slots.v[slot].radiance = radiance;
}
