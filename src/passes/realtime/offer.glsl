// What a path's vertices offer to the pixel's reservoir. Light that may be shared goes there instead of to the path's sums; what is left of it
// stays the path's. One out of all that is offered is kept, in proportion to what it brings.
#ifndef PARHELION_REALTIME_OFFER_GLSL
#define PARHELION_REALTIME_OFFER_GLSL
#include "lib/color.glsl"
#include "lib/hash.glsl"
#include "lib/reservoir.glsl"
#include "shared/view.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Reservoirs { PackedReservoir v[]; };

// Indirect light has a set of its own where there are two.
uint reservoir_of(ViewData view, uint pixel, uint kind, uint sets) { return reservoir_at(view.width * view.height, is_indirect(kind) ? sets - 1u : 0u, pixel); }

// While samples are offered the place of the confidence holds 8 bits of the one number of [0, 1) by which all choices are made. Pixels and frames around
// have other ones (spread_number), so that among them samples are kept as often as is due, not only on average.
const uint kOfferNumberBits = 16u, kOfferNumberMask = 0xFFu << kOfferNumberBits;

void clear_reservoirs(Reservoirs reservoirs, ViewData view, uvec2 id, uint frame_index, uint sets) {
    const uint kFirstSalt = 0x46495253u;
    for (uint i = 0u; i < sets; ++i) {
        const uint at = reservoir_at(view.width * view.height, i, id.y * view.width + id.x);
        reservoirs.v[at].point.bits = spread_number(id, frame_index, hash_combine(view.seed ^ kFirstSalt, i)) >> 24 << kOfferNumberBits;
        reservoirs.v[at].weight = 0.0;
        reservoirs.v[at].target = 0.0;
    }
}

// What is behind those 8 bits, another one for each choice.
float offer_number(uvec2 pixel, uint frame_index, uint seed, uint round, uint which) {
    const uint kOfferSalt = 0x4F464652u;
    return uint_to_unit_float(pcg4d(uvec4(pixel.x | pixel.y << 16, frame_index, seed ^ kOfferSalt, round << 2 | which)).x);
}

// `weight`: luminance of what the sample brings, over the density with which it was found; `target`: not over it. What a choice leaves of the number
// is as even as it was: the next one is made by that.
void offer(Reservoirs reservoirs, uint at, PackedSample point, float weight, float target, float behind) {
    if (!(weight > 0.0)) return;
    const float sum = reservoirs.v[at].weight + weight, share = weight / sum;
    const uint bits = reservoirs.v[at].point.bits;
    const float u = min((float((bits & kOfferNumberMask) >> kOfferNumberBits) + behind) / 256.0, 0.9999999);  // never rounded up to 1
    const bool takes = u < share;
    const uint left = min(uint((takes ? u / share : (u - share) / (1.0 - share)) * 256.0), 255u) << kOfferNumberBits;
    reservoirs.v[at].weight = sum;
    if (takes) {
        reservoirs.v[at].target = target;
        STORE_SAMPLE(reservoirs.v[at].point, point)
    }
    reservoirs.v[at].point.bits = (takes ? point.bits : bits) & ~kOfferNumberMask | left;
}
#endif
