#version 460
// What the band's paths brought, as the frame's signals.
// Reads: view, control, summary, sums. Writes: diffuse, specular (demodulated). ADD: to what is there.
// variants: ADD
#extension GL_GOOGLE_include_directive : require
#include "lib/packed_light.glsl"
#include "realtime/demodulate.glsl"
#include "shared/realtime.h"
#include "wavefront/linear.glsl"
#include "wavefront/pixels.glsl"
#include "wavefront/state.glsl"

layout(set = 1, binding = 0, rgba32ui) uniform readonly uimage2D summary;
#ifdef ADD
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Light { PackedLight v[]; };
#else
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Light { PackedLight v[]; };
#endif
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer Sums { LightSums v[]; };
layout(push_constant, scalar) uniform Push {
    ViewBlock view;
    Control control;
    Sums sums;
    Light diffuse, specular;
    float exposure;
} push;

void main() {
    const ViewData view = push.view.data;
    const uint slot = invocation_index();
    if (slot >= push.control.v.pixel_count) return;
    const uvec2 id = pixel_of(view, push.control.v.slice, slot);
    const uint pixel = id.y * view.width + id.x;
    const LightSums sums = push.sums.v[slot];
    const Demodulation by = demodulation(imageLoad(summary, ivec2(id)));
    vec3 diffuse = sums.diffuse * push.exposure / by.diffuse, specular = sums.specular * push.exposure / by.specular;
#ifdef ADD
    diffuse += unpack_light(push.diffuse.v[pixel]);
    specular += unpack_light(push.specular.v[pixel]);
#endif
    push.diffuse.v[pixel] = pack_light(diffuse);
    push.specular.v[pixel] = pack_light(specular);
}
