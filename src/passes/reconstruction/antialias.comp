#version 460
// Temporal anti-aliasing, and upscaling where the picture has more pixels than were rendered: each frame's pixels look elsewhere through the
// picture's, whose histories add them up. Histories are looked for where the nearest surface around was, and drawn back to what the frame
// shows around. Karis 2014, "High-Quality Temporal Supersampling"; Salvi 2016, "An Excursion in Temporal Supersampling" (variance clipping);
// Jimenez 2016, "Filmic SMAA" (Catmull-Rom history); Yang, Liu, Salvi 2020, "A Survey of Temporal Antialiasing Techniques" (upscaling).
// Reads: view, motion, guide, colors, history. Writes: picture (the next frame's history). Reads and writes: block.
#extension GL_GOOGLE_include_directive : require
#include "reconstruction/cubic.glsl"
#include "reconstruction/half_light.glsl"
#include "lib/color.glsl"
#include "lib/hash.glsl"
#include "scene/film.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 1, binding = 0, rg32f) uniform readonly image2D motion;
layout(set = 1, binding = 1) uniform sampler2D history;
layout(set = 1, binding = 2, rgba16f) uniform writeonly image2D picture;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ViewBlock { ViewData data; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer Pairs { uvec2 v[]; };
layout(push_constant, scalar) uniform Push {
    ViewBlock view;
    Pairs guide, colors;
    FilmBlock block;
    uvec2 size;            // of the picture
    vec2 jitter;           // of this frame, rendered pixels
    float exposure_scale;  // the history times this is in this frame's exposure
    float nits;            // 1 over the exposure
    float frames;          // that a history is worth at most; 0: the frame's pixels are shown as they are
    float sharpness;       // 1 over the kernel's deviation, pixels of the picture
    float deviations;      // of the colours around that a history may lie off
    uint has_history, frame_index;
} push;

// Colours as they are compared: roots, as the history has them, luminance apart from the rest. Roots bring bright colours closer together, so
// that resampling does not spread lamps, and still let a pixel that a lamp's edge covers a ninth of be as bright as that.
vec3 to_compared(vec3 c) {
    return vec3(0.25 * c.r + 0.5 * c.g + 0.25 * c.b, 0.5 * (c.r - c.b), -0.25 * c.r + 0.5 * c.g - 0.25 * c.b);
}
vec3 from_compared(vec3 y) {
    const float t = y.x - y.z;
    const vec3 c = max(vec3(t + y.y, y.x + y.z, t - y.y), vec3(0.0));
    return c * c;
}

// What the frame shows around a point of the picture.
struct Frame {
    vec3 color;        // by the kernel
    float weight;      // of it: 1 for a pixel that looks just there
    vec3 mean, deviation;  // compared colours
    ivec2 nearest;     // pixel of the nearest surface
};
Frame look(ViewData view, vec2 at_px, vec2 ratio) {
    const ivec2 middle = ivec2(floor(at_px));
    Frame f = Frame(vec3(0.0), 0.0, vec3(0.0), vec3(0.0), middle);
    float nearest = uintBitsToFloat(0x7F800000u), count = 0.0;
    for (int i = 0; i < 9; ++i) {
        const ivec2 at = middle + ivec2(i % 3, i / 3) - 1;
        if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, ivec2(view.width, view.height)))) continue;
        const uint pixel = uint(at.y) * view.width + uint(at.x);
        const vec3 color = unpack_half_light(push.colors.v[pixel]).rgb, compared = to_compared(sqrt(color));
        const vec2 off = (vec2(at) + 0.5 + push.jitter - at_px) * ratio * push.sharpness;
        const float weight = exp(-0.5 * dot(off, off)), depth = uintBitsToFloat(push.guide.v[pixel].x);
        f.color += weight * color;
        f.weight += weight;
        f.mean += compared;
        f.deviation += compared * compared;
        count += 1.0;
        if (depth < nearest) {
            nearest = depth;
            f.nearest = at;
        }
    }
    f.color /= max(f.weight, 1e-6);
    f.mean /= count;
    f.deviation = sqrt(max(f.deviation / count - f.mean * f.mean, vec3(0.0)));
    return f;
}

// Catmull and Rom 1974 over the 16 texels around, without the corners, by five bilinear taps.
vec4 read_history(vec2 at_px, vec2 size) {
    const vec2 base = floor(at_px - 0.5) + 0.5, f = at_px - base;
    const vec4 wx = catmull_rom(f.x), wy = catmull_rom(f.y);
    const vec2 w0 = vec2(wx[0], wy[0]), w1 = vec2(wx[1], wy[1]), w2 = vec2(wx[2], wy[2]), w3 = vec2(wx[3], wy[3]);
    const vec2 w12 = w1 + w2, at0 = (base - 1.0) / size, at12 = (base + w2 / w12) / size, at3 = (base + 2.0) / size;
    vec4 sum = textureLod(history, at12, 0.0) * (w12.x * w12.y);
    float weight = w12.x * w12.y;
    const vec3 sides[4] = vec3[](vec3(at12.x, at0.y, w12.x * w0.y), vec3(at0.x, at12.y, w0.x * w12.y), vec3(at3.x, at12.y, w3.x * w12.y), vec3(at12.x, at3.y, w12.x * w3.y));
    for (int i = 0; i < 4; ++i) {
        sum += textureLod(history, sides[i].xy, 0.0) * sides[i].z;
        weight += sides[i].z;
    }
    return max(sum / weight, vec4(0.0));
}

// Towards the middle of the box of colours until it lies in it. `kept`: the share of the way that is left.
vec3 clip(vec3 compared, vec3 mean, vec3 room, out float kept) {
    const vec3 off = compared - mean, share = abs(off) / max(room, vec3(1e-5));
    const float most = max_component(share);
    kept = most > 1.0 ? 1.0 / most : 1.0;
    return mean + off * kept;
}

void main() {
    const ViewData view = push.view.data;
    const uvec2 id = gl_GlobalInvocationID.xy;
    if (id.x >= push.size.x || id.y >= push.size.y) return;
    const uint pixel = id.y * push.size.x + id.x;
    const vec2 ratio = vec2(push.size) / vec2(view.width, view.height), at_px = (vec2(id) + 0.5) / ratio;
    vec3 color;
    if (push.frames <= 0.0) {
        const ivec2 at = ivec2(at_px);
        color = unpack_half_light(push.colors.v[uint(at.y) * view.width + uint(at.x)]).rgb;
        imageStore(picture, ivec2(id), vec4(sqrt(color), 0.0));
    } else {
        const Frame f = look(view, at_px, ratio);
        color = f.color;
        float frames = f.weight;
        const vec2 moved_px = imageLoad(motion, f.nearest).xy * ratio, before_px = vec2(id) + 0.5 + moved_px;
        const bool inside = all(greaterThan(before_px, vec2(0.0))) && all(lessThan(before_px, vec2(push.size)));
        if (push.has_history != 0u && inside) {
            const vec4 before = read_history(before_px, vec2(push.size));
            float kept;
            // What stands still may lie off three times as far: a lamp's edge that few frames see must stay in the mean of them.
            const float room = push.deviations * mix(3.0, 1.0, min(2.0 * length(moved_px), 1.0));
            const vec3 root = before.rgb * sqrt(push.exposure_scale), held = clip(to_compared(root), f.mean, f.deviation * room, kept);
            const vec3 past = kept < 1.0 ? from_compared(held) : root * root;
            frames = min(before.a * kept + f.weight, push.frames);
            color = mix(past, f.color, clamp(f.weight / frames, 0.0, 1.0));
        }
        const uvec4 random = pcg4d(uvec4(id, push.frame_index, 0x54414131u));
        const vec3 root = sqrt(color);
        imageStore(picture, ivec2(id), vec4(dither_half(root.r, random.x), dither_half(root.g, random.y), dither_half(root.b, random.z), frames));
    }
    film_add_beauty(push.block, view, pixel, color * push.nits);
}
