#version 460
// Draws the light samples of the tiles, of small pictures only those that are read. Every number is keyed by the sample's place and the
// frame.
// Reads: scene. Writes: tiles. Document 000; Wyman and Panteleev 2021.
// variants: LAYERS
#extension GL_GOOGLE_include_directive : require
#include "lights/tile_code.glsl"

layout(local_size_x = 128) in;
layout(buffer_reference, scalar, buffer_reference_align = 16) writeonly buffer Tiles { TileSample v[]; };
layout(push_constant, scalar) uniform Push {
    Tiles tiles;
    uint frame_index, seed;
    uint width, height;  // of the picture
} push;

// A picture of few squares of 8x8 pixels does not read all tiles.
bool is_read(uint tile) {
    const uint kFew = 64u;
    const uvec2 squares = (uvec2(push.width, push.height) + 7u) / 8u;
    const uint count = squares.x * squares.y;
    if (count > kFew) return true;
    for (uint i = 0u; i < count; ++i)
        if (tile_of(8u * uvec2(i % squares.x, i / squares.x), push.frame_index, push.seed) == tile) return true;
    return false;
}

TileSample draw_sample(uint place) {
    const TileSample none = TileSample(vec3(0.0), 0u, kTileNone << kTileKindShift, 0.0, kNone, 0u);
    const LightPick pick = pick_light(vec3(0.0), vec3(0.0), tile_numbers(place, push.frame_index, push.seed, 0u));
    if (pick.emitter == kNone) return none;
    const vec4 u = tile_numbers(place, push.frame_index, push.seed, 1u);
    const Emitter emitter = scene_emitter(pick.emitter);
    if (emitter.kind != kEmitterMesh) {
        // From the origin: these do not depend on where they are seen from, or by the distance only.
        const LightSample light = sample_light(pick, vec3(0.0), u);
        if (light.infinite) return TileSample(light.wi, 0u, log_code(light.radiance / light.pdf) | (light.is_delta ? kTileDeltaInfinite : kTileInfinite) << kTileKindShift, 1.0 / light.pdf, pick.emitter, 0u);
        return TileSample(emitter.position_ws, 0u, log_code(emitter.intensity / pick.probability) | kTilePoint << kTileKindShift, 1.0 / pick.probability, pick.emitter, 0u);
    }
    const Instance instance = scene_instance(emitter.instance);
    const Geometry geometry = scene_geometry(emitter.geometry);
    const Material material = scene_material(geometry.material);
    const LightPoint point = point_on_mesh(pick, instance, geometry, u.xy);
    if (point.double_area_ws <= 0.0) return none;
    const vec3 radiance = radiance_on_mesh(pick, point, instance, geometry, material, vec3(0.0));
    const float inverse_pdf = 0.5 * point.double_area_ws / pick.probability;
    const uint kind = (material.flags & kMaterialDoubleSided) != 0u ? kTileMeshBothSides : kTileMesh;
    return TileSample(point.position_ws, pack_direction(point.normal / point.double_area_ws), log_code(radiance * inverse_pdf) | kind << kTileKindShift, inverse_pdf, pick.emitter, pick.triangle);
}

void main() {
    const uint place = gl_GlobalInvocationID.x;
    if (place < kTileCount * kTileSamples && is_read(place / kTileSamples)) push.tiles.v[place] = draw_sample(place);
}
