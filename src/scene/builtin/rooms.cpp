// A closed room with bumpy spheres, for measuring rays: `parhelion bench trace`. Three sizes, each as one mesh (flat) and as a few
// meshes with many instances; both hold the same triangles at the same places.
#include <array>
#include <cmath>
#include <numbers>

#include "scene/builtin/random.h"
#include "scene/builtin/scenes.h"
#include "scene/median_order.h"
#include "scene/shapes.h"

namespace parhelion::builtin {

namespace {

// 2 x segments x (rings - 1) triangles a sphere.
struct RoomSize {
    uint64_t triangles;
    glm::uvec3 spheres;  // along x, y, z
    uint32_t segments, rings;
};
constexpr RoomSize kRoomSizes[] = {
    {10'368, {4, 2, 3}, 20, 11},
    {249'600, {6, 4, 4}, 48, 28},
    {1'997'568, {8, 5, 6}, 80, 53},
};
constexpr uint32_t kWallCells = 8, kShapes = 4;
constexpr glm::vec3 kRoomMin(-5.0f, 0.0f, -5.0f), kRoomMax(5.0f, 6.0f, 5.0f);
constexpr float kCameraAisle = 1.2f;  // metres in front of the wall z = 5 without spheres
constexpr float kBump = 0.15f;

const RoomSize& nearest_size(uint64_t triangles) {
    const RoomSize* best = &kRoomSizes[0];
    const auto distance = [&](const RoomSize& size) { return std::abs(std::log(double(std::max<uint64_t>(triangles, 1)) / double(size.triangles))); };
    if (triangles == 0) return *best;
    for (const RoomSize& size : kRoomSizes)
        if (distance(size) < distance(*best)) best = &size;
    return *best;
}

// Three waves over the unit sphere: the radius stays within 1 +- kBump.
struct Bumps {
    std::array<glm::vec3, 3> wave;
    std::array<float, 3> phase;
    explicit Bumps(Random random) {
        for (int i = 0; i < 3; ++i) {
            wave[i] = {random.range(-9.0f, 9.0f), random.range(-9.0f, 9.0f), random.range(-9.0f, 9.0f)};
            phase[i] = random.range(0.0f, float(kTurn));
        }
    }
    float radius(glm::vec3 direction) const {
        float sum = 0.0f;
        for (int i = 0; i < 3; ++i) sum += std::sin(glm::dot(wave[i], direction) + phase[i]);
        return 1.0f + kBump / 3.0f * sum;
    }
};

// A closed surface: the poles are one vertex each, and the last column of quads ends at the first.
Primitive make_bumpy_sphere(const RoomSize& size, const Bumps& bumps) {
    Primitive sphere;
    const auto add = [&](glm::vec3 direction) { sphere.positions.push_back(direction * bumps.radius(direction)); };
    add({0.0f, 1.0f, 0.0f});
    for (uint32_t row = 1; row < size.rings; ++row)
        for (uint32_t column = 0; column < size.segments; ++column) {
            const float theta = 0.5f * float(kTurn) * float(row) / float(size.rings), phi = float(kTurn) * float(column) / float(size.segments);
            add({std::sin(theta) * std::sin(phi), std::cos(theta), std::sin(theta) * std::cos(phi)});
        }
    add({0.0f, -1.0f, 0.0f});
    const uint32_t south = uint32_t(sphere.positions.size()) - 1;
    const auto at = [&](uint32_t row, uint32_t column) { return 1 + (row - 1) * size.segments + column % size.segments; };
    for (uint32_t column = 0; column < size.segments; ++column) {
        sphere.triangles.emplace_back(0, at(1, column), at(1, column + 1));
        for (uint32_t row = 1; row + 1 < size.rings; ++row) {
            sphere.triangles.emplace_back(at(row, column), at(row + 1, column), at(row + 1, column + 1));
            sphere.triangles.emplace_back(at(row, column), at(row + 1, column + 1), at(row, column + 1));
        }
        sphere.triangles.emplace_back(at(size.rings - 1, column), south, at(size.rings - 1, column + 1));
    }
    return sphere;
}

// Six walls that face inwards, each in kWallCells x kWallCells quads.
Primitive make_walls() {
    Primitive walls;
    const glm::vec3 extent = kRoomMax - kRoomMin;
    const auto wall = [&](glm::vec3 corner, glm::vec3 u, glm::vec3 v) {
        const float cells = float(kWallCells);
        for (uint32_t i = 0; i < kWallCells; ++i)
            for (uint32_t k = 0; k < kWallCells; ++k) add_quad(walls, corner + u * (float(i) / cells) + v * (float(k) / cells), u / cells, v / cells);
    };
    const glm::vec3 x(extent.x, 0.0f, 0.0f), y(0.0f, extent.y, 0.0f), z(0.0f, 0.0f, extent.z);
    wall(kRoomMin, z, x), wall(kRoomMin, x, y), wall(kRoomMin, y, z);
    wall(kRoomMax, -x, -z), wall(kRoomMax, -y, -x), wall(kRoomMax, -z, -y);
    return walls;
}

// One sphere to a cell of a regular grid, so that none meets another or a wall.
Transform place_sphere(const RoomSize& size, glm::uvec3 cell, Random& random) {
    const glm::vec3 extent = kRoomMax - kRoomMin - glm::vec3(0.0f, 0.0f, kCameraAisle), step = extent / glm::vec3(size.spheres);
    const float room = 0.5f * std::min(step.x, std::min(step.y, step.z));
    const auto jitter = [&] { return random.range(-0.2f, 0.2f) * room; };
    Transform place;
    place.translation = kRoomMin + step * (glm::vec3(cell) + 0.5f);
    place.translation.x += jitter();
    place.translation.y += jitter();
    place.translation.z += jitter();
    const glm::vec3 axis(random.range(-1.0f, 1.0f), random.range(-1.0f, 1.0f), random.range(0.1f, 1.0f));
    place.rotation = glm::angleAxis(random.range(0.0f, float(kTurn)), glm::normalize(axis));
    const float radius = random.range(0.6f, 0.8f) * room / (1.0f + kBump);
    place.scale = radius * glm::vec3(random.range(0.8f, 1.0f), random.range(0.8f, 1.0f), 1.0f);
    return place;
}

std::vector<Transform> place_spheres(const RoomSize& size) {
    Random random(41u);
    std::vector<Transform> places;
    for (uint32_t z = 0; z < size.spheres.z; ++z)
        for (uint32_t y = 0; y < size.spheres.y; ++y)
            for (uint32_t x = 0; x < size.spheres.x; ++x) places.push_back(place_sphere(size, {x, y, z}, random));
    return places;
}

std::vector<Primitive> make_shapes(const RoomSize& size) {
    std::vector<Primitive> shapes;
    for (uint32_t i = 0; i < kShapes; ++i) shapes.push_back(make_bumpy_sphere(size, Bumps(Random(7u, i))));
    return shapes;
}

void add_flat(SceneEdit& edit, const RoomSize& size, Handle<Material> material) {
    const std::vector<Primitive> shapes = make_shapes(size);
    const std::vector<Transform> places = place_spheres(size);
    Primitive all = make_walls();
    for (size_t i = 0; i < places.size(); ++i) append(all, shapes[i % kShapes], matrix_of(places[i]));
    add_object(edit, "room", std::move(all), material);
}

void add_instanced(SceneEdit& edit, const RoomSize& size, Handle<Material> material) {
    add_object(edit, "walls", make_walls(), material);
    std::vector<Handle<Mesh>> meshes;
    for (Primitive& shape : make_shapes(size)) {
        shape.material = material;
        order_triangles_by_median(shape);
        Mesh mesh{.name = fmt::format("bumpy sphere {}", meshes.size())};
        mesh.primitives.push_back(std::move(shape));
        meshes.push_back(edit.add(std::move(mesh)));
    }
    const std::vector<Transform> places = place_spheres(size);
    for (size_t i = 0; i < places.size(); ++i) {
        const Handle<Node> node = edit.add(Node{.name = fmt::format("sphere {}", i), .local = places[i]});
        edit.add(Instance{.mesh = meshes[i % kShapes], .place = {.node = node}});
    }
}

using AddTriangles = void (*)(SceneEdit&, const RoomSize&, Handle<Material>);

LoadedScene make_any_room(const BuiltinOptions& options, AddTriangles add_triangles) {
    SceneEdit edit;
    Material plaster = lambert("plaster", glm::vec3(0.6f));
    plaster.double_sided = true;  // nothing is culled: every tracer sees the same triangles
    add_triangles(edit, nearest_size(options.triangles), edit.add(std::move(plaster)));
    const Handle<Node> lamp = edit.add(Node{.name = "lamp", .local = {.translation = {0.0f, 3.0f, kRoomMax.z - 0.5f}}});
    edit.add(Light{.name = "lamp", .kind = LightKind::Point, .intensity = 400.0f, .place = {.node = lamp}});
    add_camera(edit, "aisle", {0.3f, 3.1f, kRoomMax.z - 0.2f}, {0.0f, 2.9f, 0.0f}, glm::radians(65.0f));
    LoadedScene out;
    const ChangeSet changes = out.scene.apply(std::move(edit));
    out.scripted_edits.push_back({"lamp", "the lamp swings across the aisle, once in 4 seconds", [node = changes.resolve(lamp)](const Scene&, double seconds) {
                                      SceneEdit moved;
                                      moved.set_transform(node, {.translation = {static_cast<float>(std::sin(seconds * std::numbers::pi / 2)), 3.0f, kRoomMax.z - 0.5f}});
                                      return moved;
                                  }});
    return out;
}

}  // namespace

LoadedScene make_room(const BuiltinOptions& options) { return make_any_room(options, add_flat); }
LoadedScene make_room_instanced(const BuiltinOptions& options) { return make_any_room(options, add_instanced); }

}  // namespace parhelion::builtin
