#version 460
// What the band's paths brought, as the frame's signals.
// Reads: view, control, summary, sums. Writes: diffuse, specular (demodulated). ADD: to what is there. OFFERED: and beside it what they were offered.
// variants: ADD OFFERED
#extension GL_GOOGLE_include_directive : require
#include "lib/packed_light.glsl"
#include "realtime/demodulate.glsl"
#ifdef OFFERED
#include "realtime/offered.glsl"
#endif
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
#ifdef OFFERED
    Sums offered;
#endif
    float exposure;
#ifdef OFFERED
    uint frame_index;
#endif
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
#ifdef OFFERED
    const uint kOfferedSalt = 0x4F464445u;
    const LightSums offered = push.offered.v[slot];
    const uvec4 random = pcg4d(uvec4(pixel, push.frame_index, view.seed ^ kOfferedSalt, 0u));
    push.diffuse.v[pixel] = pack_parts(diffuse, offered.diffuse * push.exposure / by.diffuse, random);
    push.specular.v[pixel] = pack_parts(specular, offered.specular * push.exposure / by.specular, random.wzyx * 0x9E3779B9u);
#else
    push.diffuse.v[pixel] = pack_light(diffuse);
    push.specular.v[pixel] = pack_light(specular);
#endif
}
