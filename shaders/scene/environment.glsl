// The environment: radiance along a direction, and its sampling triple. The alias table's cells are rectangles in (azimuth,
// cosine of the polar angle), so that a cell has one density; the table's `pmf` is that density, per solid angle.
#ifndef PARHELION_SCENE_ENVIRONMENT_GLSL
#define PARHELION_SCENE_ENVIRONMENT_GLSL
#include "lib/alias.glsl"
#include "lib/microfacet.glsl"
#include "scene/scene.glsl"

// World direction to (u, v) of the map: its centre is where a camera looking along -Z looks, +X to the right of it.
vec2 environment_uv(vec3 d) {
    const Environment e = scene.header.environment;
    const vec3 r = vec3(e.rotation_cos * d.x - e.rotation_sin * d.z, d.y, e.rotation_sin * d.x + e.rotation_cos * d.z);
    const bool at_pole = r.x == 0.0 && r.z == 0.0;  // no azimuth, and no atan
    return vec2(at_pole ? 0.5 : 0.5 + atan(r.x, -r.z) / (2.0 * kPi), atan(length(r.xz), r.y) / kPi);
}

// The direction under an azimuth (u) and a polar angle theta from +Y, or from -Y: h = sin^2(theta / 2) keeps its digits at the pole.
vec3 environment_direction(float u, float h, bool from_below) {
    const Environment e = scene.header.environment;
    const float phi = (u - 0.5) * 2.0 * kPi;
    const float sin_theta = 2.0 * sqrt(max(0.0, h * (1.0 - h)));
    const vec3 r = vec3(sin_theta * sin(phi), from_below ? 2.0 * h - 1.0 : 1.0 - 2.0 * h, -sin_theta * cos(phi));
    return vec3(e.rotation_cos * r.x + e.rotation_sin * r.z, r.y, -e.rotation_sin * r.x + e.rotation_cos * r.z);
}

// Nits along a world direction.
vec3 environment_radiance(vec3 d) {
    const Environment e = scene.header.environment;
    if (e.texture == kNone) return e.scale;
    return e.scale * textureLod(textures[nonuniformEXT(e.texture)], environment_uv(d), 0.0).rgb;
}

// sin^2 of an angle in [0, pi / 2], exact to rounding: a device's own sine has no digits left for the rows at the poles.
float sine_squared(float x) {
    const float s = x * x;
    const float sine = x * (1.0 - s / 6.0 * (1.0 - s / 20.0 * (1.0 - s / 42.0 * (1.0 - s / 72.0 * (1.0 - s / 110.0)))));
    return sine * sine;
}

// u.xy choose the cell, u.zw the place in it. Returns the direction, and its density per solid angle in pdf.
vec3 sample_environment(vec4 u, out float pdf) {
    const Environment e = scene.header.environment;
    const uint cell = sample_alias(scene.header.environment_table, e.table_width * e.table_height, u.xy);
    const uint row = cell / e.table_width, column = cell % e.table_width;
    pdf = alias_pmf(scene.header.environment_table, cell);
    const bool from_below = 2u * row + 1u > e.table_height;
    const float rows = float(from_below ? e.table_height - 1u - row : row), step = 0.5 * kPi / float(e.table_height);
    return environment_direction((float(column) + u.z) / float(e.table_width), mix(sine_squared(rows * step), sine_squared((rows + 1.0) * step), u.w), from_below);
}

float pdf_environment_solid_angle(vec3 d) {
    const Environment e = scene.header.environment;
    const vec2 uv = environment_uv(d);
    const uint column = min(uint(uv.x * float(e.table_width)), e.table_width - 1u);
    const uint row = min(uint(uv.y * float(e.table_height)), e.table_height - 1u);
    return alias_pmf(scene.header.environment_table, row * e.table_width + column);
}
#endif
