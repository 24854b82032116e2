// Affine transforms as three rows (shared/scene.h), plain and with rounding error bounds.
#ifndef PARHELION_LIB_AFFINE_GLSL
#define PARHELION_LIB_AFFINE_GLSL
#include "shared/scene.h"

vec3 transform_point(Affine a, vec3 p) { return vec3(dot(a.row0, vec4(p, 1.0)), dot(a.row1, vec4(p, 1.0)), dot(a.row2, vec4(p, 1.0))); }
vec3 transform_vector(Affine a, vec3 v) { return vec3(dot(a.row0.xyz, v), dot(a.row1.xyz, v), dot(a.row2.xyz, v)); }

// Normals go by the transposed inverse: pass object_from_world to take a normal from object to world. Not normalised.
vec3 transform_normal(Affine inverse, vec3 n) { return n.x * inverse.row0.xyz + n.y * inverse.row1.xyz + n.z * inverse.row2.xyz; }

// A point and absolute bounds of its rounding error, given the bounds of p's own. Higham 2002, gamma_n = n u / (1 - n u);
// three products and three sums are gamma_4 of the absolute values (Pharr, Jakob, Humphreys 2016, 3.9.1).
vec3 transform_point_precise(Affine a, vec3 p, vec3 p_error, out vec3 error) {
    precise vec3 r;
    r.x = ((a.row0.x * p.x + a.row0.y * p.y) + a.row0.z * p.z) + a.row0.w;
    r.y = ((a.row1.x * p.x + a.row1.y * p.y) + a.row1.z * p.z) + a.row1.w;
    r.z = ((a.row2.x * p.x + a.row2.y * p.y) + a.row2.z * p.z) + a.row2.w;
    const float kGamma4 = 4.0 * 5.9604645e-8 / (1.0 - 4.0 * 5.9604645e-8);
    const vec3 q = abs(p);
    error = kGamma4 * vec3(dot(abs(a.row0), vec4(q, 1.0)), dot(abs(a.row1), vec4(q, 1.0)), dot(abs(a.row2), vec4(q, 1.0)));
    error += (1.0 + kGamma4) * vec3(dot(abs(a.row0.xyz), p_error), dot(abs(a.row1.xyz), p_error), dot(abs(a.row2.xyz), p_error));
    return r;
}
#endif
