// Maps of the unit square onto shapes, each with its density. Where the renderer needs no density by itself, tests alone ask for it:
// it is part of the triple. Random numbers are multiples of 2^-24 in [0, 1). Directions are unit vectors in a frame whose z axis is
// the normal or the axis.
#ifndef PARHELION_LIB_WARP_GLSL
#define PARHELION_LIB_WARP_GLSL

const float kWarpPi = 3.14159265358979;
const float kWarpInvPi = 0.31830988618379;

// Weights of vertex 1 and 2 of a point uniform on a triangle. Heitz 2019, "A Low-Distortion Map Between Triangle and Square".
vec2 sample_triangle(vec2 u) {
    if (u.y > u.x) {
        u.x *= 0.5;
        u.y -= u.x;
    } else {
        u.y *= 0.5;
        u.x -= u.y;
    }
    return u;
}

// Density per solid angle of a point that is uniform on a triangle, seen from distance^2 under |cosine| to its normal.
float pdf_triangle_solid_angle(float area, float distance_squared, float cosine) { return distance_squared / (area * cosine); }

// A point uniform on the unit disk, strictly inside it. Shirley and Chiu 1997, "A Low Distortion Map Between Disk and Square".
vec2 sample_concentric_disk(vec2 u) {
    // Centres of the 2^-24 cells: exact, symmetric, and never -1 or 1.
    const vec2 p = 2.0 * u + (5.9604645e-8 - 1.0);
    if (abs(p.x) > abs(p.y)) {
        const float phi = 0.25 * kWarpPi * (p.y / p.x);
        return p.x * vec2(cos(phi), sin(phi));
    }
    if (p.y == 0.0) return vec2(0.0);
    const float phi = 0.25 * kWarpPi * (p.x / p.y);
    return p.y * vec2(sin(phi), cos(phi));
}
float pdf_concentric_disk_area() { return kWarpInvPi; }

// Density cos / pi around +z: the disk lifted to the sphere (Malley). z > 0.
vec3 sample_cosine_hemisphere(vec2 u) {
    const vec2 p = sample_concentric_disk(u);
    return vec3(p, sqrt(max(1.0 - dot(p, p), 5.9604645e-8)));
}
float pdf_cosine_hemisphere_solid_angle(float cos_theta) { return max(cos_theta, 0.0) * kWarpInvPi; }

vec3 sample_uniform_sphere(vec2 u) {
    const float z = 1.0 - 2.0 * u.x;
    const float r = 2.0 * sqrt(u.x * (1.0 - u.x));
    const float phi = 2.0 * kWarpPi * u.y;
    return vec3(r * cos(phi), r * sin(phi), z);
}
float pdf_uniform_sphere_solid_angle() { return 0.25 * kWarpInvPi; }

// Uniform within a cone around +z. The opening is given as 1 - cos(half angle) = 2 sin^2(half angle / 2), which keeps its
// precision for cones as narrow as the sun's.
vec3 sample_cone(vec2 u, float one_minus_cos_max) {
    const vec2 p = sample_concentric_disk(u);
    const float one_minus_cos = one_minus_cos_max * dot(p, p);
    return vec3(p * sqrt(one_minus_cos_max * (2.0 - one_minus_cos)), 1.0 - one_minus_cos);
}
float pdf_cone_solid_angle(float one_minus_cos_max) { return 0.5 * kWarpInvPi / one_minus_cos_max; }
#endif
