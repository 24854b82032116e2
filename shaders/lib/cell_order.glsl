// The order of a grid's cells along a Z-curve (Morton 1966): neighbours in it are neighbours in both directions, so that numbers
// which are evenly spread in [0, 1) choose cells which are evenly spread over the grid. Also compiled as C++ (shared/functions.h).
#ifndef PARHELION_LIB_CELL_ORDER_GLSL
#define PARHELION_LIB_CELL_ORDER_GLSL
#include "shared/functions.h"
SHARED_BEGIN

// Puts a zero before each of the low 16 bits, and takes them away again.
SHARED_FN uint spread_bits(uint v) {
    v &= 0xFFFFu;
    v = (v | (v << 8)) & 0x00FF00FFu;
    v = (v | (v << 4)) & 0x0F0F0F0Fu;
    v = (v | (v << 2)) & 0x33333333u;
    return (v | (v << 1)) & 0x55555555u;
}
SHARED_FN uint gather_bits(uint v) {
    v &= 0x55555555u;
    v = (v | (v >> 1)) & 0x33333333u;
    v = (v | (v >> 2)) & 0x0F0F0F0Fu;
    v = (v | (v >> 4)) & 0x00FF00FFu;
    return (v | (v >> 8)) & 0xFFFFu;
}

// Place of a cell of a grid of width x height, powers of two of at most 2^15: squares in a row along the longer side.
SHARED_FN uint cell_place(uvec2 cell, uvec2 size) {
    const uint side = min(size.x, size.y), within = side - 1u;
    return spread_bits(cell.x & within) + 2u * spread_bits(cell.y & within) + ((cell.x | cell.y) & ~within) * side;
}
SHARED_FN uvec2 cell_at(uint place, uvec2 size) {
    const uint side = min(size.x, size.y), square = place / (side * side), within = place % (side * side);
    const uint along = square * side;
    return uvec2(gather_bits(within) + (size.x > size.y ? along : 0u), gather_bits(within >> 1) + (size.y > size.x ? along : 0u));
}

SHARED_END
#endif
