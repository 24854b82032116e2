#version 460
// What the band's paths brought, as the frame's signals and path classes.
// Reads: view, control, summary, sums. Writes: diffuse, specular (demodulated), emission. Reads and writes: block (path classes).
#extension GL_GOOGLE_include_directive : require
#include "lib/packed_light.glsl"
#include "realtime/demodulate.glsl"
#include "scene/film.glsl"
#include "wavefront/bits.glsl"
#include "wavefront/linear.glsl"
#include "wavefront/pixels.glsl"
#include "wavefront/state.glsl"

layout(set = 1, binding = 0, rgba32ui) uniform readonly uimage2D summary;
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Light { PackedLight v[]; };
layout(push_constant, scalar) uniform Push {
    ViewBlock view;
    Control control;
    ClassSums sums;
    Light diffuse, specular, emission;
    FilmBlock block;
    float exposure;
} push;

void main() {
    const ViewData view = push.view.data;
    const uint slot = invocation_index();
    if (slot >= push.control.v.pixel_count) return;
    const uvec2 id = pixel_of(view, push.control.v.slice, slot);
    const uint pixel = id.y * view.width + id.x;
    const PathRadiance sums = unpack_classes(push.sums.v[slot]);
    const Demodulation by = demodulation(imageLoad(summary, ivec2(id)));
    push.diffuse.v[pixel] = pack_light((sums.direct_diffuse + sums.indirect_diffuse) * push.exposure / by.diffuse);
    push.specular.v[pixel] = pack_light((sums.direct_specular + sums.indirect_specular + sums.transmission) * push.exposure / by.specular);
    push.emission.v[pixel] = pack_light(sums.emission * push.exposure);
    film_add_path_classes(push.block, view, pixel, sums);
}
