// Reservoirs of a view's pixels: where they lie, and what both passes of reuse know of a pixel's surface.
#ifndef PARHELION_REUSE_RESERVOIRS_GLSL
#define PARHELION_REUSE_RESERVOIRS_GLSL
#include "scene/shift.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ViewBlock { ViewData data; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Reservoirs { PackedReservoir v[]; };

uint reservoir_of(ViewData view, ReuseFrame frame, uvec2 pixel) { return reservoir_at(view.width * view.height, frame.set, pixel.y * view.width + pixel.x); }

void store_reservoir(Reservoirs reservoirs, uint at, Reservoir r) {
    const PackedReservoir p = pack_reservoir(r);
    STORE_SAMPLE(reservoirs.v[at].point, p.point)
    reservoirs.v[at].weight = p.weight;
    reservoirs.v[at].target = p.target;
}

PathKey key_of(ViewData view, uvec2 pixel, uint frame_index) { return PathKey(pixel, frame_index, view.seed); }

// The number by which the last frame's sample is taken or not.
float reuse_number(ViewData view, uvec2 pixel, ReuseFrame frame) {
    const uint kReuseSalt = 0x52455553u;
    return uint_to_unit_float(spread_number(pixel.yx, 0u, pcg4d(uvec4(0u, frame.frame_index, view.seed ^ kReuseSalt, frame.set)).x));
}

const float kLeastSimilarCosine = 0.9;

// Surfaces that may well be lit alike. The plane test is ReBLUR's (Zhdan 2021, "ReBLUR: A Hierarchical Recurrent Denoiser").
bool are_similar(vec3 n, vec3 other_n, vec3 p, vec3 other_p, float distance_to_camera) {
    const float kMostOff = 0.003;
    return dot(n, other_n) >= kLeastSimilarCosine && abs(dot(n, other_p - p)) <= kMostOff * distance_to_camera;
}
#endif
