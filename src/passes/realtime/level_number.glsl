// The number that picks the level of the cell which a vertex of a path asks: between two levels one of them, another in each frame.
#ifndef PARHELION_REALTIME_LEVEL_NUMBER_GLSL
#define PARHELION_REALTIME_LEVEL_NUMBER_GLSL
#include "scene/path_state.glsl"

float level_number(PathKey key, uint bounce) {
    const uint kCacheSalt = 0x43414348u;
    return uint_to_unit_float(hash_combine(alpha_key(key, bounce, kRayPath), kCacheSalt));
}
#endif
