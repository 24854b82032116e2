// What light is divided by before it is filtered, and multiplied by again after: the surface's colours, so that textures stay sharp. By the
// summary alone, so that both sides have the same bits.
#ifndef PARHELION_REALTIME_DEMODULATE_GLSL
#define PARHELION_REALTIME_DEMODULATE_GLSL

struct Demodulation {
    vec3 diffuse, specular;
};

Demodulation demodulation(uvec4 summary) {
    const vec3 color = pow(unpackUnorm4x8(summary.x).rgb, vec3(2.2));
    const vec2 rest = unpackUnorm4x8(summary.z).rg;  // reflectance, metallic
    // Neither is ever so small that light would be lost in the quotient.
    return Demodulation(max(color * (1.0 - rest.y), vec3(0.01)), max(mix(vec3(0.16 * rest.x * rest.x), color, rest.y), vec3(0.01)));
}
#endif
