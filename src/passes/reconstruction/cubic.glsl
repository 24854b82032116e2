// Weights of four neighbours for the place between the middle two. Catmull and Rom 1974.
#ifndef PARHELION_RECONSTRUCTION_CUBIC_GLSL
#define PARHELION_RECONSTRUCTION_CUBIC_GLSL

vec4 catmull_rom(float f) {
    return vec4(f * (-0.5 + f * (1.0 - 0.5 * f)), 1.0 + f * f * (-2.5 + 1.5 * f), f * (0.5 + f * (2.0 - 1.5 * f)), f * f * (-0.5 + 0.5 * f));
}
#endif
