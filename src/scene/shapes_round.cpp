// Shapes with smooth normals and UVs.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <unordered_map>

#include "base/hash.h"
#include "scene/shapes.h"

namespace parhelion {

namespace {


// Two triangles for each cell of a grid of (rows + 1) x (columns + 1) vertices from `base` on; a cell side without length has none.
void add_grid_triangles(Primitive& primitive, uint32_t base, uint32_t rows, uint32_t columns) {
    const auto& p = primitive.positions;
    for (uint32_t row = 0; row < rows; ++row)
        for (uint32_t column = 0; column < columns; ++column) {
            const uint32_t a = base + row * (columns + 1) + column, b = a + columns + 1;
            if (p[a] != p[a + 1]) primitive.triangles.emplace_back(a, a + 1, b + 1);
            if (p[b] != p[b + 1]) primitive.triangles.emplace_back(a, b + 1, b);
        }
}

// Coordinates of the grid lines of one side of a rounded box, relative to the plane `radius` above its inner box.
std::vector<float> rounded_lines(float half, float radius, uint32_t steps, uint32_t cells) {
    std::vector<float> lines;
    const float inner = half - radius;
    for (uint32_t i = 0; i < steps; ++i) lines.push_back(-inner - radius * std::tan(0.25f * std::numbers::pi_v<float> * float(steps - i) / float(steps)));
    for (uint32_t i = 0; i <= cells; ++i) lines.push_back(inner * (2.0f * float(i) / float(cells) - 1.0f));
    for (uint32_t i = 1; i <= steps; ++i) lines.push_back(inner + radius * std::tan(0.25f * std::numbers::pi_v<float> * float(i) / float(steps)));
    lines.front() = -half;
    lines.back() = half;
    return lines;
}

void add_rounded_face(Primitive& box, glm::vec3 half, float radius, uint32_t steps, uint32_t cells, int axis, float side) {
    const int ua = (axis + 1) % 3, va = (axis + 2) % 3;
    const std::vector<float> us = rounded_lines(half[ua], radius, steps, cells), vs = rounded_lines(half[va], radius, steps, cells);
    const uint32_t base = uint32_t(box.positions.size());
    const glm::vec3 inner = half - radius;
    for (size_t row = 0; row < vs.size(); ++row)
        for (size_t column = 0; column < us.size(); ++column) {
            glm::vec3 p;
            p[axis] = side * half[axis];
            p[ua] = side * us[column];  // turned with the side, so that the front stays outside
            p[va] = vs[row];
            const glm::vec3 core = glm::clamp(p, -inner, inner);
            const glm::vec3 n = glm::normalize(p - core);
            box.positions.push_back(core + radius * n);
            box.normals.push_back(n);
            // Upright images on the sides: u to the right seen from outside, v down.
            const glm::vec2 uv = axis == 0   ? glm::vec2(-side * p.z, -p.y)
                                 : axis == 1 ? glm::vec2(p.x, side * p.z)
                                             : glm::vec2(side * p.x, -p.y);
            box.uv0.push_back(uv);
        }
    add_grid_triangles(box, base, uint32_t(vs.size()) - 1, uint32_t(us.size()) - 1);
}

uint64_t position_key(glm::vec3 p) {
    const glm::vec3 rounded = glm::round(p * 1e5f) + 0.0f;
    return Hasher{}.add(rounded.x).add(rounded.y).add(rounded.z).value();
}

}  // namespace

Primitive make_rounded_box(glm::vec3 size, float radius, uint32_t steps, uint32_t cells) {
    Primitive box;
    const glm::vec3 half = 0.5f * size;
    radius = std::min(radius, 0.999f * std::min({half.x, half.y, half.z}));
    for (int axis = 0; axis < 3; ++axis)
        for (const float side : {-1.0f, 1.0f}) add_rounded_face(box, half, radius, steps, cells, axis, side);
    return box;
}

Primitive make_cushion(glm::vec3 size, float radius, float puff) {
    Primitive box = make_rounded_box(size, radius, 3, 8);
    const glm::vec3 half = 0.5f * size;
    for (size_t i = 0; i < box.positions.size(); ++i) {
        const glm::vec3 s = glm::cos(0.5f * std::numbers::pi_v<float> * glm::clamp(box.positions[i] / half, -1.0f, 1.0f));
        const glm::vec3 n = box.normals[i];
        box.positions[i] += puff * n * n * glm::sign(n) * glm::vec3(s.y * s.z, s.z * s.x, s.x * s.y);
    }
    make_smooth_normals(box);
    return box;
}

Primitive make_lathe(std::span<const glm::vec2> profile, uint32_t segments) {
    Primitive lathe;
    const auto direction = [&](size_t i) { return glm::normalize(profile[i + 1] - profile[i]); };
    const float sharp = std::cos(std::numbers::pi_v<float> * 40.0f / 180.0f);
    float along = 0.0f;
    for (size_t i = 0; i + 1 < profile.size(); ++i) {
        const uint32_t base = uint32_t(lathe.positions.size());
        for (const size_t end : {size_t(0), size_t(1)}) {
            glm::vec2 d = direction(i);
            const bool bends = end == 0 ? i > 0 : i + 2 < profile.size();
            const glm::vec2 other = bends ? direction(end == 0 ? i - 1 : i + 1) : d;
            if (glm::dot(other, d) > sharp) d = glm::normalize(d + other);
            const glm::vec2 at = profile[i + end];
            if (end == 1) along += glm::length(profile[i + 1] - profile[i]);
            for (uint32_t s = 0; s <= segments; ++s) {
                const float phi = 2.0f * std::numbers::pi_v<float> * float(s % segments) / float(segments);
                const glm::vec3 out(std::sin(phi), 0.0f, std::cos(phi));
                lathe.positions.push_back(at.x * out + glm::vec3(0.0f, at.y, 0.0f));
                lathe.normals.push_back(glm::normalize(d.y * out - glm::vec3(0.0f, d.x, 0.0f)));
                lathe.uv0.emplace_back(float(s) / float(segments), -along);
            }
        }
        add_grid_triangles(lathe, base, 1, segments);
    }
    return lathe;
}

Primitive make_cylinder(float radius, float height, float bevel, uint32_t segments) {
    const glm::vec2 profile[] = {{0.0f, 0.0f},  {radius - bevel, 0.0f}, {radius, bevel}, {radius, height - bevel}, {radius - bevel, height},
                                 {0.0f, height}};
    return make_lathe(profile, segments);
}

Primitive make_cone(float radius, float height, uint32_t segments) {
    const glm::vec2 profile[] = {{0.0f, 0.0f}, {radius, 0.0f}, {0.0f, height}};
    return make_lathe(profile, segments);
}

Primitive make_torus(float ring, float tube, uint32_t ring_segments, uint32_t tube_segments) {
    Primitive torus;
    for (uint32_t r = 0; r <= ring_segments; ++r)
        for (uint32_t t = 0; t <= tube_segments; ++t) {
            const float phi = 2.0f * std::numbers::pi_v<float> * float(r % ring_segments) / float(ring_segments);
            const float theta = 2.0f * std::numbers::pi_v<float> * float(t % tube_segments) / float(tube_segments);
            const glm::vec3 out(std::sin(phi), 0.0f, std::cos(phi));
            const glm::vec3 n = std::cos(theta) * out + glm::vec3(0.0f, std::sin(theta), 0.0f);
            torus.positions.push_back(ring * out + tube * n);
            torus.normals.push_back(glm::normalize(n));
            torus.uv0.emplace_back(tube * theta, ring * phi);
        }
    for (uint32_t r = 0; r < ring_segments; ++r)
        for (uint32_t t = 0; t < tube_segments; ++t) {
            const uint32_t a = r * (tube_segments + 1) + t, b = a + tube_segments + 1;
            torus.triangles.emplace_back(a, b, b + 1);
            torus.triangles.emplace_back(a, b + 1, a + 1);
        }
    return torus;
}

Primitive make_tube(std::span<const glm::vec3> points, std::span<const float> radii, uint32_t sides) {
    Primitive tube;
    glm::vec3 side(0.0f);
    float along = 0.0f;
    for (size_t i = 0; i < points.size(); ++i) {
        const glm::vec3 t = glm::normalize(points[std::min(i + 1, points.size() - 1)] - points[i == 0 ? 0 : i - 1]);
        // The last ring's side, made square to the new direction: turns as little as possible.
        side -= glm::dot(side, t) * t;
        if (glm::dot(side, side) < 1e-6f) side = glm::cross(t, std::abs(t.y) < 0.9f ? glm::vec3(0, 1, 0) : glm::vec3(1, 0, 0));
        side = glm::normalize(side);
        const glm::vec3 up = glm::cross(side, t);
        if (i > 0) along += glm::length(points[i] - points[i - 1]);
        const float radius = radii.size() == 1 ? radii[0] : radii[i];
        for (uint32_t s = 0; s <= sides; ++s) {
            const float phi = 2.0f * std::numbers::pi_v<float> * float(s % sides) / float(sides);
            const glm::vec3 n = std::cos(phi) * side + std::sin(phi) * up;
            tube.positions.push_back(points[i] + radius * n);
            tube.normals.push_back(glm::normalize(n));
            tube.uv0.emplace_back(float(s) / float(sides), -along);
        }
    }
    for (uint32_t row = 0; row + 1 < points.size(); ++row)
        for (uint32_t s = 0; s < sides; ++s) {
            const uint32_t a = row * (sides + 1) + s, b = a + sides + 1;
            if (tube.positions[a] != tube.positions[a + 1]) tube.triangles.emplace_back(a, b + 1, a + 1);
            if (tube.positions[b] != tube.positions[b + 1]) tube.triangles.emplace_back(a, b, b + 1);
        }
    return tube;
}

std::vector<glm::vec3> smooth_curve(std::span<const glm::vec3> knots, uint32_t steps) {
    std::vector<glm::vec3> out;
    for (size_t i = 0; i + 1 < knots.size(); ++i) {
        const glm::vec3 b = knots[i], c = knots[i + 1];
        const glm::vec3 a = i == 0 ? 2.0f * b - c : knots[i - 1], d = i + 2 == knots.size() ? 2.0f * c - b : knots[i + 2];
        for (uint32_t s = 0; s < steps; ++s) {
            const float t = float(s) / float(steps);
            out.push_back(0.5f *
                          (2.0f * b + t * (c - a) + t * t * (2.0f * a - 5.0f * b + 4.0f * c - d) + t * t * t * (3.0f * (b - c) + d - a)));
        }
    }
    out.push_back(knots.back());
    return out;
}

void add_leaf_card(Primitive& primitive, glm::vec3 base, glm::vec3 along, glm::vec3 across, float bend, uint32_t steps) {
    const glm::vec3 normal = glm::normalize(glm::cross(across, along));
    const uint32_t first = uint32_t(primitive.positions.size());
    for (uint32_t row = 0; row <= steps; ++row) {
        const float t = float(row) / float(steps);
        const glm::vec3 middle = base + t * along - bend * t * t * normal;
        const glm::vec3 n = glm::normalize(glm::cross(across, along - 2.0f * bend * t * normal));
        for (const float s : {0.0f, 1.0f}) {
            primitive.positions.push_back(middle + (s - 0.5f) * across);
            primitive.normals.push_back(n);
            primitive.uv0.emplace_back(s, 1.0f - t);
        }
    }
    add_grid_triangles(primitive, first, steps, 1);
}

void append(Primitive& primitive, const Primitive& part, const glm::mat4& place) {
    const uint32_t base = uint32_t(primitive.positions.size());
    const glm::mat3 linear(place), for_normals = glm::transpose(glm::inverse(linear));
    for (const glm::vec3& p : part.positions) primitive.positions.emplace_back(place * glm::vec4(p, 1.0f));
    for (const glm::vec3& n : part.normals) primitive.normals.push_back(glm::normalize(for_normals * n));
    for (const glm::vec4& t : part.tangents) primitive.tangents.emplace_back(glm::normalize(linear * glm::vec3(t)), t.w);
    primitive.uv0.insert(primitive.uv0.end(), part.uv0.begin(), part.uv0.end());
    for (const glm::uvec3& t : part.triangles) primitive.triangles.push_back(t + base);
}

void make_smooth_normals(Primitive& primitive) {
    std::unordered_map<uint64_t, glm::vec3> sums;
    for (const glm::uvec3& t : primitive.triangles) {
        const glm::vec3 a = primitive.positions[t.x], b = primitive.positions[t.y], c = primitive.positions[t.z];
        const glm::vec3 n = glm::cross(b - a, c - a);
        for (int i = 0; i < 3; ++i) sums[position_key(primitive.positions[t[i]])] += n;
    }
    primitive.normals.assign(primitive.positions.size(), glm::vec3(0.0f, 1.0f, 0.0f));
    for (size_t i = 0; i < primitive.positions.size(); ++i) {
        const auto sum = sums.find(position_key(primitive.positions[i]));
        if (sum != sums.end() && glm::dot(sum->second, sum->second) > 0.0f) primitive.normals[i] = glm::normalize(sum->second);
    }
}

}  // namespace parhelion
