// Three values in 27 bits by their logarithms: from 2^-40 to 2^40, within 6 %. For weights, which may be coarse.
#ifndef PARHELION_LIB_LOG_CODE_GLSL
#define PARHELION_LIB_LOG_CODE_GLSL

// A value > 0 never becomes 0: the code must not lose light.
uint log_code(float x) { return x > 0.0 ? uint(clamp(1.0 + round((log2(x) + 40.0) * (510.0 / 80.0)), 1.0, 511.0)) : 0u; }
float log_value(uint code) { return code == 0u ? 0.0 : exp2((float(code) - 1.0) * (80.0 / 510.0) - 40.0); }
uint log_code(vec3 x) { return log_code(x.r) | (log_code(x.g) << 9) | (log_code(x.b) << 18); }
vec3 log_values(uint bits) { return vec3(log_value(bits & 511u), log_value(bits >> 9 & 511u), log_value(bits >> 18 & 511u)); }
#endif
