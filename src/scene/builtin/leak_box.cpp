// Closed dark boxes in a bright room: whatever light is seen inside them has leaked.
#include <cmath>
#include <span>

#include "scene/builtin/scenes.h"
#include "scene/builtin/scripts.h"
#include "scene/shapes.h"

namespace parhelion::builtin {

namespace {

constexpr glm::vec3 kRoomMin(-3.0f, 0.0f, -2.5f), kRoomMax(3.0f, 3.0f, 2.5f);
// The boxes sink into the floor by this much, so that no two faces lie in one plane.
constexpr float kSunk = 0.001f;

// The grid lines that a box's faces share: no vertex lies on another face's edge.
struct Lines {
    std::vector<float> along[3];
};

// The faces of a box, cut along all lines; without the middle cell of its +z face where `hole` says so.
void add_cut_box(Primitive& primitive, const Lines& lines, Facing facing, bool hole) {
    for (int axis = 0; axis < 3; ++axis) {
        const int ua = (axis + 1) % 3, va = (axis + 2) % 3;
        for (const bool far_side : {false, true})
            for (size_t i = 0; i + 1 < lines.along[ua].size(); ++i)
                for (size_t j = 0; j + 1 < lines.along[va].size(); ++j) {
                    if (hole && axis == 2 && far_side && i == 1 && j == 1) continue;
                    glm::vec3 corner;
                    corner[axis] = far_side ? lines.along[axis].back() : lines.along[axis].front();
                    corner[ua] = lines.along[ua][i], corner[va] = lines.along[va][j];
                    glm::vec3 at_u = corner, at_v = corner, opposite = corner;
                    at_u[ua] = opposite[ua] = lines.along[ua][i + 1];
                    at_v[va] = opposite[va] = lines.along[va][j + 1];
                    if (far_side == (facing == Facing::In)) std::swap(at_u, at_v);
                    const uint32_t base = uint32_t(primitive.positions.size());
                    primitive.positions.insert(primitive.positions.end(), {corner, at_u, opposite, at_v});
                    primitive.triangles.emplace_back(base, base + 1, base + 2);
                    primitive.triangles.emplace_back(base, base + 2, base + 3);
                }
    }
}

// From the hole of the inner front to that of the outer one; faces into the hole.
void add_hole_rim(Primitive& primitive, const Lines& inner, const Lines& outer) {
    const auto corner = [](const Lines& lines, int i) {
        const size_t x = i == 1 || i == 2 ? 2 : 1, y = i == 2 || i == 3 ? 2 : 1;
        return glm::vec3(lines.along[0][x], lines.along[1][y], lines.along[2].back());
    };
    for (int i = 0; i < 4; ++i) {
        const uint32_t base = uint32_t(primitive.positions.size());
        const int next = (i + 1) % 4;
        primitive.positions.insert(primitive.positions.end(),
                                   {corner(inner, i), corner(inner, next), corner(outer, next), corner(outer, i)});
        primitive.triangles.emplace_back(base, base + 2, base + 1);
        primitive.triangles.emplace_back(base, base + 3, base + 2);
    }
}

struct DarkBox {
    float wall;  // metres
    float x;     // of its middle
    const char* name;
    glm::vec3 albedo;
};
constexpr DarkBox kDarkBoxes[] = {{0.01f, -1.8f, "1 cm", {0.65f, 0.35f, 0.22f}},
                                  {0.05f, 0.0f, "5 cm", {0.70f, 0.58f, 0.30f}},
                                  {0.20f, 1.8f, "20 cm", {0.25f, 0.42f, 0.52f}}};
constexpr float kBoxZ = -1.2f, kHalfCavity = 0.5f;
constexpr glm::vec2 kHoleMin(-0.25f, 0.15f), kHoleMax(0.25f, 0.85f);

glm::vec3 cavity_min(const DarkBox& box) { return {box.x - kHalfCavity, box.wall - kSunk, kBoxZ - kHalfCavity}; }

// A cubic metre of darkness in walls of its thickness.
Primitive make_dark_box(const DarkBox& box, bool hole) {
    const glm::vec3 low = cavity_min(box), high = low + 2.0f * kHalfCavity;
    Lines inner, outer;
    for (int axis = 0; axis < 3; ++axis) {
        inner.along[axis] = {low[axis], high[axis]};
        outer.along[axis] = {low[axis] - box.wall, high[axis] + box.wall};
    }
    if (hole)
        for (Lines* lines : {&inner, &outer})
            for (int axis = 0; axis < 2; ++axis)
                lines->along[axis].insert(lines->along[axis].begin() + 1,
                                          {(axis == 0 ? box.x : low.y) + kHoleMin[axis], (axis == 0 ? box.x : low.y) + kHoleMax[axis]});
    Primitive walls;
    add_cut_box(walls, inner, Facing::In, hole);
    add_cut_box(walls, outer, Facing::Out, hole);
    if (hole) add_hole_rim(walls, inner, outer);
    return walls;
}

// Larger than the hole by 3 cm all round, sunk into the wall by half a centimetre; turns about its left edge. At rest it is shut.
Handle<Node> add_door(SceneEdit& edit, const DarkBox& box, Handle<Material> material, Transform& shut) {
    const glm::vec3 low = cavity_min(box);
    const float margin = 0.03f, front = low.z + 2.0f * kHalfCavity + box.wall;
    shut = {.translation = {box.x + kHoleMin.x - margin, low.y + kHoleMin.y - margin, front - 0.005f}};
    Primitive slab;
    add_box(slab, glm::vec3(0.0f), {kHoleMax.x - kHoleMin.x + 2.0f * margin, kHoleMax.y - kHoleMin.y + 2.0f * margin, 0.04f});
    return place_object(edit, "door", std::move(slab), material, shut);
}

}  // namespace

LoadedScene make_leak_box(const BuiltinOptions&) {
    SceneEdit edit;
    const Handle<Material> white = edit.add(lambert("white", glm::vec3(0.8f)));
    const Handle<Material> gray = edit.add(lambert("gray", glm::vec3(0.5f)));
    Primitive room;
    add_box(room, kRoomMin, kRoomMax, Facing::In);
    add_box(room, kRoomMin - 0.2f, kRoomMax + 0.2f);
    place_object(edit, "room", std::move(room), white);
    const glm::vec3 nits(1000.0f, 940.0f, 850.0f);
    const Handle<Material> glow = edit.add(lambert("lamp", glm::vec3(0.5f), nits));
    Primitive lamp;
    add_quad(lamp, {-0.8f, 2.98f, -0.8f}, {1.6f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.6f});
    place_object(edit, "lamp", std::move(lamp), glow);

    add_camera(edit, "outside", {0.6f, 1.7f, 2.35f}, {0.0f, 0.75f, -1.2f}, glm::radians(60.0f));
    Handle<Node> door;
    Transform shut;
    for (const DarkBox& box : kDarkBoxes) {
        const bool has_door = box.wall == 0.05f;
        const glm::vec3 low = cavity_min(box);
        place_object(edit, box.name, make_dark_box(box, has_door), edit.add(lambert(box.name, box.albedo)));
        if (has_door) door = add_door(edit, box, gray, shut);
        place_object(edit, fmt::format("ball in {}", box.name), make_sphere(0.15f, 12, true), gray,
                     {.translation = low + glm::vec3(0.7f, 0.16f, 0.35f)});
        add_camera(edit, fmt::format("inside {}", box.name), low + glm::vec3(0.15f, 0.8f, 0.12f), low + glm::vec3(0.55f, 0.4f, 0.8f),
                   glm::radians(75.0f));
    }

    LoadedScene out;
    const ChangeSet changes = out.scene.apply(std::move(edit));
    out.scripted_edits.push_back(switched_materials("lamp", "the room's lamp is off every other second", out.scene, {changes.resolve(glow)}));
    out.scripted_edits.push_back(
        {"door", "the door of the 5 cm box opens and shuts, once in 4 seconds", [door = changes.resolve(door), shut](const Scene&, double seconds) {
             const double open = 0.5 - 0.5 * std::cos(kTurn * seconds / 4.0);
             Transform local = shut;
             local.rotation = glm::angleAxis(float(glm::radians(-100.0) * open), glm::vec3(0.0f, 1.0f, 0.0f));
             SceneEdit step;
             step.set_transform(door, local);
             return step;
         }});
    std::vector<glm::mat4> insides;
    for (const auto& [handle, camera] : out.scene.cameras())
        if (camera.name != "outside") insides.push_back(camera.place.node_from_object);
    out.scripted_edits.push_back(camera_cut("cut", "the camera \"outside\" jumps from box to box and out again, every second", out.scene, *out.scene.cameras().handle_at(0), std::move(insides)));
    return out;
}

}  // namespace parhelion::builtin
