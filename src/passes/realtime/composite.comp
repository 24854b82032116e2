#version 460
// The picture of a frame from its signals: demodulated light times the surface's colours, and emission, as a sample of the film, in nits.
// Reads: view, summary, diffuse, specular, emission. Reads and writes: block.
#extension GL_GOOGLE_include_directive : require
#include "lib/packed_light.glsl"
#include "realtime/demodulate.glsl"
#include "scene/film.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 1, binding = 0, rgba32ui) uniform readonly uimage2D summary;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ViewBlock { ViewData data; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Light { PackedLight v[]; };
layout(push_constant, scalar) uniform Push {
    ViewBlock view;
    FilmBlock block;
    Light diffuse, specular, emission;
    float nits;  // 1 over the exposure that the signals are stored with
} push;

void main() {
    const ViewData view = push.view.data;
    const uvec2 id = gl_GlobalInvocationID.xy;
    if (id.x >= view.width || id.y >= view.height) return;
    const uint pixel = id.y * view.width + id.x;
    const Demodulation by = demodulation(imageLoad(summary, ivec2(id)));
    const vec3 light = unpack_light(push.diffuse.v[pixel]) * by.diffuse + unpack_light(push.specular.v[pixel]) * by.specular + unpack_light(push.emission.v[pixel]);
    film_add_beauty(push.block, view, pixel, light * push.nits);
}
