// Where a camera stands while its shutter is open. Also compiled as C++ (shared/functions.h); the same bits everywhere: sums and
// products only, no fused ones.
#ifndef PARHELION_LIB_CAMERA_MOTION_GLSL
#define PARHELION_LIB_CAMERA_MOTION_GLSL
#include "lib/hash.glsl"
#include "lib/sobol.glsl"
#include "shared/view.h"
SHARED_BEGIN

// The moment of a sample: the share of the shutter's time that has passed, in [0, 1). One for all pixels, so that a whole sample is
// one moment; stratified in every aligned block of 2^k samples. Its order and its digits are scrambled apart from those of every
// pixel's own numbers, which it therefore does not follow (Burley 2020). No pixel has y = 0xFFFFFFFF.
SHARED_FN float shutter_share(uint sample_index, uint seed) {
    const uvec4 h = pcg4d(uvec4(0u, 0xFFFFFFFFu, seed, 0u));
    return uint_to_unit_float(owen_sobol_2d(sample_index, uvec3(h.x, h.y, h.z)).x);
}

// (sin x, cos x) for x in [0, pi / 2], to 2e-7: Taylor's series, because devices promise no more than 2^-11 of their own.
SHARED_FN vec2 sine_and_cosine(float x) {
    SHARED_PRECISE const float q = x * x;
    SHARED_PRECISE const float s = 1.0f - q * (0.16666667f - q * (8.3333333e-3f - q * (1.9841270e-4f - q * (2.7557319e-6f - q * (2.5052108e-8f - q * 1.6059044e-10f)))));
    SHARED_PRECISE const float c = 1.0f - q * (0.5f - q * (4.1666667e-2f - q * (1.3888889e-3f - q * (2.4801587e-5f - q * (2.7557319e-7f - q * 2.0876757e-9f)))));
    SHARED_PRECISE const float sine = x * s;
    return vec2(sine, c);
}

// v turned by the unit quaternion (q, w): v + 2 w (q x v) + 2 q x (q x v).
SHARED_FN vec3 turn_vector(vec3 v, vec3 q, float w) {
    SHARED_PRECISE const vec3 a = vec3(q.y * v.z - q.z * v.y, q.z * v.x - q.x * v.z, q.x * v.y - q.y * v.x);
    SHARED_PRECISE const vec3 b = vec3(q.y * a.z - q.z * a.y, q.z * a.x - q.x * a.z, q.x * a.y - q.y * a.x);
    SHARED_PRECISE const vec3 turned = v + 2.0f * (w * a + b);
    return turned;
}

// The camera at a share of the shutter's time: its position moves evenly along a line, its frame turns evenly about one axis
// (Shoemake 1985, slerp) and stays orthogonal, the extents of its image grow evenly.
SHARED_FN Camera camera_at(Camera camera, CameraMotion motion, float share) {
    SHARED_PRECISE const vec3 position = camera.position_ws + share * motion.translation_ws;
    SHARED_PRECISE const float half_angle = share * motion.half_angle;
    const vec2 turn = sine_and_cosine(half_angle);
    SHARED_PRECISE const vec3 q = turn.x * motion.axis_ws;
    SHARED_PRECISE const vec2 growth = vec2(1.0f) + share * motion.zoom;
    SHARED_PRECISE const vec3 right = growth.x * turn_vector(camera.right_ws, q, turn.y);
    SHARED_PRECISE const vec3 up = growth.y * turn_vector(camera.up_ws, q, turn.y);
    Camera moved = camera;
    moved.position_ws = position;
    moved.right_ws = right;
    moved.up_ws = up;
    moved.forward_ws = turn_vector(camera.forward_ws, q, turn.y);
    return moved;
}

SHARED_END
#endif
