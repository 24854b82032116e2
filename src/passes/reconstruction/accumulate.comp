#version 460
// Adds the frame's light to what earlier frames brought to the same surface: fireflies are shared out first, then each signal is a running
// mean of as many frames as its history is worth. Diffuse light is looked for where the surface was, specular light there or where its
// reflection was seen, whichever agrees. Histories are short where the light of the tiles around drifts.
// Schied et al. 2017 (SVGF) for the means; Zhdan 2021 (ReBLUR) for virtual motion and the fast history; Schied et al. 2018 (A-SVGF) for the
// idea to shorten histories by what changed, here told by means over tiles.
// Reads: view, identity, summary, motion, depth, signals (diffuse, specular, distances), guide, light and state of the last frame, verdicts.
// Writes: guide, normals (geometric), light, state, tiles.
#extension GL_GOOGLE_include_directive : require
#include "lib/hash.glsl"
#include "lib/packed_light.glsl"
#include "lib/projection.glsl"
#include "reconstruction/fireflies.glsl"

layout(local_size_x = kChangeTile, local_size_y = kChangeTile) in;
layout(set = 1, binding = 0, rgba32ui) uniform readonly uimage2D identity;
layout(set = 1, binding = 1, rgba32ui) uniform readonly uimage2D summary;
layout(set = 1, binding = 2, rg32f) uniform readonly image2D motion;
layout(set = 1, binding = 3, r32f) uniform readonly image2D depth;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ViewBlock { ViewData data; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Noisy { PackedLight v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Words { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer Pairs { uvec2 v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Verdicts { ChangeVerdict v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer NewWords { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) writeonly buffer NewPairs { uvec2 v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer NewTiles { ChangeTile v[]; };
layout(push_constant, scalar) uniform Push {
    ViewBlock view;
    Noisy diffuse, specular;
    Words distances;
    Pairs guide_before, diffuse_before, specular_before;
    Words state_before;
    Verdicts verdicts;
    NewPairs guide, diffuse_now, specular_now;
    NewWords normals, state;
    NewTiles tiles;
    ReconstructionFrame frame;
} push;
#include "reconstruction/history.glsl"
#include "reconstruction/verdicts.glsl"

const uint kPixels = kChangeTile * kChangeTile, kLoads = (kSide * kSide + kPixels - 1u) / kPixels;
const uint kTold = 9u;
shared float told[kTold][kPixels], rows[kTold][kChangeTile], sums[kTold];

// A pixel of the group or around it, on its way to shared memory.
struct Lit {
    uint id;
    PackedLight diffuse, specular;
};
Lit load_light(ViewData view, uint i) {
    const ivec2 at = ivec2(gl_WorkGroupID.xy * kChangeTile) + ivec2(i % kSide, i / kSide) - int(kRing);
    const uint pixel = pixel_at(view, at);
    return Lit(is_on_film(view, at) ? imageLoad(summary, at).z >> kSummaryIdShift : 0u, push.diffuse.v[pixel], push.specular.v[pixel]);
}
void keep_light(uint i, Lit light) {
    lit_id[i] = light.id;
    lit_diffuse[i] = unpack_light(light.diffuse);
    lit_specular[i] = unpack_light(light.specular);
    lit[i] = vec2(luminance(lit_diffuse[i]), luminance(lit_specular[i]));
}

float blend_hit(float before, float now) { return now <= 0.0 ? before : before <= 0.0 ? now : mix(before, now, 0.25); }

// Of the surface, 1 / m, positive where it bulges out, by how normals turn two pixels to each side. What its coded normals cannot tell from flat
// is flat.
float find_curvature(ViewData view, ivec2 middle, Sought s, vec3 position_ws) {
    float sum = 0.0, count = 0.0;
    for (int i = 0; i < 4; ++i) {
        const ivec2 at = middle + ivec2[](ivec2(-2, 0), ivec2(2, 0), ivec2(0, -2), ivec2(0, 2))[i];
        if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, ivec2(view.width, view.height)))) continue;
        const uvec4 there = imageLoad(summary, at);
        if (there.z >> kSummaryIdShift != s.id) continue;
        const Guide guide = unpack_guide(pack_guide(imageLoad(depth, at).x, view.camera.orthographic != 0u, there));
        const vec3 turn = guide.normal - s.normal_ws, along = place(view.camera, vec2(at) + 0.5 + push.frame.jitter, vec2(view.width, view.height), guide.depth) - position_ws;
        if (dot(turn, turn) > 2e-6) sum += dot(turn, along) / max(dot(along, along), 1e-20);
        count += 1.0;
    }
    return sum / max(count, 1.0);
}

// What a surface shows by reflection, as far behind it as that: how far from the surface it was seen in the last frame, pixels, and how far its lobe spreads it.
struct Image {
    vec2 film_px;  // in the last frame
    float parallax, lobe;
    bool in_front;
};
Image find_image(ViewData view, Guide here, vec3 position_ws, vec2 before_px, float behind) {
    const vec3 along = view.camera.orthographic != 0u ? view.camera.forward_ws : normalize(position_ws - view.camera.position_ws);
    const FilmPoint seen = project_point(view.camera_before, position_ws + behind * along, vec2(view.width, view.height));
    const vec2 film_px = seen.film_px - push.frame.jitter;
    const float lobe = lobe_tangent(here.roughness) * behind / ((here.depth + behind) * max(pixel_size(view, here.depth) / here.depth, 1e-9));
    return Image(film_px, distance(film_px, before_px), lobe, seen.in_front);
}
// Frames in which the lobe is wider than the parallax.
float frames_of(Image image) { return (image.lobe + 0.25) / max(image.parallax, 1e-9); }

// The specular history where the reflection was seen, for a mirror that stands still, flat or bent, whose image is as far behind it as the mirror
// equation says; mixed in as far as what was reflected there lay as far away. What is left of the surface's own history lasts for as long as the
// lobe is wider than the parallax. Most lobes are wider for longer than any history lasts; where those of a flat mirror would be, the image is not looked for
// (without it FLIP of pictures in motion is the same within 1 %).
void find_reflection(ViewData view, ivec2 id, vec3 position_ws, vec2 before_px, Sought s, Guide here, float hit_now, inout Signal specular) {
    const float hit = here.roughness < 0.1 && hit_now > 0.0 ? hit_now : blend_hit(specular.hit, hit_now);
    if (push.frame.virtual_motion == 0u || hit <= 0.0) return;
    const Image flat_image = find_image(view, here, s.position_ws, before_px, hit);
    if (flat_image.in_front && frames_of(flat_image) >= float(push.frame.history)) return;
    const Image image = find_image(view, here, s.position_ws, before_px, hit / max(1.0 + 2.0 * find_curvature(view, id, s, position_ws) * hit, 0.25));
    if (!image.in_front || image.parallax < 0.05) return;
    specular.frames = min(specular.frames, frames_of(image));
    const Taps taps = find_taps(view, image.film_px, s);
    if (taps.weights.x + taps.weights.y + taps.weights.z + taps.weights.w <= 0.0) return;
    Signal ignored, reflected;
    read_history(view, taps, s.id, ignored, reflected);
    const float agrees = reflected.hit <= 0.0 ? 0.0 : 1.0 - smoothstep(0.05, 0.2, abs(reflected.hit - hit) / (here.depth + hit));
    specular = Signal(mix(specular.light, reflected.light, agrees), mix(specular.tone, reflected.tone, agrees), mix(specular.fast, reflected.fast, agrees),
                      mix(specular.hit, reflected.hit, agrees), mix(specular.frames, reflected.frames, agrees));
}

// Both signals' histories. What moves by itself was elsewhere in space, as far off as its pixel tells; along the view, that it does not.
void find_histories(ViewData view, ivec2 id, Guide here, uint normal, vec2 before_px, uint surface, float hit, inout Signal diffuse, inout Signal specular) {
    const vec2 film_px = vec2(id) + 0.5, size = vec2(view.width, view.height);
    const vec3 position_ws = place(view.camera, film_px + push.frame.jitter, size, here.depth);
    Sought s = Sought(position_ws, unpack_direction(normal), here.normal, 0.8, 0.005 * here.depth, surface);
    const FilmPoint still = project_point(view.camera_before, s.position_ws, size);
    if (!still.in_front || distance(still.film_px - push.frame.jitter, before_px) > 0.05) {
        s.position_ws = place(view.camera_before, before_px + push.frame.jitter, size, here.depth);
        s.slack = 0.04 * here.depth;
    }
    read_history(view, find_taps(view, before_px, s), surface, diffuse, specular);
    find_reflection(view, id, position_ws, before_px, s, here, hit, specular);
}

// The history with one more frame, worth so many at most.
Signal advance(Signal before, vec3 light, float hit, float worth) {
    const float frames = min(before.frames + 1.0, max(worth, 1.0)), share = 1.0 / frames;
    const float share_of_deviation = 1.0 / (before.frames + 1.0);  // noise stays what it is while light changes
    const float l = luminance(light), tone = tone_of(l), off = tone - before.tone.x;
    Signal now;
    now.light = mix(before.light, light, share);
    now.tone = vec2(mix(before.tone.x, tone, share), sqrt((1.0 - share_of_deviation) * (before.tone.y * before.tone.y + share_of_deviation * off * off)));
    now.fast = mix(before.fast, l, max(share, 1.0 / float(push.frame.fast_history)));
    now.hit = blend_hit(before.hit, hit);
    now.frames = frames;
    return now;
}

// For the next frame's verdicts, in tones: rare bright frames, which would drown a change of luminance, weigh little in them. Only what has a history
// says something.
void tell(uint thread, uint first, Signal history, vec3 now, float drift_before) {
    const float kRounded = 0.01;  // stops that halves may be off: light without noise does not drift by them
    const bool says = history.frames >= 3.0;
    const float variance = (history.tone.y * history.tone.y + kRounded * kRounded) * (1.0 + 1.0 / max(history.frames, 1.0));
    const float drift = (tone_of(luminance(now)) - history.tone.x) / max(history.frames, 1.0);
    told[first][thread] = says ? variance : 0.0;
    told[first + 1u][thread] = says ? drift : 0.0;
    told[first + 2u][thread] = says ? mix(drift_before, drift, kDriftShare) : 0.0;
    told[first + 3u][thread] = says ? variance / (history.frames * history.frames) : 0.0;
}
// Where no pixel says anything the drift stays what it was. Pixels that are all off together have a tile's number of times their own noise, and no more.
ChangeSums sums_of(uint first, float drift_before, float noise_before) {
    if (sums[8] == 0.0) return ChangeSums(0.0, 0.0, drift_before, 0.0, noise_before);
    const float off = (sums[first + 1u] - sums[first + 2u]) / (1.0 - kDriftShare), variance = max(sums[first + 3u], 1e-12);
    const float noise = mix(noise_before, min(off * off / variance, kMostNoise * kMostNoise * noise_before), kNoiseShare);
    return ChangeSums(sums[first], sums[first + 1u], sums[first + 2u], variance, clamp(noise, 0.5, float(kPixels)));
}
void sum_tile(uint thread) {
    barrier();
    for (uint i = thread; i < kTold * kChangeTile; i += kPixels) {
        const uint k = i / kChangeTile, row = i % kChangeTile;
        float sum = 0.0;
        for (uint x = 0u; x < kChangeTile; ++x) sum += told[k][row * kChangeTile + x];
        rows[k][row] = sum;
    }
    barrier();
    if (thread < kTold) {
        float sum = 0.0;
        for (uint row = 0u; row < kChangeTile; ++row) sum += rows[thread][row];
        sums[thread] = sum;
    }
    barrier();
    if (thread != 0u) return;
    const uint tile = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    vec2 drift = vec2(0.0), noise = vec2(1.0);
    if (push.frame.has_history != 0u) {
        drift = unpackHalf2x16(push.verdicts.v[tile].drift);
        noise = unpackHalf2x16(push.verdicts.v[tile].shared_noise);
    }
    push.tiles.v[tile] = ChangeTile(sums_of(0u, drift.x, noise.x), sums_of(4u, drift.y, noise.y), sums[8]);
}

void keep(uint pixel, uint plane, uvec2 id, Signal diffuse, Signal specular, uint surface) {
    const uvec4 random = pcg4d(uvec4(id, push.frame.frame_index, 0x5245434Fu));
    push.diffuse_now.v[pixel] = pack_half_light(dither_half(vec4(diffuse.light, diffuse.tone.x), random));
    push.specular_now.v[pixel] = pack_half_light(dither_half(vec4(specular.light, specular.tone.x), random >> 16));
    push.state.v[kStateFast * plane + pixel] = packHalf2x16(min(vec2(diffuse.fast, specular.fast), vec2(kMostHalf)));
    push.state.v[kStateHits * plane + pixel] = packHalf2x16(min(vec2(diffuse.hit, specular.hit), vec2(kMostHalf)));
    push.state.v[kStateDeviations * plane + pixel] = packHalf2x16(vec2(diffuse.tone.y, specular.tone.y));
    const uvec2 frames = uvec2(round(vec2(diffuse.frames, specular.frames) * 4.0));
    push.state.v[kStateFrames * plane + pixel] = frames.x | frames.y << 8 | surface << 16;
}

void main() {
    const ViewData view = push.view.data;
    const uvec2 id = gl_GlobalInvocationID.xy, local = gl_LocalInvocationID.xy;
    const uint thread = gl_LocalInvocationIndex, plane = view.width * view.height, pixel = pixel_at(view, ivec2(id));
    const bool inside = is_on_film(view, ivec2(id));
    // What needs nothing is asked for first; what the history then waits for it need not wait for, too.
    Lit around[kLoads];
    for (uint i = 0u; i < kLoads; ++i) around[i] = load_light(view, min(thread + i * kPixels, kSide * kSide - 1u));
    const ivec2 at = min(ivec2(id), ivec2(view.width, view.height) - 1);
    const uvec4 packed = imageLoad(summary, at);
    const uint surface = inside ? packed.z >> kSummaryIdShift : 0u, normal = imageLoad(identity, at).w;
    const uvec2 packed_guide = pack_guide(imageLoad(depth, at).x, view.camera.orthographic != 0u, packed);
    const vec2 hits = unpackHalf2x16(push.distances.v[pixel]), before_px = vec2(id) + 0.5 + imageLoad(motion, at).xy;
    Signal diffuse = kNoSignal, specular = kNoSignal;
    Change change = Change(vec2(push.frame.history), vec2(0.0));
    if (surface != 0u && push.frame.has_history != 0u && !any(isinf(before_px))) {
        find_histories(view, ivec2(id), unpack_guide(packed_guide), normal, before_px, surface, hits.y, diffuse, specular);
        change = find_change(uvec2(view.width, view.height), before_px);
    }
    for (uint i = 0u; i < kLoads; ++i)
        if (thread + i * kPixels < kSide * kSide) keep_light(thread + i * kPixels, around[i]);
    barrier();
    for (uint i = thread; i < kInner * kInner; i += kPixels) find_gifts(i, push.frame.firefly);
    barrier();
    vec3 diffuse_now = vec3(0.0), specular_now = vec3(0.0);
    if (surface != 0u) {
        share_out(local, diffuse_now, specular_now);
        push.guide.v[pixel] = packed_guide;
        push.normals.v[pixel] = normal;
        keep(pixel, plane, id, advance(diffuse, diffuse_now, hits.x, change.worth.x), advance(specular, specular_now, hits.y, change.worth.y), surface);
    } else if (inside) {
        push.guide.v[pixel] = uvec2(0x7F800000u, 0u);
        keep(pixel, plane, id, kNoSignal, kNoSignal, 0u);
    }
    tell(thread, 0u, diffuse, diffuse_now, change.drift.x);
    tell(thread, 4u, specular, specular_now, change.drift.y);
    told[8][thread] = max(diffuse.frames, specular.frames) >= 3.0 ? 1.0 : 0.0;
    sum_tile(thread);
}
