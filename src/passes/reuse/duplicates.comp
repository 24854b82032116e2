#version 460
// Shows how many of the pixels around, 7x7, go into the next frame with the sample that this one goes with: what frames would repeat of each other.
// Reads: view, reservoirs. Reads and writes: block.
#extension GL_GOOGLE_include_directive : require
#include "lib/reservoir.glsl"
#include "scene/film.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ViewBlock { ViewData data; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Reservoirs { PackedReservoir v[]; };
layout(push_constant, scalar) uniform Push {
    ViewBlock view;
    Reservoirs reservoirs;
    FilmBlock block;
    uint set;
} push;

bool is_same(PackedSample a, PackedSample b) {
    return a.reference == b.reference && a.number == b.number && a.place == b.place && ((a.bits ^ b.bits) >> 24 & 7u) == 0u;
}

void main() {
    const int kAround = 3;
    const ViewData view = push.view.data;
    const ivec2 id = ivec2(gl_GlobalInvocationID.xy), size = ivec2(view.width, view.height);
    if (any(greaterThanEqual(id, size))) return;
    const uint pixels = view.width * view.height, pixel = uint(id.y * size.x + id.x);
    const PackedSample own = push.reservoirs.v[reservoir_at(pixels, push.set, pixel)].point;
    if ((own.bits >> 24 & 7u) == kSampleNone) return;
    const ivec2 first = max(id - kAround, ivec2(0)), last = min(id + kAround, size - 1);
    uint same = 0u;
    for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x) same += uint(is_same(own, push.reservoirs.v[reservoir_at(pixels, push.set, uint(y * size.x + x))].point));
    film_add(push.block, view, kFilmDebugDuplicates, pixel, vec3(float(same - 1u)));
}
