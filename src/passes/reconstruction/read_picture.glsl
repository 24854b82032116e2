// The picture of the last frame, between its pixels. Needs `history` and `push` of antialias.comp.
#ifndef PARHELION_RECONSTRUCTION_READ_PICTURE_GLSL
#define PARHELION_RECONSTRUCTION_READ_PICTURE_GLSL
#include "reconstruction/cubic.glsl"

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
#endif
