// A pixel's reservoir and those of surfaces like its own around it become one. Whoever includes it says what is hidden:
//     bool is_seen(ViewData view, Shifted shifted, uint moment)
// Reads: scene, view, identity, depth, reservoirs. Writes: history (its own: what the pixel is lit by, and the next frame starts from).
#ifndef PARHELION_REUSE_SPATIAL_GLSL
#define PARHELION_REUSE_SPATIAL_GLSL
#include "reuse/reservoirs.glsl"

layout(set = 1, binding = 0, rgba32ui) uniform readonly uimage2D identity;
layout(set = 1, binding = 1, r32f) uniform readonly image2D depth;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Neighbours { PackedReservoir v[]; };
layout(push_constant, scalar) uniform Push {
    ViewBlock view;
    Neighbours reservoirs;
    Reservoirs history;
    ReuseFrame frame;
} push;

bool is_seen(ViewData view, Shifted shifted, uint moment);

// Where the middle of a pixel looks, at the depth of what it sees.
vec3 position_at(ViewData view, ivec2 at, float reversed) {
    const Ray ray = camera_ray(view.camera, vec2(at) + 0.5 + view.jitter, vec2(view.width, view.height), 0u);
    const float along = view.camera.orthographic != 0u ? 1.0 / reversed - 1.0 : kDepthNear / reversed;
    return ray.origin_ws + ray.direction_ws * (along / dot(ray.direction_ws, view.camera.forward_ws));
}

// A pixel around this one that sees a surface like its own; false: none of the first few does.
bool find_neighbour(ViewData view, uvec2 id, uvec4 which, uint index, out ivec2 found, out uvec4 which_there) {
    const uint kTries = 4u;
    const vec3 n = unpack_direction(which.w), p = position_at(view, ivec2(id), imageLoad(depth, ivec2(id)).x);
    for (uint i = 0u; i < kTries; ++i) {
        const vec4 u = reuse_numbers(view, id, push.frame, 16u + kTries * index + i);
        found = ivec2(floor(vec2(id) + 0.5 + push.frame.radius_px * sample_concentric_disk(u.xy)));
        if (found == ivec2(id) || any(lessThan(found, ivec2(0))) || any(greaterThanEqual(found, ivec2(view.width, view.height)))) continue;
        which_there = imageLoad(identity, found);
        if (which_there.x == kHitMiss) continue;
        if (are_similar(n, unpack_direction(which_there.w), p, position_at(view, found, imageLoad(depth, found).x), distance(p, view.camera.position_ws))) return true;
    }
    return false;
}

void reuse_around(uvec2 id) {
    const ViewData view = push.view.data;
    if (id.x >= view.width || id.y >= view.height) return;
    const uvec4 which = imageLoad(identity, ivec2(id));
    if (which.x == kHitMiss) return;
    const uint at = reservoir_at(view, push.frame, id);
    Reservoir own = unpack_reservoir(push.reservoirs.v[at]);
    for (uint i = 0u; i < push.frame.neighbours; ++i) {
        ivec2 found;
        uvec4 which_there;
        if (!find_neighbour(view, id, which, i, found, which_there)) continue;
        Reservoir other = unpack_reservoir(push.reservoirs.v[reservoir_at(view, push.frame, uvec2(found))]);
        other.point.flags &= ~kSampleSeen;
        // One loop, so that what is long is compiled once: the neighbour's sample here, the own one there.
        float targets[2];
        for (uint side = 0u; side < 2u; ++side) {
            const Receiver receiver = receiver_at(view, key_of(view, side == 0u ? id : uvec2(found), push.frame.frame_index), side == 0u ? which : which_there, bsdf_share(push.frame), kNow);
            const Shifted shifted = shift(view, side == 0u ? other.point : own.point, receiver, kNow, reuse_ray_key(view, id, push.frame, 2u + i));
            targets[side] = is_seen(view, shifted, kNow) ? target_of(shifted) : 0.0;
        }
        merge_reservoirs(own, other, targets[0], targets[1], reuse_numbers(view, id, push.frame, 1u + i).x);
    }
    store_reservoir(push.history, at, own);
}
#endif
