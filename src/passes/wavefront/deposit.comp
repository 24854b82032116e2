#version 460
// Adds the samples of a finished slice to the film's running block, each pixel's in their order, as the reference adds them.
// Reads: view, control, samples, firsts, sample_classes. Reads and writes: block.
#extension GL_GOOGLE_include_directive : require
#include "scene/film.glsl"
#include "wavefront/bits.glsl"
#include "wavefront/linear.glsl"
#include "wavefront/pixels.glsl"
#include "wavefront/state.glsl"

layout(push_constant, scalar) uniform Push {
    ViewBlock view;
    FilmBlock block;
    Control control;
    Samples samples;
    Firsts firsts;
    ClassSums sample_classes;
    uint has_firsts;
} push;

void main() {
    const uint index = invocation_index(), count = push.control.v.pixel_count;
    if (index >= count) return;
    const ViewData view = push.view.data;
    const uvec2 at = pixel_of(view, push.control.v.slice, index);
    const uint pixel = at.y * view.width + at.x;
    for (uint i = 0u; i < push.control.v.slice.sample_count; ++i) {
        const uint path = i * count + index;
        film_add_beauty(push.block, view, pixel, push.samples.v[path]);
        if (push.has_firsts != 0u) {
            const WavefrontFirst first = push.firsts.v[path];
            film_add_first_hit(push.block, view, pixel, FirstHit(first.albedo, first.normal_ws, first.emission, first.roughness));
        }
        if (push.control.v.split != 0u) film_add_path_classes(push.block, view, pixel, unpack_classes(push.sample_classes.v[path]));
    }
}
