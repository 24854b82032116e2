#version 460
// Holds each pixel's history against its neighbourhood in the fast one: what lies beyond is drawn back to it, for this frame and those to come.
// Then tells the spatial filter light's tone and how far it may be off, by the spread over time.
// The clamp after ReBLUR and ReLAX (Zhdan 2021; NVIDIA Real-time Denoisers).
// Reads: view, guide, state. Reads and writes: light (its history). Writes: toned light, to be filtered.
#extension GL_GOOGLE_include_directive : require
#include "lib/color.glsl"
#include "reconstruction/half_light.glsl"
#include "reconstruction/surfaces.glsl"
#include "reconstruction/tone.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ViewBlock { ViewData data; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Words { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer Pairs { uvec2 v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer Kept { uvec2 v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) writeonly buffer NewPairs { uvec2 v[]; };
layout(push_constant, scalar) uniform Push {
    ViewBlock view;
    Pairs guide;
    Words state;
    Kept diffuse, specular;
    NewPairs diffuse_out, specular_out;
    ReconstructionFrame frame;
} push;

// Of the fast histories around, diffuse and specular.
struct Around {
    vec2 mean, variance;  // of fast luminances
    float count;
};
Around look_around(ViewData view, ivec2 middle, uint id, vec3 normal) {
    const uint plane = view.width * view.height;
    vec2 sum = vec2(0.0), squares = vec2(0.0);
    float count = 0.0;
    for (int y = -2; y <= 2; ++y)
        for (int x = -2; x <= 2; ++x) {
            const ivec2 at = middle + ivec2(x, y);
            if (((x + y) & 1) != 0) continue;  // every other one tells enough
            // No branches: all loads are under way at once.
            const ivec2 there = clamp(at, ivec2(0), ivec2(view.width, view.height) - 1);
            const uint pixel = uint(there.y) * view.width + uint(there.x);
            const vec2 fast = unpackHalf2x16(push.state.v[kStateFast * plane + pixel]);
            const bool fits = push.state.v[kStateFrames * plane + pixel] >> 16 == id && there == at && dot(unpack_direction_24(push.guide.v[pixel].y >> 8), normal) >= 0.9;
            const float share = fits ? 1.0 : 0.0;
            sum += share * fast;
            squares += share * fast * fast;
            count += share;
        }
    const vec2 mean = sum / max(count, 1.0);
    return Around(mean, max(squares / max(count, 1.0) - mean * mean, vec2(0.0)), count);
}

// The history between its bounds.
vec4 settle(vec4 kept, float mean, float variance, float count, float frames) {
    const float l = luminance(kept.rgb), room = push.frame.clamp_width * sqrt(variance);
    if (push.frame.clamp_width > 0.0 && count > 4.0 && frames > float(push.frame.fast_history) && l > 0.0) kept.rgb *= clamp(l, mean - room, mean + room) / l;
    return kept;
}

// For the spatial filter: how far the mean of the frames' tones may be off. Few frames hardly tell how much they deviate.
Toned tell(vec4 light, float deviation, float frames) {
    const float kUnknown = 2.0;  // stops, of a single frame
    return Toned(light.rgb, light.a, sqrt((deviation * deviation + kUnknown * kUnknown * max(1.25 - 0.25 * frames, 0.0)) / frames));
}

void main() {
    const ViewData view = push.view.data;
    const uvec2 id = gl_GlobalInvocationID.xy;
    if (id.x >= view.width || id.y >= view.height) return;
    const uint pixel = id.y * view.width + id.x, state = push.state.v[kStateFrames * view.width * view.height + pixel];
    if (state >> 16 == 0u) {
        push.diffuse_out.v[pixel] = push.specular_out.v[pixel] = uvec2(0u);
        return;
    }
    const Around around = look_around(view, ivec2(id), state >> 16, unpack_guide(push.guide.v[pixel]).normal);
    const vec2 frames = max(vec2(state & 255u, state >> 8 & 255u) * 0.25, vec2(0.75));
    const vec2 deviations = unpackHalf2x16(push.state.v[kStateDeviations * view.width * view.height + pixel]);
    const vec4 diffuse = settle(unpack_half_light(push.diffuse.v[pixel]), around.mean.x, around.variance.x, around.count, frames.x);
    const vec4 specular = settle(unpack_half_light(push.specular.v[pixel]), around.mean.y, around.variance.y, around.count, frames.y);
    push.diffuse.v[pixel] = pack_half_light(diffuse);
    push.specular.v[pixel] = pack_half_light(specular);
    push.diffuse_out.v[pixel] = pack_toned(tell(diffuse, deviations.x, frames.x));
    push.specular_out.v[pixel] = pack_toned(tell(specular, deviations.y, frames.y));
}
