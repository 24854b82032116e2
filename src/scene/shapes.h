#pragma once
// Simple geometry for built-in scenes and tests. All shapes are counter-clockwise seen from their front (outside).
#include <cstdint>

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

// A sphere of rings x 2 rings quads about the origin. Smooth: vertex normals, UVs and tangents; else flat with its own corners shared.
Primitive make_sphere(float radius, uint32_t rings, bool smooth);

}  // namespace parhelion
