#include "support/motion_check.h"

#include <algorithm>
#include <array>
#include <bit>
#include <map>
#include <utility>

#include "scene/deform.h"

namespace parhelion::testing {

namespace {

// Where a point of a triangle is that now lies elsewhere.
glm::dvec3 carried(const Primitive& from, const glm::mat4& from_place, const Primitive& to, const glm::mat4& to_place, uint32_t primitive, glm::dvec3 point) {
    const auto corner = [](const Primitive& p, const glm::mat4& place, uint32_t i) { return glm::dvec3(glm::dmat4(place) * glm::dvec4(p.positions[i], 1.0)); };
    const glm::uvec3 t = from.triangles[primitive];
    const glm::dvec3 a = corner(from, from_place, t.x), u = corner(from, from_place, t.y) - a, v = corner(from, from_place, t.z) - a, n = glm::cross(u, v), d = point - a;
    const double x = glm::dot(glm::cross(d, v), n) / glm::dot(n, n), y = glm::dot(glm::cross(u, d), n) / glm::dot(n, n);
    return (1 - x - y) * corner(to, to_place, t.x) + x * corner(to, to_place, t.y) + y * corner(to, to_place, t.z);
}

// A camera's film in pixels.
struct Film {
    const CameraView& camera;
    double size;
    glm::dvec2 half;

    glm::dvec3 at_depth(glm::dvec2 pixel, double depth) const {
        return glm::dvec3(camera.position) + depth * (glm::dvec3(camera.forward) + (2 * pixel.x / size - 1) * half.x * glm::dvec3(camera.right) + (1 - 2 * pixel.y / size) * half.y * glm::dvec3(camera.up));
    }
    glm::dvec2 pixel_of(glm::dvec3 point) const {
        const glm::dvec3 offset = point - glm::dvec3(camera.position);
        const double along = glm::dot(offset, glm::dvec3(camera.forward));
        return size / 2 * glm::dvec2(1 + glm::dot(offset, glm::dvec3(camera.right)) / along / half.x, 1 - glm::dot(offset, glm::dvec3(camera.up)) / along / half.y);
    }
};

}  // namespace

MotionFound check_motion(const Scene& now, const Scene& before, const CameraView& camera, const image::FilmSums& film) {
    const auto words = [&](std::string_view channel) { return std::span(std::ranges::find(film.exact, channel, &image::ExactLayer::channel)->words); };
    const auto ids = words("ids.instance"), geometries = words("ids.geometry"), primitives = words("ids.primitive"), depth = words("depth"), motion_x = words("motion.X"), motion_y = words("motion.Y");
    const auto number = [](uint32_t word) { return double(std::bit_cast<float>(word)); };
    const uint32_t size = film.width;
    const Film on{camera, double(size), glm::dvec2(camera.image_half_extents(1.0f))};
    // Rows are slots while nothing has gone. Each geometry is deformed once.
    std::map<std::pair<uint32_t, uint32_t>, std::array<Primitive, 2>> shapes;
    MotionFound found;
    for (size_t p = 0; p < film.pixel_count(); ++p) {
        if (ids[p] >= now.instances().slot_count()) continue;  // the sky
        const Instance &at = now.get(*now.instances().handle_at(ids[p])), &was = before.get(*before.instances().handle_at(ids[p]));
        const Mesh &mesh = now.get(at.drawn_mesh()), &mesh_before = before.get(was.drawn_mesh());
        if (!mesh.rest) continue;
        const auto [entry, fresh] = shapes.try_emplace({ids[p], geometries[p]});
        if (fresh) {
            Primitive storage;
            entry->second[0] = drawn_shape(now, mesh, geometries[p], storage);
            entry->second[1] = drawn_shape(before, mesh_before, geometries[p], storage);
        }
        const glm::dvec2 centre(double(p % size) + 0.5, double(p / size) + 0.5), motion(number(motion_x[p]), number(motion_y[p]));
        const glm::dvec3 point = carried(entry->second[0], at.place.world_from_object, entry->second[1], was.place.world_from_object, primitives[p], on.at_depth(centre, number(depth[p])));
        found.off.push_back(glm::length(motion - (on.pixel_of(point) - centre)));
        found.moved = std::max(found.moved, glm::length(motion));
    }
    std::ranges::sort(found.off);
    return found;
}

}  // namespace parhelion::testing
