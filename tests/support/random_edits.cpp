#include "support/random_edits.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <utility>

#include <glm/gtc/matrix_transform.hpp>

#include "scene/builtin/scenes.h"
#include "scene/camera.h"
#include "scene/shapes.h"
#include "support/realtime_player.h"

namespace parhelion::testing {

namespace {

constexpr size_t kMostInstances = 24, kMostLights = 12;

Mesh make_ball(Handle<Material> material, float radius) {
    Mesh mesh{.name = "ball"};
    mesh.primitives.push_back(make_sphere(radius, 6, true));
    mesh.primitives[0].material = material;
    return mesh;
}

}  // namespace

RandomEdits::RandomEdits(uint32_t seed) : random_(seed) {}

glm::vec3 RandomEdits::color(float most) { return most * glm::vec3(random_.unit(), random_.unit(), random_.unit()); }

glm::mat4 RandomEdits::place() {
    const glm::mat4 there = glm::translate(glm::mat4(1.0f), {random_.range(-2.0f, 2.0f), random_.range(0.2f, 2.0f), random_.range(-2.0f, 2.0f)});
    return glm::scale(glm::rotate(there, random_.range(0.0f, 6.0f), {0.0f, 1.0f, 0.0f}), glm::vec3(random_.range(0.2f, 1.0f)));
}

Scene RandomEdits::make_scene() {
    SceneEdit edit;
    Material glass{.name = "glass", .metallic = 0.0f, .roughness = 0.1f, .transmission = 1.0f, .thickness = 0.1f};
    Material coated{.name = "coated", .metallic = 0.0f, .roughness = 0.5f, .clearcoat = 1.0f};
    const std::vector<Handle<Material>> materials{edit.add(builtin::lambert("dull", glm::vec3(0.5f))), edit.add(builtin::lambert("glow", glm::vec3(0.5f), glm::vec3(5.0f))),
                                                  edit.add(builtin::glossy("metal", glm::vec3(0.8f), 1.0f, 0.3f)), edit.add(glass), edit.add(coated)};
    std::vector<Handle<Mesh>> meshes;
    for (const Handle<Material> material : materials) meshes.push_back(edit.add(make_ball(material, 0.5f)));
    Primitive floor;
    add_quad(floor, {-4.0f, 0.0f, 4.0f}, {8.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -8.0f});
    builtin::add_object(edit, "floor", std::move(floor), materials[0]);
    builtin::add_camera(edit, "front", eye_, {0.0f, 0.5f, 0.0f}, 0.8f);
    const Handle<Node> stays = edit.add(Node{.name = "stays"}), goes = edit.add(Node{.name = "comes and goes", .parent = stays});
    Scene scene;
    const ChangeSet changes = scene.apply(std::move(edit));
    nodes_ = {changes.resolve(stays), changes.resolve(goes)};
    for (const Handle<Material> material : materials) materials_.push_back(changes.resolve(material));
    for (const Handle<Mesh> mesh : meshes) meshes_.push_back(changes.resolve(mesh));
    return scene;
}

void RandomEdits::remove(SceneEdit& edit, const Scene& scene, Handle<Instance> instance) {
    const Handle<Mesh> posed = scene.get(instance).posed;
    edit.remove(instance);
    if (posed) edit.remove(posed);
}

void RandomEdits::edit_instances(SceneEdit& edit, const Scene& scene) {
    for (uint32_t n = random_.below(3u); n > 0 && !instances_.empty(); --n) {
        const auto chosen = instances_.begin() + random_.below(static_cast<uint32_t>(instances_.size()));
        remove(edit, scene, *chosen);
        instances_.erase(chosen);
    }
    for (const Handle<Instance> handle : instances_) {
        const uint32_t what = random_.below(8u);
        if (what == 0u) edit.set_transform(handle, place());
        if (what != 1u) continue;
        const Instance& instance = scene.get(handle);  // another form of it, in the place of the last one
        Mesh form = make_ball(scene.get(instance.mesh).primitives[0].material, random_.range(0.2f, 0.8f));
        form.rest = instance.mesh;
        if (instance.posed) edit.remove(instance.posed);
        edit.set_pose(handle, edit.add(std::move(form)), {});
    }
    for (uint32_t n = random_.below(3u); n > 0 && instances_.size() + new_instances_.size() < kMostInstances; --n)
        new_instances_.push_back(edit.add(Instance{.mesh = meshes_[random_.below(static_cast<uint32_t>(meshes_.size()))], .place = {.node = nodes_[random_.below(2u)], .node_from_object = place()}}));
}

void RandomEdits::edit_lights(SceneEdit& edit, const Scene& scene) {
    if (random_.below(2u) == 0u && !lights_.empty()) {
        const auto chosen = lights_.begin() + random_.below(static_cast<uint32_t>(lights_.size()));
        edit.remove(*chosen);
        lights_.erase(chosen);
    }
    for (const Handle<Light> handle : lights_) {
        const uint32_t what = random_.below(6u);
        if (what == 0u) edit.set_transform(handle, place());
        if (what != 1u) continue;
        Light light = scene.get(handle);
        light.color = color(1.0f);
        edit.set_light(handle, light);
    }
    if (random_.below(2u) != 0u || lights_.size() >= kMostLights) return;
    constexpr LightKind kKinds[] = {LightKind::Point, LightKind::Spot, LightKind::Directional};
    new_lights_.push_back(edit.add(Light{.kind = kKinds[random_.below(3u)], .color = color(1.0f), .intensity = random_.range(0.0f, 10.0f), .angular_radius = 0.1f, .place = {.node = nodes_[random_.below(2u)], .node_from_object = place()}}));
}

void RandomEdits::edit_materials(SceneEdit& edit, const Scene& scene) {
    if (random_.below(4u) == 0u) {
        Material glow = scene.get(materials_[1]);
        glow.emission = color(random_.below(2u) == 0u ? 0.0f : 20.0f);
        edit.set_material(materials_[1], glow);
    }
    if (random_.below(8u) != 0u) return;
    const uint32_t side = 1u << random_.below(5u);  // another image, of another size
    std::vector<uint8_t> texels(size_t{4} * side * side);
    for (uint8_t& texel : texels) texel = static_cast<uint8_t>(random_.bits());
    new_texture_ = edit.add(Texture{.name = "spots", .image = edit.add(Image{.name = "spots", .width = side, .height = side, .texels = std::move(texels)})});
    Material dull = scene.get(materials_[0]);
    dull.base_color_texture.texture = new_texture_;
    edit.set_material(materials_[0], dull);
    if (!texture_) return;
    const Handle<Image> image = scene.get(texture_).image;
    edit.remove(texture_);
    edit.remove(image);
}

void RandomEdits::edit_environment(SceneEdit& edit) {
    if (random_.below(16u) != 0u) return;
    Environment environment{.scale = color(random_.below(2u) == 0u ? 0.0f : 1.0f), .rotation = random_.range(0.0f, 6.0f)};
    if (random_.below(2u) == 0u) {
        environment.width = 4, environment.height = 2;
        for (int i = 0; i < 8; ++i) environment.radiance.push_back(color(1.0f));
    }
    edit.set_environment(std::move(environment));
}

SceneEdit RandomEdits::next(const Scene& scene) {
    SceneEdit edit;
    if (random_.below(8u) == 0u) return edit;  // nothing happens
    if (random_.below(4u) == 0u) edit.set_visible(nodes_[1], random_.below(2u) == 0u);
    edit_instances(edit, scene);
    edit_lights(edit, scene);
    edit_materials(edit, scene);
    edit_environment(edit);
    return edit;
}

SceneEdit RandomEdits::take_all_away(const Scene& scene) {
    SceneEdit edit;
    for (const Handle<Instance> instance : std::exchange(instances_, {})) remove(edit, scene, instance);
    for (const Handle<Light> light : std::exchange(lights_, {})) edit.remove(light);
    Material glow = scene.get(materials_[1]);
    glow.emission = glm::vec3(0.0f);
    edit.set_material(materials_[1], glow);
    edit.set_environment({});
    return edit;
}

void RandomEdits::applied(const ChangeSet& changes) {
    for (const Handle<Instance> handle : std::exchange(new_instances_, {})) instances_.push_back(changes.resolve(handle));
    for (const Handle<Light> handle : std::exchange(new_lights_, {})) lights_.push_back(changes.resolve(handle));
    if (new_texture_) texture_ = changes.resolve(std::exchange(new_texture_, {}));
}

CameraView RandomEdits::camera() {
    if (random_.below(64u) == 0u) eye_ = {random_.range(-3.0f, 3.0f), random_.range(0.5f, 2.0f), random_.range(3.0f, 5.0f)};
    eye_.x += random_.range(-0.02f, 0.02f);
    return look_at(eye_, {0.0f, 0.5f, 0.0f}, 0.8f);
}

namespace {

uint64_t device_bytes(const gpu::Device& device) {
    uint64_t sum = 0;
    for (const gpu::MemoryUse& use : device.memory_use()) sum += use.bytes;
    return sum;
}

// Resident pages of this process.
uint64_t host_bytes() {
    uint64_t all = 0, resident = 0;
    std::ifstream("/proc/self/statm") >> all >> resident;
    return resident * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
}

}  // namespace

std::vector<MemoryUsed> draw_random_edits(const gpu::DevicePtr& device, uint32_t frames, uint32_t seed) {
    constexpr uint32_t kParts = 10, kForgotten = 64;  // frames after which the cache has nothing of a light
    RandomEdits edits(seed);
    Stage stage(edits.make_scene(), {}, {}, device);
    Player player(stage, {.view = {.width = 16, .height = 16, .seed = seed, .filter = PixelFilter::Point}}, {.reuse = RealtimeReuse::Full});
    std::vector<MemoryUsed> used(kParts);
    double lit = 0;
    for (uint32_t frame = 0; frame < frames; ++frame) {
        player.set_camera(edits.camera());
        const image::ImageF picture = player.next(edits.next(stage.scene));
        edits.applied(player.changes);
        for (size_t p = 0; p < picture.pixel_count(); ++p) {
            const double value = luminance_of(picture, p);
            EXPECT_TRUE(std::isfinite(value) && value >= 0) << "frame " << frame << ", pixel " << p << ": " << value;
        }
        lit = std::max(lit, mean_luminance(picture));
        MemoryUsed& part = used[uint64_t{frame} * kParts / frames];
        part.device = std::max(part.device, device_bytes(*device));
        part.host = std::max(part.host, host_bytes());
        if (::testing::Test::HasFailure()) return used;
    }
    player.skip(kForgotten, edits.take_all_away(stage.scene));
    EXPECT_GT(lit, 0.1);
    EXPECT_LT(mean_luminance(player.next()), 1e-5 * lit) << "light is left";
    EXPECT_EQ(stage.scene.lights().size() + stage.scene_gpu.stats().emitters, 0u);
    EXPECT_EQ(stage.scene.instances().size(), 1u);
    EXPECT_EQ(stage.scene.meshes().size(), 6u);
    EXPECT_LE(stage.scene.images().size(), 1u);
    return used;
}

}  // namespace parhelion::testing
