// How bright light looks, by which the spatial filter tells light apart: stops above a sixty-fourth of white. Of luminance single frames' outliers make most of the
// variance, and hide the edges of shadows; here they are a few stops.
#ifndef PARHELION_RECONSTRUCTION_TONE_GLSL
#define PARHELION_RECONSTRUCTION_TONE_GLSL

float tone_of(float luminance) { return log2(1.0 + 64.0 * luminance); }
float luminance_of(float tone) { return (exp2(tone) - 1.0) / 64.0; }

// Light, its mean tone and how far that may be off.
struct Toned {
    vec3 light;
    float tone, deviation;
};

// Light as halves; the tone in 10 bits, its deviation in 6, finer where it is small.
const float kMostTone = 23.0, kMostToneDeviation = 4.0;
uvec2 pack_toned(Toned x) {
    const vec3 light = clamp(x.light, vec3(0.0), vec3(65504.0));
    const uint tone = uint(clamp(x.tone / kMostTone, 0.0, 1.0) * 1023.0 + 0.5), deviation = uint(sqrt(clamp(x.deviation / kMostToneDeviation, 0.0, 1.0)) * 63.0 + 0.5);
    return uvec2(packHalf2x16(light.rg), packHalf2x16(vec2(light.b, 0.0)) | tone << 16 | deviation << 26);
}
Toned unpack_toned(uvec2 bits) {
    const float root = float(bits.y >> 26) / 63.0;
    return Toned(vec3(unpackHalf2x16(bits.x), unpackHalf2x16(bits.y & 0xFFFFu).x), float(bits.y >> 16 & 1023u) * (kMostTone / 1023.0), root * root * kMostToneDeviation);
}
#endif
