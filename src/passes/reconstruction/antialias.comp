#version 460
// Temporal anti-aliasing, and upscaling where the picture has more pixels than were rendered: each frame's pixels look elsewhere through the
// picture's, whose histories add them up, and are looked for where the nearest surface around was. A history that does not fit what the frame
// shows around is drawn back to it; where only details are missing, which one frame's few rays may miss, it stays for some frames.
// Karis 2014, "High-Quality Temporal Supersampling"; Salvi 2016, "An Excursion in Temporal Supersampling" (variance clipping); Jimenez 2016,
// "Filmic SMAA" (Catmull-Rom history); Yang, Liu, Salvi 2020, "A Survey of Temporal Antialiasing Techniques" (upscaling: weights by the
// distance to the picture's pixel, which add up over time).
// Reads: view, motion, guide, state, colors, history. Writes: picture (the next frame's history). Reads and writes: block.
#extension GL_GOOGLE_include_directive : require
#include "reconstruction/compared.glsl"
#include "reconstruction/cubic.glsl"
#include "reconstruction/half_light.glsl"
#include "lib/hash.glsl"
#include "scene/film.glsl"
#include "shared/reconstruction.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 1, binding = 0, rg32f) uniform readonly image2D motion;
layout(set = 1, binding = 1) uniform sampler2D history;
layout(set = 1, binding = 2, rgba16f) uniform writeonly image2D picture;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ViewBlock { ViewData data; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Words { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer Pairs { uvec2 v[]; };
layout(push_constant, scalar) uniform Push {
    ViewBlock view;
    Pairs guide, colors;
    Words state;
    FilmBlock block;
    uvec2 rendered;        // pixels of the frame; the view is the picture's
    vec2 jitter;           // of this frame, rendered pixels
    float exposure_scale;  // the history times this is in this frame's exposure
    float nits;            // 1 over the exposure
    float frames;          // that a history is worth at most; 0: the frame's pixels are shown as they are
    float sharpness;       // 1 over the kernel's deviation, pixels
    float deviations;      // of the colours around that a history may lie off
    uint has_history, frame_index;
} push;

const float kMovingShare = 0.25;  // of `frames`, where the picture moves: every frame's resampling blurs a little
const float kMissesStill = 12.0;          // frames in a row that may miss a detail before it is gone, where it stands still
const float kAlike = 0.6, kUnlike = 0.9;  // difference of two neighbourhoods' means over their deviations: only details differ; more than those
const float kSameShare = 0.004, kSameMeanShare = 0.02;  // of the mean root that a history, and its neighbourhood's mean, may lie off where no colour deviates
const float kSpatial = 0.05, kSure = 0.3;  // what the frame's pixels around are worth for a pixel without history; with one of so many frames nothing

uint rendered_pixel(ivec2 at) { return uint(at.y) * push.rendered.x + uint(at.x); }
bool is_rendered(ivec2 at) { return all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, ivec2(push.rendered))); }

// Its surface was nowhere in the last frame, or its light has changed so fast that no history is worth anything.
bool is_fresh(ivec2 at) {
    const uint state = push.state.v[kStateFrames * push.rendered.x * push.rendered.y + rendered_pixel(at)];
    return state >> 16 != 0u && max(state & 255u, state >> 8 & 255u) <= 4u;
}

// 0: stands still, 1: moves by half a pixel of the picture or more.
float moves(vec2 moved_px) { return min(2.0 * length(moved_px), 1.0); }

// What the frame shows around a point of the picture.
struct Frame {
    vec3 color;            // sum by the kernel
    float weight;          // of it: 1 for a pixel that looks just there
    vec3 around;           // mean by a kernel as wide as rendered pixels are
    vec3 light;            // plain mean
    Neighbourhood roots;
    ivec2 nearest;         // pixel of the nearest surface
    float fresh;           // pixels without a past
};
Frame look(vec2 at_px, vec2 ratio) {
    const ivec2 middle = ivec2(floor(at_px));
    // The picture's own pixels where it stands still and there is time to meet each; in motion the frame's, which all of them get something of.
    const vec2 sharpness = push.sharpness * mix(ratio, vec2(1.0), moves(imageLoad(motion, middle).xy * ratio));
    Frame f = Frame(vec3(0.0), 0.0, vec3(0.0), vec3(0.0), kNoNeighbourhood, middle, 0.0);
    float nearest = uintBitsToFloat(0x7F800000u), around = 0.0;
    for (int i = 0; i < 9; ++i) {
        const ivec2 at = middle + ivec2(i % 3, i / 3) - 1;
        if (!is_rendered(at)) continue;
        const vec3 color = unpack_half_light(push.colors.v[rendered_pixel(at)]).rgb;
        const vec2 off_px = vec2(at) + 0.5 + push.jitter - at_px, off = off_px * sharpness;
        const float weight = exp(-0.5 * dot(off, off)), wide = exp(-2.0 * dot(off_px, off_px)), depth = uintBitsToFloat(push.guide.v[rendered_pixel(at)].x);
        f.color += weight * color;
        f.weight += weight;
        f.around += wide * color;
        around += wide;
        f.light += color;
        add(f.roots, to_compared(color));
        if (is_fresh(at)) f.fresh += 1.0;
        if (depth < nearest) {
            nearest = depth;
            f.nearest = at;
        }
    }
    f.around /= max(around, 1e-6);
    f.light /= f.roots.count;
    return f;
}

// Catmull and Rom 1974 over the 16 texels around, without the corners, by five bilinear taps.
vec3 read_history(vec2 at_px, vec2 size) {
    const vec2 base = floor(at_px - 0.5) + 0.5, f = at_px - base;
    const vec4 wx = catmull_rom(f.x), wy = catmull_rom(f.y);
    const vec2 w0 = vec2(wx[0], wy[0]), w1 = vec2(wx[1], wy[1]), w2 = vec2(wx[2], wy[2]), w3 = vec2(wx[3], wy[3]);
    const vec2 w12 = w1 + w2, at0 = (base - 1.0) / size, at12 = (base + w2 / w12) / size, at3 = (base + 2.0) / size;
    vec3 sum = textureLod(history, at12, 0.0).rgb * (w12.x * w12.y);
    float weight = w12.x * w12.y;
    const vec3 sides[4] = vec3[](vec3(at12.x, at0.y, w12.x * w0.y), vec3(at0.x, at12.y, w0.x * w12.y), vec3(at3.x, at12.y, w3.x * w12.y), vec3(at12.x, at3.y, w12.x * w3.y));
    for (int i = 0; i < 4; ++i) {
        sum += textureLod(history, sides[i].xy, 0.0).rgb * sides[i].z;
        weight += sides[i].z;
    }
    return max(sum / weight, vec3(0.0)) * push.exposure_scale;
}

// The history around, as far as the frame's pixels around reach.
Neighbourhood look_back(vec3 middle, vec2 at_px, vec2 size, vec2 ratio) {
    Neighbourhood n = kNoNeighbourhood;
    add(n, to_compared(middle));
    for (int i = 0; i < 4; ++i) add(n, to_compared(textureLod(history, (at_px + vec2(i % 2 * 2 - 1, i / 2 * 2 - 1) * ratio) / size, 0.0).rgb * push.exposure_scale));
    return n;
}

// A history's light, what it is worth in frames, and how many frames in a row have not shown it.
struct Past {
    vec3 color;
    float frames, misses;
};
Past recall(Frame f, vec2 before_px, vec2 moved_px, vec2 size, vec2 ratio) {
    const vec2 kept = unpack_worth(texelFetch(history, ivec2(before_px), 0).a, push.frames);
    const float moving = moves(moved_px);
    Past past = Past(read_history(before_px, size), min(kept.x, push.frames * mix(1.0, kMovingShare, moving)), kept.y);
    // The middle of the box is the mean light's: that of roots lies below it wherever colours differ, and would darken what is clipped. What
    // stands still may lie off twice as far: a lamp's edge that few frames see must stay in the mean of them.
    const vec3 middle = to_compared(f.light), off = to_compared(past.color) - middle;
    const vec3 share = abs(off) / max(deviation_from(f.roots, middle) * push.deviations * mix(2.0, 1.0, moving), vec3(kSameShare * middle.x + 1e-5));
    const float most = max_component(share);
    if (most <= 1.0) return Past(past.color, past.frames, 0.0);
    past.misses = min(past.misses + 1.0, kMostMisses);
    const bool may_be_detail = past.misses <= kMissesStill * (1.0 - moving);
    const float unlike = may_be_detail ? difference(f.roots, look_back(past.color, before_px, size, ratio), kSameMeanShare) : kUnlike;
    const float stays = mix(1.0, 1.0 / most, smoothstep(kAlike, kUnlike, unlike));
    if (stays < 1.0) past.color = from_compared(middle + off * stays);
    past.frames *= stays;
    return past;
}

void main() {
    const ViewData view = push.view.data;
    const uvec2 id = gl_GlobalInvocationID.xy;
    if (id.x >= view.width || id.y >= view.height) return;
    const uint pixel = id.y * view.width + id.x;
    const vec2 size = vec2(view.width, view.height), ratio = size / vec2(push.rendered), at_px = (vec2(id) + 0.5) / ratio;
    const uvec4 random = pcg4d(uvec4(id, push.frame_index, 0x54414131u));
    vec3 color;
    float frames = 0.0, misses = 0.0;
    if (push.frames <= 0.0) {
        color = unpack_half_light(push.colors.v[rendered_pixel(ivec2(at_px))]).rgb;
    } else {
        const Frame f = look(at_px, ratio);
        const vec2 moved_px = imageLoad(motion, f.nearest).xy * ratio, before_px = vec2(id) + 0.5 + moved_px;
        Past past = Past(vec3(0.0), 0.0, 0.0);
        const bool is_new = is_fresh(ivec2(at_px)) && 2.0 * f.fresh > f.roots.count;  // not so a wire that some frames miss
        if (push.has_history != 0u && !is_new && all(greaterThan(before_px, vec2(0.0))) && all(lessThan(before_px, size)))
            past = recall(f, before_px, moved_px, size, ratio);
        const float spatial = kSpatial * max(1.0 - past.frames / kSure, 0.0);
        color = (past.color * past.frames + f.color + f.around * spatial) / max(past.frames + f.weight + spatial, 1e-6);
        frames = min(past.frames + f.weight + spatial, push.frames);
        misses = past.misses;
    }
    const vec3 kept = min(color, vec3(kMostHalf));
    imageStore(picture, ivec2(id), vec4(dither_half(kept.r, random.x), dither_half(kept.g, random.y), dither_half(kept.b, random.z), pack_worth(vec2(frames, misses), push.frames, random.w)));
    film_add_beauty(push.block, view, pixel, color * push.nits);
}
