#version 460
// What light tiles say of their samples, seen from a point, beside the samples themselves; and which tile each pixel reads.
// Reads: scene, tiles. Writes: told, read.
#extension GL_GOOGLE_include_directive : require
#include "lights/tile_code.glsl"

struct Told {
    float light, light_is;  // luminance of radiance over density
    float pdf, pdf_is;
    float cosine;           // between the directions
    uint kind;
};

layout(local_size_x = 64) in;
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Tiles { TileSample v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer ToldSamples { Told v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer ReadTiles { uint v[]; };
layout(push_constant, scalar) uniform Push {
    Tiles tiles;
    ToldSamples told;
    ReadTiles read;
    vec3 position_ws;
    uint frame_index, seed, count, width;
} push;

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i < push.width * push.width) push.read.v[i] = tile_of(uvec2(i % push.width, i / push.width), push.frame_index, push.seed);
    if (i >= push.count) return;
    const uint place = tile_of(uvec2(0u), push.frame_index, push.seed) * kTileSamples + i;
    const TileSample t = push.tiles.v[place];
    const TileView view = view_tile_sample(t, push.position_ws);
    Told told = Told(luminance(view.light), 0.0, view.pdf, 0.0, 1.0, t.bits >> kTileKindShift);
    if (told.kind != kTileNone) {
        const LightPick pick = LightPick(t.emitter, t.triangle, pick_probability(t.emitter, t.triangle));
        const LightSample light = sample_light(pick, push.position_ws, tile_numbers(place, push.frame_index, push.seed, 1u));
        told.light_is = light.pdf > 0.0 ? luminance(light.radiance / light.pdf) : 0.0;
        told.pdf_is = light.pdf;
        told.cosine = dot(view.wi, light.wi);
    }
    push.told.v[i] = told;
}
