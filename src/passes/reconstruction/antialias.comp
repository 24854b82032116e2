#version 460
// Temporal anti-aliasing, and upscaling where the picture has more pixels than were rendered: each frame's pixels look elsewhere through the
// picture's, whose histories add them up, and are looked for where the nearest surface around was. A history knows which surfaces it is made of:
// where none of them is around, or was there in the last frame, it goes, but for still heaps of things smaller than pixels. One that does not fit
// the light that the frame shows around is drawn back to it; where only details are missing, which one frame's few rays may miss, it stays for some frames. Karis 2014; Salvi 2016 (variance clipping);
// Jimenez 2016, "Filmic SMAA" (Catmull-Rom history); Yang, Liu, Salvi 2020, "A Survey of Temporal Antialiasing Techniques" (upscaling by weights that
// add up over time); AMD 2022, "FidelityFX Super Resolution 2" (locks of thin features; disocclusion by geometry): docs/papers.md.
// Reads: view, motion, guide, state, colors, history, shown_before. Writes: picture and shown (the next history). Reads and writes: block.
#extension GL_GOOGLE_include_directive : require
#include "reconstruction/compared.glsl"
#include "reconstruction/half_light.glsl"
#include "reconstruction/shown.glsl"
#include "lib/hash.glsl"
#include "scene/film.glsl"
#include "shared/reconstruction.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 1, binding = 0, rg32f) uniform readonly image2D motion;
layout(set = 1, binding = 1) uniform sampler2D history;
layout(set = 1, binding = 2, rg8) uniform readonly image2D shown_before;
layout(set = 1, binding = 3, rgba16f) uniform writeonly image2D picture;
layout(set = 1, binding = 4, rg8) uniform writeonly image2D shown;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ViewBlock { ViewData data; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Words { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer Pairs { uvec2 v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Verdicts { ChangeVerdict v[]; };
layout(push_constant, scalar) uniform Push {
    ViewBlock view;
    Pairs guide, colors;
    Words state;
    Verdicts verdicts;
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

const float kStillWidth = 1.25;   // times the kernel's deviation, where the picture stands still: that of a pixel's box
const float kMovingShare = 0.25;  // of `frames`, where the picture moves: every frame's resampling blurs a little
const float kDriftFrames = 1.0;   // of the picture's history, for each more of the light's
const float kMoves = 0.1;         // of moves(): then rays that miss what was there do not miss it by chance
const float kWirePixels = 3.0;    // of the frame, to each side: what has been there alone is no wire
const float kMissesStill = 6.0;   // pairs of frames in a row that may miss a detail before it is gone, where it stands still
const float kLeftShare = 0.5;     // what a history is worth whose second surface may have left
const float kAlike = 0.6, kUnlike = 0.9;  // difference of two neighbourhoods' means over their deviations: only details differ; more than those
const float kSameShare = 0.004, kSameMeanShare = 0.02;  // of the mean root that a history, and its neighbourhood's mean, may lie off where no colour deviates
const float kSpatial = 0.05, kSure = 0.3;  // what the frame's pixels around are worth for a pixel without history; with one of so many frames nothing

uint rendered_pixel(ivec2 at) { return uint(at.y) * push.rendered.x + uint(at.x); }
bool is_rendered(ivec2 at) { return all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, ivec2(push.rendered))); }

uint state_of(ivec2 at) { return push.state.v[kStateFrames * push.rendered.x * push.rendered.y + rendered_pixel(at)]; }
// Its surface was nowhere in the last frame.
bool is_fresh(uint state) { return state >> 16 != 0u && max(state & 255u, state >> 8 & 255u) <= kStateFresh; }

#include "reconstruction/verdicts.glsl"
// Frames that the picture's history is worth while light drifts: the lag that it adds to the light's own is kept near that one's.
float worth_in_drift(vec2 before_px) {
    const vec2 worth = find_change(push.rendered, before_px).worth;
    return kDriftFrames * (min(worth.x, worth.y) - 1.0);
}

// 0: stands still, or was in no frame; 1: moves by half a pixel of the picture or more.
float moves(vec2 moved_px) { return push.has_history != 0u ? min(2.0 * length(moved_px), 1.0) : 0.0; }

// What the frame shows around a point of the picture.
struct Frame {
    vec3 color;            // sum by the kernel
    float weight;          // of it: 1 for a pixel that looks just there
    vec3 around;           // mean by a kernel as wide as rendered pixels are
    vec3 light;            // plain mean
    Neighbourhood roots;
    ivec2 nearest;         // pixel of the nearest surface
    float fresh;           // pixels without a past
    float in_a_row;        // pixels that show what the one before shows
    Shown here, known;     // surfaces, and those of pixels with a past
    uvec2 surfaces;        // that `color` is made of: most of it, and most of the rest
};
Frame look(vec2 at_px, vec2 ratio) {
    const ivec2 middle = ivec2(floor(at_px));
    // As wide as the picture's own pixels where it stands still and there is time to meet each; in motion by the frame's, of which all get something.
    const vec2 sharpness = push.sharpness * mix(ratio / kStillWidth, vec2(1.0), moves(imageLoad(motion, middle).xy * ratio));
    Frame f = Frame(vec3(0.0), 0.0, vec3(0.0), vec3(0.0), kNoNeighbourhood, middle, 0.0, 0.0, kNothingShown, kNothingShown, uvec2(kNoSurface));
    float nearest = uintBitsToFloat(0x7F800000u), around = 0.0;
    uint last = kNoSurface;
    vec2 most = vec2(0.0);
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
        const uint state = state_of(at), surface = short_number(state >> 16);
        add(f.here, i, surface);
        f.in_a_row += float(surface == last);
        last = surface;
        if (is_fresh(state)) f.fresh += 1.0;
        else add(f.known, i, surface);
        note(f.surfaces, most, surface, wide);
        if (depth < nearest) {
            nearest = depth;
            f.nearest = at;
        }
    }
    f.around /= max(around, 1e-6);
    f.light /= f.roots.count;
    return f;
}

#include "reconstruction/read_picture.glsl"

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
    uvec2 surfaces;  // that its nearest pixel is made of
};
const Past kNoPast = Past(vec3(0.0), 0.0, 0.0, uvec2(kNoSurface));

// Of things smaller than pixels, which come and go by chance where nothing moves.
bool is_scattered(Frame f) { return f.in_a_row <= 3.0; }
// All that a pixel of the history is made of is around.
bool is_whole(Frame f, uvec2 surfaces) { return has(f.here, surfaces.x) && (surfaces.y == kNoSurface || has(f.here, surfaces.y)); }

uvec2 surfaces_before(vec2 at_px, vec2 size) { return unpack_surfaces(imageLoad(shown_before, clamp(ivec2(floor(at_px)), ivec2(0), ivec2(size) - 1)).rg); }

// Whether what is not around of a history's surfaces has left, and was not just missed by rays: some pixels on the history shows it alone, and the
// frame something else, or what moves otherwise.
bool has_left(Frame f, uvec2 surfaces, vec2 now_px, vec2 moved_px, vec2 size, vec2 ratio) {
    const uvec2 alone = uvec2(has(f.here, surfaces.x) ? surfaces.y : surfaces.x, kNoSurface);
    for (int i = 0; i < 9; ++i) {
        const vec2 there_px = now_px + kWirePixels * ratio * (vec2(i % 3, i / 3) - 1.0);
        const ivec2 at = ivec2(floor(there_px / ratio));
        if (!is_rendered(at) || surfaces_before(there_px + moved_px, size) != alone) continue;
        if (short_number(state_of(at) >> 16) != alone.x || moves(imageLoad(motion, at).xy * ratio - moved_px) > kMoves) return true;
    }
    return false;
}

// How far a pixel of the history is of surfaces that are around and were there in the last frame. Where something moves what is not is hardly missed.
float fits(Frame f, uvec2 surfaces, bool moved, bool left) {
    if (!has(f.known, surfaces.x) && (surfaces.y == kNoSurface || !has(f.known, surfaces.y))) return moved || left || !is_scattered(f) ? 0.0 : 1.0;
    if (is_whole(f, surfaces)) return 1.0;
    return left ? 0.0 : !moved ? 1.0 : has(f.here, surfaces.x) ? kLeftShare : 0.0;
}

// The history at a place, of those of its four pixels that fit; returns how much of it does.
float read_fitting(Frame f, vec2 at_px, vec2 size, bool moved, bool left, out vec3 color) {
    const ivec2 first = ivec2(floor(at_px - 0.5));
    const vec2 t = at_px - 0.5 - vec2(first);
    vec4 weights = vec4((1.0 - t.x) * (1.0 - t.y), t.x * (1.0 - t.y), (1.0 - t.x) * t.y, t.x * t.y);
    for (int i = 0; i < 4; ++i) weights[i] *= weights[i] < 0.02 ? 0.0 : fits(f, surfaces_before(vec2(first) + vec2(i & 1, i >> 1), size), moved, left);
    const float fitting = dot(weights, vec4(1.0));
    if (fitting > 0.9) {
        color = read_history(at_px, size);
        return 1.0;
    }
    color = vec3(0.0);
    for (int i = 0; i < 4; ++i)
        if (weights[i] > 0.0) color += weights[i] * texelFetch(history, clamp(first + ivec2(i & 1, i >> 1), ivec2(0), ivec2(size) - 1), 0).rgb;
    color *= push.exposure_scale / max(fitting, 1e-6);
    return fitting;
}

Past recall(Frame f, bool is_new, vec2 now_px, vec2 moved_px, vec2 size, vec2 ratio, uint random_bit) {
    const vec2 before_px = now_px + moved_px;
    const Worth kept = unpack_worth(texelFetch(history, ivec2(before_px), 0).a, push.frames);
    const float moving = moves(moved_px);
    Past past = kNoPast;
    past.surfaces = surfaces_before(before_px, size);
    const bool moved = moving > kMoves || kept.moved, left = moving <= kMoves && !is_whole(f, past.surfaces) && has_left(f, past.surfaces, now_px, moved_px, size, ratio);
    if (is_new && (moved || left || !is_scattered(f))) return kNoPast;
    const float fitting = read_fitting(f, before_px, size, moved, left, past.color);
    if (fitting <= 0.0) return kNoPast;
    past.frames = min(min(kept.frames, push.frames * mix(1.0, kMovingShare, moving)), worth_in_drift(before_px / ratio)) * fitting;
    // The middle of the box is the mean light's: that of roots lies below it wherever colours differ, and would darken what is clipped. What
    // stands still may lie off twice as far: a lamp's edge that few frames see must stay in the mean of them.
    const vec3 middle = to_compared(f.light), off = to_compared(past.color) - middle;
    const vec3 share = abs(off) / max(deviation_from(f.roots, middle) * push.deviations * mix(2.0, 1.0, moving), vec3(kSameShare * middle.x + 1e-5));
    const float most = max_component(share);
    if (most <= 1.0) return past;
    past.misses = min(kept.misses + float(random_bit), kMostMisses);
    const bool may_be_detail = past.misses <= kMissesStill * (1.0 - moving) && !moved && !left;
    if (may_be_detail && !is_whole(f, past.surfaces)) return past;  // a wire that this frame's rays miss
    const float unlike = may_be_detail ? difference(f.roots, look_back(past.color, before_px, size, ratio), kSameMeanShare) : kUnlike;
    const float stays = mix(1.0, 1.0 / most, smoothstep(kAlike, kUnlike, unlike));
    if (stays < 1.0) past.color = from_compared(middle + off * stays);
    past.frames *= stays;
    return past;
}

// What the picture's pixel is made of from now on: what the frame shows most of, and one of the history's that is around, or else the frame's.
uvec2 keep_surfaces(Frame f, Past past) {
    uvec2 kept = uvec2(f.surfaces.x, kNoSurface);
    for (int i = 0; i < 2; ++i) {
        const uint old = past.frames > 0.0 ? past.surfaces[i] : kNoSurface;
        if (kept.y == kNoSurface && old != kNoSurface && old != kept.x && has(f.here, old)) kept.y = old;
    }
    if (kept.y == kNoSurface) kept.y = f.surfaces.y;
    return kept;
}

void main() {
    const ViewData view = push.view.data;
    const uvec2 id = gl_GlobalInvocationID.xy;
    if (id.x >= view.width || id.y >= view.height) return;
    const uint pixel = id.y * view.width + id.x;
    const vec2 size = vec2(view.width, view.height), ratio = size / vec2(push.rendered), at_px = (vec2(id) + 0.5) / ratio;
    const uvec4 random = pcg4d(uvec4(id, push.frame_index, 0x54414131u));
    vec3 color;
    Worth worth = Worth(0.0, 0.0, false);
    uvec2 surfaces = uvec2(kNoSurface);
    if (push.frames <= 0.0) color = unpack_half_light(push.colors.v[rendered_pixel(ivec2(at_px))]).rgb;
    else {
        const Frame f = look(at_px, ratio);
        const vec2 moved_px = imageLoad(motion, f.nearest).xy * ratio, before_px = vec2(id) + 0.5 + moved_px;
        Past past = kNoPast;
        const bool is_new = is_fresh(state_of(f.nearest)) && 2.0 * f.fresh > f.roots.count;  // not so a wire that some frames miss
        if (push.has_history != 0u && all(greaterThan(before_px, vec2(0.0))) && all(lessThan(before_px, size)))
            past = recall(f, is_new, vec2(id) + 0.5, moved_px, size, ratio, random.w >> 31);
        const float spatial = kSpatial * max(1.0 - past.frames / kSure, 0.0);
        color = (past.color * past.frames + f.color + f.around * spatial) / max(past.frames + f.weight + spatial, 1e-6);
        worth = Worth(min(past.frames + f.weight + spatial, push.frames), past.misses, moves(moved_px) > kMoves);
        surfaces = keep_surfaces(f, past);
    }
    const vec3 kept = min(color, vec3(kMostHalf));
    imageStore(picture, ivec2(id), vec4(dither_half(kept.r, random.x), dither_half(kept.g, random.y), dither_half(kept.b, random.z), pack_worth(worth, push.frames, random.w)));
    imageStore(shown, ivec2(id), vec4(pack_surfaces(surfaces), 0.0, 0.0));
    film_add_beauty(push.block, view, pixel, color * push.nits);
}
