#version 460
// One step of the spatial filter: neighbours `stride` pixels away, weighed by how near they lie to the surface's plane, how alike they face, how
// little their tones differ for their deviations, and whether the light that paths met comes from far enough for so wide a step. After the
// a-trous filter of Dammertz et al. 2010, the edge-stopping of SVGF (Schied et al. 2017, 4.4), the radii of ReBLUR (Zhdan 2021).
// COMPOSITE: the last step, which also puts the picture together: light times the surface's colours, and emission.
// Reads: view, guide, normals, state, light (in), with COMPOSITE summary, emission. Writes: light (out), with COMPOSITE colors instead.
// variants: COMPOSITE
#extension GL_GOOGLE_include_directive : require
#include "reconstruction/half_light.glsl"
#include "reconstruction/surfaces.glsl"
#include "reconstruction/tone.glsl"
#ifdef COMPOSITE
#include "lib/packed_light.glsl"
#include "realtime/demodulate.glsl"
layout(set = 1, binding = 0, rgba32ui) uniform readonly uimage2D summary;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Noisy { PackedLight v[]; };
#endif

layout(local_size_x = 8, local_size_y = 8) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ViewBlock { ViewData data; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Words { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer Pairs { uvec2 v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) writeonly buffer NewPairs { uvec2 v[]; };
layout(push_constant, scalar) uniform Push {
    ViewBlock view;
    Pairs guide;
    Words normals, state;
    Pairs diffuse_in, specular_in;
#ifdef COMPOSITE
    Noisy emission;
    NewPairs colors;
#else
    NewPairs diffuse_out, specular_out;
#endif
    vec2 jitter;
    uint stride;   // pixels; 0: nothing is filtered
    float sigmas;  // deviations that neighbours' tones may differ by
} push;

// As light is summed up. A neighbour that shows the same surface has its weight, and what of it differs too much is the pixel's own instead: as much as
// this one leaves out of the other, the other leaves out of this one, so that no light is lost (but for what evenness() makes uneven).
struct Sum {
    vec3 light;  // of neighbours, as what follows
    float tone, variance;
    float weight;
    float own;   // what of the weight is the pixel's
};
const Sum kOnlyOwn = Sum(vec3(0.0), 0.0, 0.0, 1.0, 1.0);
void add(inout Sum sum, Toned other, float weight, float alike) {
    const float share = weight * alike;
    sum.light += share * other.light;
    sum.tone += share * other.tone;
    // Fireflies were shared out among the eight around, so that next neighbours are off together.
    sum.variance += (push.stride == 1u ? share : share * share) * other.deviation * other.deviation;
    sum.weight += weight;
    sum.own += weight - share;
}
Toned mean(Sum sum, Toned own) {
    const float own_variance = own.deviation * own.deviation;
    const float variance = push.stride == 1u ? (sum.variance + sum.own * own_variance) / sum.weight : (sum.variance + sum.own * sum.own * own_variance) / (sum.weight * sum.weight);
    return Toned((sum.light + sum.own * own.light) / sum.weight, (sum.tone + sum.own * own.tone) / sum.weight, sqrt(variance));
}

float pow8(float x) {
    const float square = x * x, fourth = square * square;
    return fourth * fourth;
}
// Close to exp(-x), without its cost; 0 from 8 on.
float bell(float x) { return pow8(max(1.0 - 0.125 * x, 0.0)); }
vec2 bell(vec2 x) { return vec2(bell(x.x), bell(x.y)); }

// Whether two means are of one tone, by how far both may be off.
float alike(Toned a, Toned b) {
    const float kSame = 0.02;  // stops
    const float off = a.tone - b.tone;
    return bell(0.5 * off * off / (push.sigmas * push.sigmas * (a.deviation * a.deviation + b.deviation * b.deviation) + kSame * kSame));
}

// Pixels around the surface that the two signals may be mixed over: what light from a metre off does to a metre's surface; what is seen
// within a lobe's angle, from here and by reflection.
vec2 reach_px(Guide here, vec2 hits, float pixel_ws) {
    const float kFar = 1e9;
    const float lobe = lobe_tangent(here.roughness);
    return vec2(hits.x > 0.0 ? hits.x : kFar, lobe * (hits.y > 0.0 ? here.depth * hits.y / (here.depth + hits.y) : here.depth)) / pixel_ws;
}

// The pixel and what its neighbours are held against.
struct Middle {
    ivec2 at;
    Guide guide;
    SeenPlane plane;
    float facing;  // how narrow the specular lobe is
    vec2 wide;     // what a step of this width counts for the two signals
};
struct Neighbour {
    Toned diffuse, specular;
    vec2 fits;  // its weights, by surfaces alone
};
Neighbour look(ViewData view, Middle middle, ivec2 step) {
    const ivec2 to = middle.at + step * int(push.stride), at = clamp(to, ivec2(0), ivec2(view.width, view.height) - 1);
    const uint pixel = uint(at.y) * view.width + uint(at.x);
    const Guide there = unpack_guide(push.guide.v[pixel]);
    const float off = distance_to(middle.plane, view.camera.orthographic != 0u, vec2(at - middle.at), min(there.depth, 1e30)) / (0.01 * middle.guide.depth);
    const float turned = 1.0 - dot(middle.guide.normal, there.normal);
    const float kernel = at == to ? max(0.0, 1.0 - off) * (step.x == 0 || step.y == 0 ? 0.5 : 0.25) : 0.0;
    const vec2 faces = bell(turned * vec2(32.0, 2.0 * middle.facing)) * vec2(1.0, max(0.0, 1.0 - 8.0 * abs(middle.guide.roughness - there.roughness)));
    return Neighbour(unpack_toned(push.diffuse_in.v[pixel]), unpack_toned(push.specular_in.v[pixel]), kernel * middle.wide * faces);
}

// How far two opposite neighbours both count as the less fitting one. Where a surface ends they lie on one side and draw the mean there: light that falls
// off into a corner would be too bright in it. But where the mean is noise, fewer neighbours cost more than that.
vec2 evenness(Toned diffuse, Toned specular) {
    const float kKnown = 0.3;  // stops that a mean may be off, at which half of it is done
    const vec2 noise = vec2(diffuse.deviation, specular.deviation) / kKnown;
    return 1.0 / (1.0 + noise * noise);
}

void filter_around(ViewData view, ivec2 at, uint pixel, Guide here, inout Toned diffuse, inout Toned specular) {
    const SeenPlane plane = see_plane(view.camera, vec2(at) + 0.5 + push.jitter, vec2(view.width, view.height), unpack_direction(push.normals.v[pixel]), here.depth);
    const vec2 reach = reach_px(here, unpackHalf2x16(push.state.v[kStateHits * view.width * view.height + pixel]), pixel_size(view, here.depth));
    const vec2 wide = clamp(2.0 * vec2(reach.x, max(reach.y, 1.5)) / float(push.stride) - 1.0, vec2(0.0), vec2(1.0));
    if (all(lessThan(wide, vec2(0.05)))) return;
    const float lobe = lobe_tangent(here.roughness);
    const Middle middle = Middle(at, here, plane, 1.0 / (lobe * lobe + 2e-4), wide);
    const vec2 even = evenness(diffuse, specular);
    Sum d = kOnlyOwn, s = d;
    // No branches: all loads are under way at once.
    for (int i = 0; i < 4; ++i) {
        const ivec2 step = ivec2[](ivec2(1, 0), ivec2(0, 1), ivec2(1, 1), ivec2(1, -1))[i];
        const Neighbour pair[2] = Neighbour[](look(view, middle, step), look(view, middle, -step));
        const vec2 both = min(pair[0].fits, pair[1].fits);
        for (int side = 0; side < 2; ++side) {
            const vec2 weight = mix(pair[side].fits, both, even);
            add(d, pair[side].diffuse, weight.x, alike(pair[side].diffuse, diffuse));
            add(s, pair[side].specular, weight.y, alike(pair[side].specular, specular));
        }
    }
    diffuse = mean(d, diffuse);
    specular = mean(s, specular);
}

void main() {
    const ViewData view = push.view.data;
    const uvec2 id = gl_GlobalInvocationID.xy;
    if (id.x >= view.width || id.y >= view.height) return;
    const uint pixel = id.y * view.width + id.x;
    const Guide here = unpack_guide(push.guide.v[pixel]);
    Toned diffuse = Toned(vec3(0.0), 0.0, 0.0), specular = diffuse;
    if (!isinf(here.depth)) {
        diffuse = unpack_toned(push.diffuse_in.v[pixel]);
        specular = unpack_toned(push.specular_in.v[pixel]);
        if (push.stride != 0u) filter_around(view, ivec2(id), pixel, here, diffuse, specular);
    }
#ifdef COMPOSITE
    const Demodulation by = demodulation(imageLoad(summary, ivec2(id)));
    push.colors.v[pixel] = pack_half_light(vec4(diffuse.light * by.diffuse + specular.light * by.specular + unpack_light(push.emission.v[pixel]), 1.0));
#else
    push.diffuse_out.v[pixel] = pack_toned(diffuse);
    push.specular_out.v[pixel] = pack_toned(specular);
#endif
}
