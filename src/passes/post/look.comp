#version 460
// Any image of a frame as something to look at, in the size of what it is shown in: light by gain, whole numbers as a colour each (WHOLE).
// Reads: image. Writes: ldr.
// variants: WHOLE
#extension GL_GOOGLE_include_directive : require
#include "lib/hash.glsl"
#include "lib/tonemap.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
#ifdef WHOLE
layout(set = 1, binding = 0) uniform usampler2D image;
#else
layout(set = 1, binding = 0) uniform sampler2D image;
#endif
layout(set = 1, binding = 1, rgba8) uniform writeonly image2D ldr;
layout(push_constant, scalar) uniform Push {
    uint width, height;
    float gain;
    uint channel_count;  // of the image; one is shown in grey
} push;

vec3 look_at_texel(ivec2 texel) {
#ifdef WHOLE
    const uvec4 value = texelFetch(image, texel, 0);
    uint key = value.x;
    for (uint i = 1u; i < push.channel_count; ++i) key = hash_combine(key, value[i]);
    return vec3(unpackUnorm4x8(pcg_hash(key)));
#else
    // Below zero is shown, too: motion and normals have signs.
    const vec4 value = abs(texelFetch(image, texel, 0)) * push.gain;
    const vec3 shown = push.channel_count == 1u ? value.xxx : push.channel_count == 2u ? vec3(value.xy, 0.0) : value.xyz;
    return tonemap_to_srgb(min(shown, vec3(1.0)), 0u);
#endif
}

void main() {
    const uvec2 p = gl_GlobalInvocationID.xy;
    if (p.x >= push.width || p.y >= push.height) return;
    const uvec2 size = uvec2(textureSize(image, 0));
    imageStore(ldr, ivec2(p), vec4(look_at_texel(ivec2(p * size / uvec2(push.width, push.height))), 1.0));
}
