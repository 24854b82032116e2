// Multiple importance sampling weights. Veach and Guibas 1995.
#ifndef PARHELION_LIB_MIS_GLSL
#define PARHELION_LIB_MIS_GLSL

// Power heuristic with exponent 2 for one sample of each of two techniques, from the densities in one measure. Written with a
// ratio so that large densities do not overflow when squared.
float mis_power_heuristic(float pdf, float other_pdf) {
    if (pdf <= 0.0) return 0.0;
    const float r = other_pdf / pdf;
    return 1.0 / (1.0 + r * r);
}
#endif
