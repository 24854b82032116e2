// Colour arithmetic on linear Rec.709.
#ifndef PARHELION_LIB_COLOR_GLSL
#define PARHELION_LIB_COLOR_GLSL

float luminance(vec3 rgb) { return dot(rgb, vec3(0.2126, 0.7152, 0.0722)); }
float max_component(vec3 v) { return max(v.x, max(v.y, v.z)); }
#endif
