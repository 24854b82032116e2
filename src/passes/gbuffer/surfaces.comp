#version 460
// What others want to know of a pixel's surface without shading it: similarity tests, guides, views. Document 000's G-buffer, with the
// geometric normal.
// Reads: scene, view. Reads and writes: identity, block (layers of what is seen first). Writes: summary, motion (previous minus current position,
// pixels), depth (reversed-Z).
// variants: LAYERS
#extension GL_GOOGLE_include_directive : require
#include "gbuffer/summary.glsl"
#include "scene/begin_path.glsl"
#include "scene/film.glsl"
#include "scene/motion.glsl"
#include "scene/vertex.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 1, binding = 0, rgba32ui) uniform uimage2D identity;
layout(set = 1, binding = 1, rgba32ui) uniform writeonly uimage2D summary;
layout(set = 1, binding = 2, rg32f) uniform writeonly image2D motion;
layout(set = 1, binding = 3, r32f) uniform writeonly image2D depth;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ViewBlock { ViewData data; };
layout(push_constant, scalar) uniform Push {
    ViewBlock view;
    FilmBlock block;
    uint frame_index;
    float exposure;  // of the emission
} push;

void main() {
    const ViewData view = push.view.data;
    const uvec2 id = gl_GlobalInvocationID.xy;
    if (id.x >= view.width || id.y >= view.height) return;
    const ivec2 at = ivec2(id);
    const uvec4 which = imageLoad(identity, at);
    const PathState path = begin_path(view, PathKey(id, push.frame_index, view.seed));
    FirstHit first = FirstHit(vec3(0.0), vec3(0.0), vec3(0.0), 0.0);
    if (which.x == kHitMiss) {
        end_in_sky(view, path, first);
        film_add_first_hit(push.block, view, id.y * view.width + id.x, first);
        imageStore(summary, at, uvec4(0u));
        imageStore(motion, at, vec4(sky_motion(view, path.ray.direction_ws), 0.0, 0.0));
        imageStore(depth, at, vec4(0.0));
        return;
    }
    const Surface s = fetch_surface(Hit(which.x, which.y, which.z, 0u, 0.0), path.ray, path.cone);
    const float side = s.front_facing ? 1.0 : -1.0;
    const vec3 n_shading_ws = side * s.n_shading_ws;
    first = FirstHit(s.scattering.base_color, n_shading_ws, s.emission, s.scattering.roughness);
    film_add_first_hit(push.block, view, id.y * view.width + id.x, first);
    imageStore(identity, at, uvec4(which.xyz, pack_direction(side * s.n_geometric_ws)));
    imageStore(summary, at, summarise(s, n_shading_ws, vec3(1.0), surface_number(0u, s), push.exposure));
    imageStore(motion, at, vec4(surface_motion(view, s), 0.0, 0.0));
    imageStore(depth, at, vec4(reversed_depth(view.camera, s.position_ws)));
}
