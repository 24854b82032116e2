// The last frame's signals where a surface of this frame was. Reprojection with the taps' own weights after Schied et al. 2017,
// "Spatiotemporal Variance-Guided Filtering" (4.1); the test by the distance from the surface's plane after Zhdan 2021, "ReBLUR: A
// Hierarchical Recurrent Denoiser" (Ray Tracing Gems II, 49). Needs `push` of accumulate.comp.
#ifndef PARHELION_RECONSTRUCTION_HISTORY_GLSL
#define PARHELION_RECONSTRUCTION_HISTORY_GLSL
#include "reconstruction/cubic.glsl"
#include "reconstruction/half_light.glsl"
#include "reconstruction/surfaces.glsl"
#include "reconstruction/tone.glsl"

// A signal of a pixel over time.
struct Signal {
    vec3 light;
    vec2 tone;     // mean, and deviation of a single frame
    float fast;    // luminance over the last few frames
    float hit;     // metres to what its paths met; 0: not known
    float frames;  // that `light` is worth; 0: there is none
};
const Signal kNoSignal = Signal(vec3(0.0), vec2(0.0), 0.0, 0.0, 0.0);

// What a pixel of the last frame must show.
struct Sought {
    vec3 position_ws, normal_geometric_ws, normal_ws;
    float least_cosine;  // between shading normals
    float slack;         // metres off the plane
    uint id;
};

bool is_on_film(ViewData view, ivec2 at) { return all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, ivec2(view.width, view.height))); }
uint pixel_at(ViewData view, ivec2 at) {
    const ivec2 on_film = clamp(at, ivec2(0), ivec2(view.width, view.height) - 1);
    return uint(on_film.y) * view.width + uint(on_film.x);
}
uint surface_before(ViewData view, ivec2 at) { return is_on_film(view, at) ? push.state_before.v[kStateFrames * view.width * view.height + pixel_at(view, at)] >> 16 : 0u; }

// Whether the pixel shows what is sought, if their ids are the same.
bool lies_there(ViewData view, ivec2 at, uvec2 guide, Sought s) {
    const Guide there = unpack_guide(guide);
    const vec3 p = place(view.camera_before, vec2(at) + 0.5 + push.frame.jitter_before, vec2(view.width, view.height), there.depth);
    return dot(there.normal, s.normal_ws) >= s.least_cosine && abs(dot(p - s.position_ws, s.normal_geometric_ws)) <= s.slack;
}

// Four pixels of the last frame and their weights, which add up to 1, or to 0 where none shows the surface.
struct Taps {
    ivec2 first;
    vec4 weights;
    vec2 between;  // place between the four
    bool whole;    // all of them show the surface
};
Taps find_taps(ViewData view, vec2 film_px, Sought s) {
    Taps taps;
    taps.first = ivec2(floor(film_px - 0.5));
    const vec2 f = film_px - 0.5 - vec2(taps.first);
    taps.weights = vec4((1.0 - f.x) * (1.0 - f.y), f.x * (1.0 - f.y), (1.0 - f.x) * f.y, f.x * f.y);
    taps.between = f;
    // No branches: all loads are under way at once.
    uint ids[4];
    uvec2 guides[4];
    for (int i = 0; i < 4; ++i) {
        const ivec2 at = taps.first + ivec2(i & 1, i >> 1);
        ids[i] = surface_before(view, at);
        guides[i] = push.guide_before.v[pixel_at(view, at)];
    }
    vec4 fits;
    for (int i = 0; i < 4; ++i) fits[i] = ids[i] == s.id && lies_there(view, taps.first + ivec2(i & 1, i >> 1), guides[i], s) ? 1.0 : 0.0;
    taps.whole = all(lessThanEqual(taps.weights, fits));  // what has no weight need not fit
    taps.weights *= fits;
    const float sum = taps.weights.x + taps.weights.y + taps.weights.z + taps.weights.w;
    taps.weights = sum > 0.01 ? taps.weights / sum : vec4(0.0);
    if (sum > 0.01) return taps;
    // Pixels look beside their centres, elsewhere in every frame: an edge's other side may have been seen there, and this one next to it.
    const ivec2 middle = ivec2(floor(film_px));
    const ivec2 kSides[8] = ivec2[](ivec2(0, -1), ivec2(-1, 0), ivec2(1, 0), ivec2(0, 1), ivec2(-1, -1), ivec2(1, -1), ivec2(-1, 1), ivec2(1, 1));
    uint around[8];
    for (int i = 0; i < 8; ++i) around[i] = surface_before(view, middle + kSides[i]);
    for (int i = 0; i < 8; ++i) {
        const ivec2 side = middle + kSides[i];
        if (around[i] != s.id || !lies_there(view, side, push.guide_before.v[pixel_at(view, side)], s)) continue;
        taps.first = side;
        taps.weights = vec4(1.0, 0.0, 0.0, 0.0);
        break;
    }
    return taps;
}

void add_tap(inout Signal sum, float weight, uvec2 light, float fast, float hit, uint frames, float deviation) {
    const vec4 l = unpack_half_light(light);
    sum.light += weight * l.rgb;
    sum.tone += weight * vec2(l.a, deviation);
    sum.fast += weight * fast;
    sum.hit += weight * hit;
    sum.frames += weight * float(frames & 255u) * 0.25;
}

void rescale(inout Signal s) {
    s.light *= push.frame.exposure_scale;
    s.fast *= push.frame.exposure_scale;
    s.tone.x = tone_of(push.frame.exposure_scale * luminance_of(s.tone.x));
}

// Light by Catmull and Rom 1974 over twelve pixels of one surface: four, frame after frame, would wash out what moves.
void sharpen(ViewData view, Taps taps, uint id, inout vec3 diffuse, inout vec3 specular) {
    if (!taps.whole || all(lessThan(abs(taps.between - round(taps.between)), vec2(0.02)))) return;
    const ivec2 first = taps.first - 1;
    if (any(lessThan(first, ivec2(0))) || any(greaterThanEqual(first + 3, ivec2(view.width, view.height)))) return;
    const vec4 wx = catmull_rom(taps.between.x), wy = catmull_rom(taps.between.y);
    const uint plane = view.width * view.height;
    vec3 d = vec3(0.0), s = vec3(0.0);
    float sum = 0.0;
    bool same = true;
    for (int i = 0; i < 16; ++i) {
        const int x = i & 3, y = i >> 2;
        if ((x == 0 || x == 3) && (y == 0 || y == 3)) continue;
        const uint pixel = uint(first.y + y) * view.width + uint(first.x + x);
        const float weight = wx[x] * wy[y];
        same = same && push.state_before.v[kStateFrames * plane + pixel] >> 16 == id;
        d += weight * unpack_half_light(push.diffuse_before.v[pixel]).rgb;
        s += weight * unpack_half_light(push.specular_before.v[pixel]).rgb;
        sum += weight;
    }
    if (!same) return;
    diffuse = max(d / sum, vec3(0.0));
    specular = max(s / sum, vec3(0.0));
}

void read_history(ViewData view, Taps taps, uint id, out Signal diffuse, out Signal specular) {
    diffuse = specular = kNoSignal;
    const uint plane = view.width * view.height;
    for (int i = 0; i < 4; ++i) {
        const uint pixel = pixel_at(view, taps.first + ivec2(i & 1, i >> 1)), frames = push.state_before.v[kStateFrames * plane + pixel];
        const vec2 fast = unpackHalf2x16(push.state_before.v[kStateFast * plane + pixel]), hits = unpackHalf2x16(push.state_before.v[kStateHits * plane + pixel]), deviations = unpackHalf2x16(push.state_before.v[kStateDeviations * plane + pixel]);
        add_tap(diffuse, taps.weights[i], push.diffuse_before.v[pixel], fast.x, hits.x, frames, deviations.x);
        add_tap(specular, taps.weights[i], push.specular_before.v[pixel], fast.y, hits.y, frames >> 8, deviations.y);
    }
    sharpen(view, taps, id, diffuse.light, specular.light);
    rescale(diffuse);
    rescale(specular);
}
#endif
