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
uint reservoir_at(ViewData view, uint pixel, uint kind, uint sets) { return is_indirect(kind) && sets == 2u ? view.width * view.height + pixel : pixel; }

void clear_reservoirs(Reservoirs reservoirs, ViewData view, uint pixel, uint sets) {
    for (uint i = 0u; i < sets; ++i) {
        const uint at = i * view.width * view.height + pixel;
        reservoirs.v[at].point.bits = 1u << 16;  // what finds nothing has looked, too
        reservoirs.v[at].weight = 0.0;
        reservoirs.v[at].target = 0.0;
    }
}

// Numbers of the choices, one after the other.
float offer_number(uvec2 pixel, uint frame_index, uint seed, uint round, uint which) {
    const uint kOfferSalt = 0x4F464652u;
    return uint_to_unit_float(pcg4d(uvec4(pixel.x | pixel.y << 16, frame_index, seed ^ kOfferSalt, round << 2 | which)).x);
}

// `weight`: luminance of what the sample brings, over the density with which it was found; `target`: not over it.
void offer(Reservoirs reservoirs, uint at, PackedSample point, float weight, float target, float u) {
    if (!(weight > 0.0)) return;
    const float sum = reservoirs.v[at].weight + weight;
    reservoirs.v[at].weight = sum;
    if (u * sum >= weight) return;
    reservoirs.v[at].target = target;
    reservoirs.v[at].point.reference = point.reference;
    reservoirs.v[at].point.number = point.number;
    reservoirs.v[at].point.place = point.place;
    reservoirs.v[at].point.bits = point.bits;
    reservoirs.v[at].point.direction = point.direction;
    reservoirs.v[at].point.radiance_low = point.radiance_low;
    reservoirs.v[at].point.radiance_high = point.radiance_high;
}
#endif
