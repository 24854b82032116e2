#pragma once
// Internal to the diorama: its materials, and models that are put together from parts of several materials.
#include <string>
#include <utility>
#include <vector>

#include "scene/builtin/scenes.h"
#include "scene/shapes.h"

namespace parhelion::builtin {

// Textures of all these are laid out in metres of UV.
struct Palette {
    Handle<Material> floor, plaster, paint, ceiling, walnut, oak, rug, chair, pillow, linen, paper;
    Handle<Material> brass, copper, steel, ceramic, glaze, glass, terracotta, soil, cord;
    Handle<Material> leaf, fern, stem, petal, petal_pale, painting, books;
    Handle<Material> toy_body, toy_trim, toy_eye, ball, bulb, shade;
    std::vector<Handle<Material>> normal_mapped;
};
Palette add_palette(SceneEdit& edit);

// Metres and degrees: turned about z, then x, then y, then moved.
glm::mat4 placed(glm::vec3 at, float yaw = 0.0f, float pitch = 0.0f, float roll = 0.0f);

// One mesh of several materials.
class Model {
public:
    explicit Model(const Palette& palette) : palette_(palette) {}
    void add(const Primitive& part, Handle<Material> material, const glm::mat4& place = glm::mat4(1.0f));
    // Boxes: of this full size about the middle, with rounded edges.
    void add_box(glm::vec3 size, glm::vec3 middle, Handle<Material> material, float radius = 0.006f, float yaw = 0.0f);
    // Makes tangents where they are needed and puts the model into the scene, on a node of its own.
    Handle<Node> place(SceneEdit& edit, const std::string& name, const Transform& local = {}, Handle<Node> parent = {});

private:
    const Palette& palette_;
    std::vector<Primitive> primitives_;  // one a material
};

// What scripted edits move or switch, as pending handles.
struct DioramaHandles {
    Handle<Node> ball, door;
    Handle<Node> robot, arms[2], legs[2];
    std::vector<Handle<Node>> bulbs;
    std::vector<glm::vec3> bulb_places;
};

// The room is 4.2 m wide (x), 2.6 m high and 5.6 m deep; -z is the back wall, the window is in the left one.
constexpr glm::vec3 kNookMin(-2.1f, 0.0f, -1.8f), kNookMax(2.1f, 2.6f, 3.8f);
constexpr float kWindowLow = 0.8f, kWindowHigh = 2.15f, kWindowBack = -1.15f, kWindowFront = 0.45f;

void add_room(SceneEdit& edit, const Palette& palette);
void add_window(SceneEdit& edit, const Palette& palette);
void add_armchair(SceneEdit& edit, const Palette& palette);
void add_table(SceneEdit& edit, const Palette& palette);
void add_floor_lamp(SceneEdit& edit, const Palette& palette);
void add_shelf(SceneEdit& edit, const Palette& palette, DioramaHandles& handles);
void add_plants(SceneEdit& edit, const Palette& palette);
void add_fairy_lights(SceneEdit& edit, const Palette& palette, DioramaHandles& handles);
void add_toys(SceneEdit& edit, const Palette& palette, DioramaHandles& handles);

// Books that stand side by side from x = 0 on, at most this wide; their backs face +z.
void add_books(Model& model, const Palette& palette, float width, float height, uint32_t seed, const glm::mat4& place);
Primitive make_book(float thickness, float height, float depth, uint32_t cover);

// Where the toys are at t seconds.
Transform ball_at(double seconds);
Transform robot_at(double seconds);
Transform robot_limb_at(double seconds, bool leg, int side);
constexpr glm::vec3 kRobotShoulder(0.068f, 0.165f, 0.0f), kRobotHip(0.03f, 0.085f, 0.0f);

}  // namespace parhelion::builtin
