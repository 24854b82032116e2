#version 460
// What reconstruction gets of a frame, unpacked for who reads it outside of the program: planes of 32-bit words (shared/reconstruction.h).
// Reads: view, identity, summary, motion, depth, signals (diffuse, specular, emission, distances). Writes: planes.
#extension GL_GOOGLE_include_directive : require
#include "lib/packed_light.glsl"
#include "realtime/demodulate.glsl"
#include "reconstruction/surfaces.glsl"
#include "scene/ray.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 1, binding = 0, rgba32ui) uniform readonly uimage2D identity;
layout(set = 1, binding = 1, rgba32ui) uniform readonly uimage2D summary;
layout(set = 1, binding = 2, rg32f) uniform readonly image2D motion;
layout(set = 1, binding = 3, r32f) uniform readonly image2D depth;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ViewBlock { ViewData data; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Light { PackedLight v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Words { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Planes { uint v[]; };
layout(push_constant, scalar) uniform Push {
    ViewBlock view;
    Light diffuse, specular, emission;
    Words distances;
    Planes planes;
} push;

void keep(uint plane, uint pixel, uint pixels, float value) { push.planes.v[plane * pixels + pixel] = floatBitsToUint(value); }
void keep(uint plane, uint pixel, uint pixels, vec2 value) {
    keep(plane, pixel, pixels, value.x);
    keep(plane + 1u, pixel, pixels, value.y);
}
void keep(uint plane, uint pixel, uint pixels, vec3 value) {
    keep(plane, pixel, pixels, value.xy);
    keep(plane + 2u, pixel, pixels, value.z);
}

void main() {
    const uvec2 id = gl_GlobalInvocationID.xy;
    const ivec2 at = ivec2(id), size = imageSize(identity);
    if (any(greaterThanEqual(at, size))) return;
    const uint pixels = uint(size.x) * uint(size.y), pixel = id.y * uint(size.x) + id.x;
    const uvec4 which = imageLoad(identity, at), packed = imageLoad(summary, at);
    const Hit hit = Hit(which.x, which.y, which.z, 0u, 0.0);
    const uint surface = packed.z >> kSummaryIdShift;
    const bool sky = surface == 0u;
    const Guide guide = unpack_guide(pack_guide(imageLoad(depth, at).x, push.view.data.camera.orthographic != 0u, packed));
    const Demodulation by = demodulation(packed);
    keep(kInputDiffuse, pixel, pixels, unpack_light(push.diffuse.v[pixel]));
    keep(kInputSpecular, pixel, pixels, unpack_light(push.specular.v[pixel]));
    keep(kInputEmission, pixel, pixels, unpack_light(push.emission.v[pixel]));
    keep(kInputAlbedo, pixel, pixels, by.diffuse);
    keep(kInputSpecularAlbedo, pixel, pixels, by.specular);
    keep(kInputNormal, pixel, pixels, sky ? vec3(0.0) : guide.normal);
    keep(kInputGeometricNormal, pixel, pixels, sky ? vec3(0.0) : unpack_direction(which.w));
    keep(kInputRoughness, pixel, pixels, guide.roughness);
    keep(kInputHits, pixel, pixels, unpackHalf2x16(push.distances.v[pixel]));
    keep(kInputDepth, pixel, pixels, guide.depth);
    keep(kInputMotion, pixel, pixels, imageLoad(motion, at).xy);
    push.planes.v[kInputSurface * pixels + pixel] = surface;
    const uvec3 ids = is_miss(hit) ? uvec3(0xFFFFFFFFu) : uvec3(hit_instance(hit), which.yz);
    for (uint k = 0u; k < 3u; ++k) push.planes.v[(kInputIds + k) * pixels + pixel] = ids[k];
}
