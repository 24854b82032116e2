#include "truth/switched_room.h"

#include "scene/builtin/scenes.h"
#include "scene/shapes.h"

namespace parhelion::testing {
namespace {

// Four metres wide, with a window in the wall x = -2 through which only the sun comes; what glows is behind the camera.
constexpr glm::vec3 kRoomMin(-2.0f, 0.0f, -2.0f), kRoomMax(2.0f, 2.6f, 2.0f);

void add_room(SceneEdit& edit) {
    const auto plaster = [&](const char* name, glm::vec3 albedo) {
        Material material = builtin::lambert(name, albedo);
        material.double_sided = true;  // the sun is kept out from behind as well
        return edit.add(std::move(material));
    };
    const glm::vec3 size = kRoomMax - kRoomMin, x(size.x, 0.0f, 0.0f), y(0.0f, size.y, 0.0f), z(0.0f, 0.0f, size.z);
    Primitive walls, floor;
    add_quad(floor, kRoomMin, z, x);
    add_quad(walls, kRoomMin, x, y);
    add_quad(walls, kRoomMax, -x, -z);
    add_quad(walls, kRoomMax, -y, -x);
    add_quad(walls, kRoomMax, -z, -y);
    // Around the window: y 0.9 to 2.1, z -0.6 to 0.6.
    const auto piece = [&](float low, float high, float back, float front) {
        add_quad(walls, {kRoomMin.x, low, back}, {0.0f, high - low, 0.0f}, {0.0f, 0.0f, front - back});
    };
    piece(kRoomMin.y, 0.9f, kRoomMin.z, kRoomMax.z);
    piece(2.1f, kRoomMax.y, kRoomMin.z, kRoomMax.z);
    piece(0.9f, 2.1f, kRoomMin.z, -0.6f);
    piece(0.9f, 2.1f, 0.6f, kRoomMax.z);
    builtin::add_object(edit, "walls", std::move(walls), plaster("white", glm::vec3(0.7f)));
    builtin::add_object(edit, "floor", std::move(floor), plaster("wood", {0.5f, 0.35f, 0.2f}));
    Primitive block;
    add_box(block, {-0.4f, 0.0f, -1.3f}, {0.3f, 0.8f, -0.7f});
    builtin::add_object(edit, "block", std::move(block), plaster("red", {0.6f, 0.15f, 0.1f}));
    builtin::add_object(edit, "ball", make_sphere(0.35f, 16, true), edit.add(builtin::glossy("lacquer", {0.2f, 0.3f, 0.5f}, 0.0f, 0.3f)), {.translation = {1.1f, 0.35f, -0.6f}});
}

}  // namespace

Switched make_switched(Lit lit) {
    SceneEdit edit;
    add_room(edit);
    Light light{.name = "light"};
    if (lit == Lit::Sun) {
        light.kind = LightKind::Directional;
        light.intensity = 80000.0f;
        light.angular_radius = 0.00465f;
        light.place.node_from_object = builtin::place_looking({-2.0f, 1.5f, 0.0f}, {0.4f, 0.0f, -0.7f});
    } else {
        light.intensity = 150.0f;
        light.place.node_from_object = builtin::place_looking({1.0f, 2.2f, 1.6f}, {0.0f, 0.0f, 0.0f});
    }
    Material glow = builtin::lambert("glow", glm::vec3(0.5f), {3000.0f, 2700.0f, 2200.0f});
    Handle<Light> light_handle;
    Handle<Material> glow_handle;
    if (lit == Lit::Mesh) {
        Primitive panel;
        add_quad(panel, {-0.5f, 2.55f, 1.2f}, {1.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.6f});
        glow_handle = edit.add(glow);
        builtin::add_object(edit, "panel", std::move(panel), glow_handle);
    } else {
        light_handle = edit.add(light);
    }
    Switched out;
    const ChangeSet changes = out.loaded.scene.apply(std::move(edit));
    if (lit == Lit::Mesh) {
        out.set = [glow, handle = changes.resolve(glow_handle)](bool on) {
            Material now = glow;
            if (!on) now.emission = glm::vec3(0.0f);
            SceneEdit step;
            step.set_material(handle, now);
            return step;
        };
    } else {
        out.set = [light, handle = changes.resolve(light_handle)](bool on) {
            Light now = light;
            if (!on) now.intensity = 0.0f;
            SceneEdit step;
            step.set_light(handle, now);
            return step;
        };
    }
    return out;
}

CameraView switched_room_camera() { return look_at({0.6f, 1.4f, 1.9f}, {-0.1f, 0.7f, -1.0f}, glm::radians(65.0f)); }

}  // namespace parhelion::testing
