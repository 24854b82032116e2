// What a light tile says of its samples, coarsely, and the numbers from which a sample is made again.
#ifndef PARHELION_LIGHTS_TILE_CODE_GLSL
#define PARHELION_LIGHTS_TILE_CODE_GLSL
#include "lib/log_code.glsl"
#include "lib/octahedral.glsl"
#include "scene/lights.glsl"
#include "shared/realtime.h"

// Four numbers of the sample at a place (tile * kTileSamples + number): which = 0 chooses the light, 1 the point on it.
vec4 tile_numbers(uint place, uint frame_index, uint seed, uint which) {
    const uint kTileSalt = 0x54494C45u;
    const uvec4 h = pcg4d(uvec4(place, frame_index, seed ^ kTileSalt, which));
    return vec4(uint_to_unit_float(h.x), uint_to_unit_float(h.y), uint_to_unit_float(h.z), uint_to_unit_float(h.w));
}

// How a sample looks from x: about its radiance over its density there, and that density.
struct TileView {
    vec3 wi;
    vec3 light;  // radiance over density per solid angle; of delta lights over probability
    float pdf;   // per solid angle
    bool is_delta;
};

// Never 0 where the sample itself would not be.
TileView view_tile_sample(TileSample t, vec3 x_ws) {
    TileView result;
    const uint kind = t.bits >> kTileKindShift;
    result.light = log_values(t.bits);
    result.is_delta = kind == kTileDeltaInfinite || kind == kTilePoint;
    result.pdf = 1.0 / t.inverse_pdf;
    result.wi = t.place_ws;
    if (kind == kTileInfinite || kind == kTileDeltaInfinite) return result;
    const vec3 to_light = t.place_ws - x_ws;
    const float distance_squared = max(dot(to_light, to_light), 1e-12);
    result.wi = to_light * inversesqrt(distance_squared);
    float geometry = 1.0 / distance_squared;
    if (kind != kTilePoint) {
        const float cosine = -dot(unpack_direction(t.normal), result.wi);
        geometry *= max(kind == kTileMeshBothSides ? abs(cosine) : cosine, 1e-3);
        result.pdf /= geometry;
    }
    result.light *= geometry;
    return result;
}

// One tile for 8x8 pixels, another one each frame.
uint tile_of(uvec2 pixel, uint frame_index, uint seed) {
    return pcg4d(uvec4(pixel / 8u, frame_index, seed)).x % kTileCount;
}
#endif
