#pragma once
// Simple geometry for built-in scenes and tests. All shapes are counter-clockwise seen from their front (outside).
#include <cstdint>
#include <span>
#include <vector>

#include "scene/types.h"

namespace parhelion {

// Adds the parallelogram corner, corner + u, corner + u + v, corner + v; its front is where cross(u, v) points. Flat: no normals.
void add_quad(Primitive& primitive, glm::vec3 corner, glm::vec3 u, glm::vec3 v);
// The same with UVs (u along `u`, v against `v`, so that an image stands upright), normals and tangents, in steps x steps cells.
void add_textured_quad(Primitive& primitive, glm::vec3 corner, glm::vec3 u, glm::vec3 v, glm::vec2 uv_scale = glm::vec2(1.0f),
                       uint32_t steps = 1);

// The six faces of an axis-aligned box, flat; facing out, or in for a room.
enum class Facing { Out, In };
void add_box(Primitive& primitive, glm::vec3 min, glm::vec3 max, Facing facing = Facing::Out);

// ---- smooth shapes: unit normals, and UVs in metres unless said otherwise; tangents are left to generate_tangents ----

// A box of this full size about the origin whose edges are rounded with `radius` (metres) in 2 x steps strips; its faces are divided
// into cells x cells.
Primitive make_rounded_box(glm::vec3 size, float radius, uint32_t steps = 2, uint32_t cells = 1);
// The same, blown up by `puff` metres at the middle of its faces: a cushion.
Primitive make_cushion(glm::vec3 size, float radius, float puff);
// Turns the profile, points of (radius, height) from the bottom of the outside on, about +Y. Bends of more than 40 degrees stay sharp.
Primitive make_lathe(std::span<const glm::vec2> profile, uint32_t segments);
// Stand on y = 0. The cylinder's rims are bevelled.
Primitive make_cylinder(float radius, float height, float bevel, uint32_t segments);
Primitive make_cone(float radius, float height, uint32_t segments);
// Lies in the plane y = 0: `ring` from the middle to the tube's axis, `tube` the tube's radius.
Primitive make_torus(float ring, float tube, uint32_t ring_segments, uint32_t tube_segments);
// A round tube along the points with these radii (as many as points, or one for all), open at its ends unless a radius there is 0.
Primitive make_tube(std::span<const glm::vec3> points, std::span<const float> radii, uint32_t sides);
// Points on the Catmull-Rom spline through `knots`, `steps` to a span.
std::vector<glm::vec3> smooth_curve(std::span<const glm::vec3> knots, uint32_t steps);
// A card for a leaf, from its stem at `base`: along its middle, full width `across` (a vector), drooping by `bend` metres against
// its normal towards the tip. UVs are [0, 1], the tip at the image's top. To be drawn double-sided.
void add_leaf_card(Primitive& primitive, glm::vec3 base, glm::vec3 along, glm::vec3 across, float bend, uint32_t steps = 1);

// Adds `part`, moved by `place`, which must not mirror. Both have the same attributes, or `primitive` is empty.
void append(Primitive& primitive, const Primitive& part, const glm::mat4& place = glm::mat4(1.0f));
// Normals from the triangles, weighted by area, shared by vertices in the same place.
void make_smooth_normals(Primitive& primitive);

// A sphere of rings x 2 rings quads about the origin. Smooth: vertex normals, UVs and tangents; else flat with its own corners shared.
Primitive make_sphere(float radius, uint32_t rings, bool smooth);

}  // namespace parhelion
