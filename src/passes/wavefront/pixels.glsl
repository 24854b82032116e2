// The order of a slice's pixels.
#ifndef PARHELION_WAVEFRONT_PIXELS_GLSL
#define PARHELION_WAVEFRONT_PIXELS_GLSL
#include "shared/view.h"
#include "shared/wavefront.h"

// In strips of eight rows, along the columns: 64 that follow one another are a square.
uvec2 pixel_of(ViewData view, Slice slice, uint index) {
    const uint strip = index / (8u * view.width), in_strip = index % (8u * view.width);
    const uint height = min(8u, slice.row_count - 8u * strip);
    return uvec2(in_strip / height, slice.first_row + 8u * strip + in_strip % height);
}
#endif
