#version 460
// What others want to know of a pixel's surface without shading it: similarity tests, guides, views. Document 000's G-buffer, with the
// geometric normal.
// Reads: scene, view. Reads and writes: identity, block (layers of what is seen first). Writes: summary, motion (previous minus current position,
// pixels), depth (reversed-Z).
// variants: LAYERS
#extension GL_GOOGLE_include_directive : require
#include "lib/octahedral.glsl"
#include "lib/rgb9e5.glsl"
#include "scene/begin_path.glsl"
#include "scene/film.glsl"
#include "scene/motion.glsl"
#include "scene/vertex.glsl"
#include "shared/realtime.h"

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

uint summary_flags(Surface s) {
    const bool transmits = kLayers && s.scattering.transmission > 0.0;
    return (s.front_facing ? kSummaryFrontFacing : 0u) | (transmits ? kSummaryTransmits : 0u) | (s.scattering.roughness < kDeltaRoughness ? kSummaryDelta : 0u);
}

float reversed_depth(Camera camera, vec3 position_ws) {
    const float distance = dot(position_ws - camera.position_ws, camera.forward_ws);
    return camera.orthographic != 0u ? 1.0 / (1.0 + distance) : min(kDepthNear / distance, 1.0);
}

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
    const BsdfParameters p = s.scattering;
    const float side = s.front_facing ? 1.0 : -1.0;
    const float f0 = (p.ior - 1.0) / (p.ior + 1.0);
    const float reflectance = min(sqrt(f0 * f0 * p.specular / 0.16), 1.0);  // as f0 = 0.16 reflectance^2 has it
    first = FirstHit(p.base_color, side * s.n_shading_ws, s.emission, p.roughness);
    film_add_first_hit(push.block, view, id.y * view.width + id.x, first);
    imageStore(identity, at, uvec4(which.xyz, pack_direction(side * s.n_geometric_ws)));
    imageStore(summary, at, uvec4(packUnorm4x8(vec4(pow(p.base_color, vec3(1.0 / 2.2)), p.roughness)), pack_rgb9e5(s.emission * push.exposure),
                                  packUnorm4x8(vec4(reflectance, p.metallic, 0.0, 0.0)), pack_direction_24(side * s.n_shading_ws) << 8 | summary_flags(s)));
    imageStore(motion, at, vec4(surface_motion(view, s), 0.0, 0.0));
    imageStore(depth, at, vec4(reversed_depth(view.camera, s.position_ws)));
}
