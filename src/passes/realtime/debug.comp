#version 460
// Shows the world cache at what pixels see, as a path that arrives there in this frame would find it: a sample of the film shows one cell.
// Reads: scene, view, identity. Reads and writes: cache (looked at only), block.
// variants: LAYERS
#extension GL_GOOGLE_include_directive : require
#include "realtime/level_number.glsl"
#include "scene/begin_path.glsl"
#include "scene/cache.glsl"
#include "scene/film.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 1, binding = 0, rgba32ui) uniform readonly uimage2D identity;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ViewBlock { ViewData data; };
layout(push_constant, scalar) uniform Push {
    ViewBlock view;
    Cache cache;
    FilmBlock block;
    uint frame_index;
} push;

vec3 color_of(uint id) {
    const uint h = pcg_hash(id);
    return id == 0u ? vec3(0.0) : 0.1 + 0.9 * vec3(h & 255u, h >> 8 & 255u, h >> 16 & 255u) / 255.0;
}

void main() {
    const ViewData view = push.view.data;
    const uvec2 id = gl_GlobalInvocationID.xy;
    if (id.x >= view.width || id.y >= view.height) return;
    const uvec4 which = imageLoad(identity, ivec2(id));
    if (which.x == kHitMiss) return;
    const PathKey key = PathKey(id, push.frame_index, view.seed);
    const PathState path = begin_path(view, key);
    const Surface s = fetch_surface(Hit(which.x, which.y, which.z, 0u, 0.0), path.ray, path.cone);
    const float width = view.pixel_width + view.pixel_spread * s.t;
    const CacheView cell = cache_look(push.cache, cache_point(s, -path.ray.direction_ws, cache_footprint(push.cache, width, width), level_number(key, 0u)));
    const uint pixel = id.y * view.width + id.x;
    film_add(push.block, view, kFilmDebugCells, pixel, color_of(cell.id));
    film_add(push.block, view, kFilmDebugIrradiance, pixel, cell.irradiance / push.cache.v.exposure);
    film_add(push.block, view, kFilmDebugLevel, pixel, vec3(float(cell.level)));
    film_add(push.block, view, kFilmDebugCount, pixel, vec3(float(cell.count)));
    film_add(push.block, view, kFilmDebugAge, pixel, vec3(float(cell.age)));
    film_add(push.block, view, kFilmDebugLife, pixel, vec3(float(cell.life)));
}
