// The depth pyramid: of every square of 2^k x 2^k pixels the farthest depth, k = 1, 2, ... up to one square. In one buffer, level after level;
// its first word is the orthographic camera's far end (RasterCounts::far_bits) when it was made.
#ifndef PARHELION_PASSES_GBUFFER_DEPTH_PYRAMID_GLSL
#define PARHELION_PASSES_GBUFFER_DEPTH_PYRAMID_GLSL

uvec2 pyramid_size(uvec2 size, uint level) { return (size + (1u << level) - 1u) >> level; }

// Of the level's first word; levels begin at 1.
uint pyramid_offset(uvec2 size, uint level) {
    uint offset = 1u;
    for (uint k = 1u; k < level; ++k) offset += pyramid_size(size, k).x * pyramid_size(size, k).y;
    return offset;
}
#endif
