// Affine transforms as three rows (shared/scene.h), with the same roundings in whatever shader they are compiled. Also compiled
// as C++ (shared/functions.h).
#ifndef PARHELION_LIB_AFFINE_GLSL
#define PARHELION_LIB_AFFINE_GLSL
#include "shared/functions.h"
#include "shared/scene.h"
SHARED_BEGIN

SHARED_FN vec3 transform_vector(Affine a, vec3 v) {
    SHARED_PRECISE vec3 r;
    r.x = (a.row0.x * v.x + a.row0.y * v.y) + a.row0.z * v.z;
    r.y = (a.row1.x * v.x + a.row1.y * v.y) + a.row1.z * v.z;
    r.z = (a.row2.x * v.x + a.row2.y * v.y) + a.row2.z * v.z;
    return r;
}

// Normals go by the transposed inverse: pass object_from_world to take a normal from object to world. Not normalised.
SHARED_FN vec3 transform_normal(Affine inverse, vec3 n) {
    SHARED_PRECISE vec3 r;
    r = (n.x * vec3(inverse.row0) + n.y * vec3(inverse.row1)) + n.z * vec3(inverse.row2);
    return r;
}

// The same by the transform itself, which has no inverse at hand: its cofactors are the transposed inverse times the determinant.
SHARED_FN vec3 transform_normal_by_cofactors(Affine a, vec3 n) {
    const vec3 x = vec3(a.row0), y = vec3(a.row1), z = vec3(a.row2);
    const vec3 r = vec3(dot(cross(y, z), n), dot(cross(z, x), n), dot(cross(x, y), n));
    return dot(x, cross(y, z)) < 0.0f ? -r : r;
}

// A point and absolute bounds of its rounding error, given the bounds of p's own. Higham 2002, gamma_n = n u / (1 - n u) with
// u = 2^-24; a product that goes through three sums is off by gamma_4 of its absolute value (Pharr, Jakob, Humphreys 2016, 3.9.1).
SHARED_FN vec3 transform_point_precise(Affine a, vec3 p, vec3 p_error, SHARED_INOUT(vec3) error) {
    SHARED_PRECISE vec3 r;
    r.x = ((a.row0.x * p.x + a.row0.y * p.y) + a.row0.z * p.z) + a.row0.w;
    r.y = ((a.row1.x * p.x + a.row1.y * p.y) + a.row1.z * p.z) + a.row1.w;
    r.z = ((a.row2.x * p.x + a.row2.y * p.y) + a.row2.z * p.z) + a.row2.w;
    const float gamma_4 = 4.0f * 5.9604645e-8f / (1.0f - 4.0f * 5.9604645e-8f);
    const vec3 row0 = abs(vec3(a.row0)), row1 = abs(vec3(a.row1)), row2 = abs(vec3(a.row2)), q = abs(p);
    error = gamma_4 * (vec3(dot(row0, q), dot(row1, q), dot(row2, q)) + abs(vec3(a.row0.w, a.row1.w, a.row2.w)));
    error += (1.0f + gamma_4) * vec3(dot(row0, p_error), dot(row1, p_error), dot(row2, p_error));
    return r;
}

SHARED_END
#endif
