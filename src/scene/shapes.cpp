#include "scene/shapes.h"

#include <cmath>

namespace parhelion {

void add_quad(Primitive& primitive, glm::vec3 corner, glm::vec3 u, glm::vec3 v) {
    const uint32_t base = static_cast<uint32_t>(primitive.positions.size());
    primitive.positions.insert(primitive.positions.end(), {corner, corner + u, corner + u + v, corner + v});
    primitive.triangles.emplace_back(base, base + 1, base + 2);
    primitive.triangles.emplace_back(base, base + 2, base + 3);
}

void add_textured_quad(Primitive& primitive, glm::vec3 corner, glm::vec3 u, glm::vec3 v, glm::vec2 uv_scale, uint32_t steps) {
    const uint32_t base = static_cast<uint32_t>(primitive.positions.size());
    const glm::vec3 normal = glm::normalize(glm::cross(u, v));
    const glm::vec4 tangent(glm::normalize(u), 1.0f);
    for (uint32_t row = 0; row <= steps; ++row)
        for (uint32_t column = 0; column <= steps; ++column) {
            const float s = float(column) / float(steps), t = float(row) / float(steps);
            primitive.positions.push_back(corner + s * u + t * v);
            primitive.normals.push_back(normal);
            primitive.tangents.push_back(tangent);
            primitive.uv0.push_back(glm::vec2(s, 1.0f - t) * uv_scale);
        }
    for (uint32_t row = 0; row < steps; ++row)
        for (uint32_t column = 0; column < steps; ++column) {
            const uint32_t a = base + row * (steps + 1) + column, b = a + steps + 1;
            primitive.triangles.emplace_back(a, a + 1, b + 1);
            primitive.triangles.emplace_back(a, b + 1, b);
        }
}

void add_box(Primitive& primitive, glm::vec3 min, glm::vec3 max, Facing facing) {
    const glm::vec3 size = max - min;
    for (int axis = 0; axis < 3; ++axis) {
        glm::vec3 u(0.0f), v(0.0f);
        u[(axis + 1) % 3] = size[(axis + 1) % 3];
        v[(axis + 2) % 3] = size[(axis + 2) % 3];
        glm::vec3 far_corner = min;
        far_corner[axis] = max[axis];
        if (facing == Facing::In) std::swap(u, v);
        add_quad(primitive, far_corner, u, v);
        add_quad(primitive, min, v, u);
    }
}

Primitive make_sphere(float radius, uint32_t rings, bool smooth) {
    constexpr double kPi = 3.14159265358979323846;
    Primitive sphere;
    const uint32_t segments = 2 * rings;
    for (uint32_t ring = 0; ring <= rings; ++ring)
        for (uint32_t segment = 0; segment <= segments; ++segment) {
            // The seam and the poles repeat exact coordinates, so that the surface is closed.
            const double phi = 2.0 * kPi * (segment % segments) / segments, theta = kPi * ring / rings;
            const double sin_theta = ring == 0 || ring == rings ? 0.0 : std::sin(theta);
            const glm::dvec3 n(sin_theta * std::sin(phi), std::cos(theta), sin_theta * std::cos(phi));
            sphere.positions.emplace_back(n * double(radius));
            if (!smooth) continue;
            sphere.normals.emplace_back(n);
            sphere.tangents.emplace_back(float(std::cos(phi)), 0.0f, float(-std::sin(phi)), 1.0f);
            sphere.uv0.emplace_back(float(segment) / float(segments), float(ring) / float(rings));
        }
    for (uint32_t ring = 0; ring < rings; ++ring)
        for (uint32_t segment = 0; segment < segments; ++segment) {
            const uint32_t a = ring * (segments + 1) + segment, b = a + segments + 1;
            if (ring != rings - 1) sphere.triangles.emplace_back(a, b, b + 1);
            if (ring != 0) sphere.triangles.emplace_back(a, b + 1, a + 1);
        }
    return sphere;
}

}  // namespace parhelion
