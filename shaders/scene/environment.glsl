// The environment: radiance along a direction, and its sampling triple. The alias table's cells are rectangles in (azimuth,
// cosine of the polar angle), so a cell's density is exact: pmf / solid angle of the cell.
#ifndef PARHELION_SCENE_ENVIRONMENT_GLSL
#define PARHELION_SCENE_ENVIRONMENT_GLSL
#include "lib/alias.glsl"
#include "lib/microfacet.glsl"
#include "scene/scene.glsl"

// World direction to (u, v) of the map: its centre is where a camera looking along -Z looks, +X to the right of it.
vec2 environment_uv(vec3 d) {
    const Environment e = scene.header.environment;
    const vec3 r = vec3(e.rotation_cos * d.x - e.rotation_sin * d.z, d.y, e.rotation_sin * d.x + e.rotation_cos * d.z);
    return vec2(0.5 + atan(r.x, -r.z) / (2.0 * kPi), acos(clamp(r.y, -1.0, 1.0)) / kPi);
}

vec3 environment_direction(float u, float cos_theta) {
    const Environment e = scene.header.environment;
    const float phi = (u - 0.5) * 2.0 * kPi;
    const float sin_theta = sqrt(max(0.0, 1.0 - cos_theta * cos_theta));
    const vec3 r = vec3(sin_theta * sin(phi), cos_theta, -sin_theta * cos(phi));
    return vec3(e.rotation_cos * r.x + e.rotation_sin * r.z, r.y, -e.rotation_sin * r.x + e.rotation_cos * r.z);
}

// Nits along a world direction.
vec3 environment_radiance(vec3 d) {
    const Environment e = scene.header.environment;
    if (e.texture == kNone) return e.scale;
    return e.scale * textureLod(textures[nonuniformEXT(e.texture)], environment_uv(d), 0.0).rgb;
}

float environment_cell_pdf(uint cell) {
    const Environment e = scene.header.environment;
    const uint row = cell / e.table_width;
    const float top = cos(kPi * float(row) / float(e.table_height)), bottom = cos(kPi * float(row + 1u) / float(e.table_height));
    return alias_pmf(scene.header.environment_table, cell) * float(e.table_width) / (2.0 * kPi * (top - bottom));
}

// u.xy choose the cell, u.zw the place in it. Returns the direction, and its density per solid angle in pdf.
vec3 sample_environment(vec4 u, out float pdf) {
    const Environment e = scene.header.environment;
    const uint cell = sample_alias(scene.header.environment_table, e.table_width * e.table_height, u.xy);
    const uint row = cell / e.table_width, column = cell % e.table_width;
    const float top = cos(kPi * float(row) / float(e.table_height)), bottom = cos(kPi * float(row + 1u) / float(e.table_height));
    pdf = environment_cell_pdf(cell);
    return environment_direction((float(column) + u.z) / float(e.table_width), mix(top, bottom, u.w));
}

float pdf_environment_solid_angle(vec3 d) {
    const Environment e = scene.header.environment;
    const vec2 uv = environment_uv(d);
    const uint column = min(uint(uv.x * float(e.table_width)), e.table_width - 1u);
    const uint row = min(uint(uv.y * float(e.table_height)), e.table_height - 1u);
    return environment_cell_pdf(row * e.table_width + column);
}
#endif
