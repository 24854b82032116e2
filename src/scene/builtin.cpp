#include "scene/builtin.h"

#include <algorithm>
#include <cmath>

#include "scene/builtin/scenes.h"
#include "scene/builtin/scripts.h"
#include "scene/camera.h"
#include "scene/median_order.h"
#include "scene/shapes.h"

namespace parhelion {

namespace builtin {

Material lambert(std::string name, glm::vec3 albedo, glm::vec3 emission) {
    Material material;
    material.name = std::move(name);
    material.base_color = glm::vec4(albedo, 1.0f);
    material.metallic = 0.0f;
    material.specular = 0.0f;
    material.emission = emission;
    return material;
}

Material glossy(std::string name, glm::vec3 color, float metallic, float roughness) {
    Material material;
    material.name = std::move(name);
    material.base_color = glm::vec4(color, 1.0f);
    material.metallic = metallic;
    material.roughness = roughness;
    return material;
}

glm::mat4 place_looking(glm::vec3 from, glm::vec3 at) {
    const CameraView view = look_at(from, at, 1.0f);
    return {glm::vec4(view.right, 0.0f), glm::vec4(view.up, 0.0f), glm::vec4(-view.forward, 0.0f), glm::vec4(from, 1.0f)};
}

Handle<Camera> add_camera(SceneEdit& edit, std::string name, glm::vec3 from, glm::vec3 at, float yfov) {
    Camera camera;
    camera.name = std::move(name);
    camera.yfov = yfov;
    camera.near_plane = look_at(from, at, yfov).near_plane;
    camera.place.node_from_object = place_looking(from, at);
    return edit.add(std::move(camera));
}

namespace {

Handle<Mesh> add_mesh(SceneEdit& edit, std::string name, Primitive primitive, Handle<Material> material) {
    primitive.material = material;
    order_triangles_by_median(primitive);
    Mesh mesh;
    mesh.name = std::move(name);
    mesh.primitives.push_back(std::move(primitive));
    return edit.add(std::move(mesh));
}

}  // namespace

Handle<Instance> add_object(SceneEdit& edit, std::string name, Primitive primitive, Handle<Material> material, const Transform& local) {
    const Handle<Node> node = edit.add(Node{.name = name, .local = local});
    return edit.add(Instance{.mesh = add_mesh(edit, std::move(name), std::move(primitive), material), .place = {.node = node}});
}

Handle<Node> place_object(SceneEdit& edit, std::string name, Primitive primitive, Handle<Material> material, const Transform& local,
                          Handle<Node> parent) {
    const Handle<Node> node = edit.add(Node{.name = name, .parent = parent, .local = local});
    edit.add(Instance{.mesh = add_mesh(edit, std::move(name), std::move(primitive), material), .place = {.node = node}});
    return node;
}

namespace {

constexpr glm::vec3 kWhite(0.725f, 0.71f, 0.68f), kRed(0.63f, 0.065f, 0.05f), kGreen(0.14f, 0.45f, 0.091f);

// Five walls of the cube [-1, 1] x [0, 2] x [-1, 1]; the ceiling leaves a hole for the lamp, whose edge the lamp shares.
void add_cornell_walls(SceneEdit& edit, Handle<Material> white, glm::vec3 lamp_min, glm::vec3 lamp_max) {
    Primitive walls;
    const glm::vec3 x(2.0f, 0.0f, 0.0f), y(0.0f, 2.0f, 0.0f), z(0.0f, 0.0f, 2.0f);
    add_quad(walls, {-1.0f, 0.0f, 1.0f}, x, -z);  // floor
    add_quad(walls, {-1.0f, 0.0f, -1.0f}, x, y);  // back
    const float xs[4] = {-1.0f, lamp_min.x, lamp_max.x, 1.0f}, zs[4] = {-1.0f, lamp_min.z, lamp_max.z, 1.0f};
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            if (row != 1 || column != 1)
                add_quad(walls, {xs[column], 2.0f, zs[row]}, {xs[column + 1] - xs[column], 0.0f, 0.0f},
                         {0.0f, 0.0f, zs[row + 1] - zs[row]});
    add_object(edit, "walls", std::move(walls), white);
    Primitive left, right;
    add_quad(left, {-1.0f, 0.0f, 1.0f}, -z, y);
    add_quad(right, {1.0f, 0.0f, -1.0f}, z, y);
    add_object(edit, "left wall", std::move(left), edit.add(lambert("red", kRed)));
    add_object(edit, "right wall", std::move(right), edit.add(lambert("green", kGreen)));
}

Transform turned_box(glm::vec3 center, glm::vec3 size, float degrees) {
    Transform local;
    local.translation = center;
    local.rotation = glm::angleAxis(glm::radians(degrees), glm::vec3(0.0f, 1.0f, 0.0f));
    local.scale = size;
    return local;
}

const Transform kTallBox = turned_box({-0.35f, 0.6f, -0.3f}, {0.6f, 1.2f, 0.6f}, 17.0f), kShortBox = turned_box({0.35f, 0.3f, 0.35f}, glm::vec3(0.6f), -18.0f);

constexpr size_t kSparks = 12;

// In a ring about the boxes.
std::vector<Light> make_sparks() {
    std::vector<Light> lights;
    for (size_t i = 0; i < kSparks; ++i) {
        const float angle = 6.2831853f * float(i) / float(kSparks);
        glm::mat4 place(1.0f);
        place[3] = {0.75f * std::cos(angle), 0.9f + 0.5f * std::sin(3.0f * angle), 0.75f * std::sin(angle), 1.0f};
        const glm::vec3 color(0.6f + 0.4f * std::cos(angle), 0.7f, 0.6f - 0.4f * std::cos(angle));
        lights.push_back({.name = fmt::format("spark {}", i), .kind = LightKind::Point, .color = color, .intensity = 0.6f, .place = {.node_from_object = place}});
    }
    return lights;
}

// One begins every eighth of a second, not in the order of their numbers.
bool spark_is_there(size_t i, double seconds) {
    const double t = seconds / 1.5 - double(i * 5 % kSparks) / double(kSparks);
    return t - std::floor(t) < 1.0 / 3.0;
}

}  // namespace

// Goral et al. 1984 in the proportions of Cornell's measured box: two metres wide, one lamp of (17, 12, 4) nits.
LoadedScene make_cornell(const BuiltinOptions&) {
    SceneEdit edit;
    const Handle<Material> white = edit.add(lambert("white", kWhite));
    const glm::vec3 lamp_min(-0.235f, 2.0f, -0.19f), lamp_max(0.235f, 2.0f, 0.19f);
    add_cornell_walls(edit, white, lamp_min, lamp_max);
    Primitive lamp;
    add_quad(lamp, lamp_min, {lamp_max.x - lamp_min.x, 0.0f, 0.0f}, {0.0f, 0.0f, lamp_max.z - lamp_min.z});
    const Handle<Material> lamp_material = edit.add(lambert("lamp", glm::vec3(0.78f), glm::vec3(17.0f, 12.0f, 4.0f)));
    add_object(edit, "lamp", std::move(lamp), lamp_material);

    Mesh cube;
    cube.name = "cube";
    add_box(cube.primitives.emplace_back(), glm::vec3(-0.5f), glm::vec3(0.5f));
    cube.primitives[0].material = white;
    const Handle<Mesh> cube_mesh = edit.add(std::move(cube));
    const Handle<Node> tall = edit.add(Node{.name = "tall box", .local = kTallBox});
    const Handle<Node> low = edit.add(Node{.name = "short box", .local = kShortBox});
    edit.add(Instance{.mesh = cube_mesh, .place = {.node = tall}});
    edit.add(Instance{.mesh = cube_mesh, .place = {.node = low}});
    add_camera(edit, "front", {0.0f, 1.0f, 3.88f}, {0.0f, 1.0f, 0.0f}, glm::radians(39.3f));

    LoadedScene out;
    const ChangeSet changes = out.scene.apply(std::move(edit));
    const Handle<Node> spinning = changes.resolve(tall);
    out.scripted_edits.push_back({"spin", "the tall box turns, 90 degrees a second", [spinning](const Scene&, double seconds) {
                                      Transform local = kTallBox;
                                      const double angle =
                                          glm::radians(17.0) + std::fmod(seconds * glm::radians(90.0), glm::radians(360.0));
                                      local.rotation = glm::angleAxis(static_cast<float>(angle), glm::vec3(0.0f, 1.0f, 0.0f));
                                      SceneEdit step;
                                      step.set_transform(spinning, local);
                                      return step;
                                  }});
    out.scripted_edits.push_back(switched_materials("lamp", "the lamp is switched off and on, a second each", out.scene, {changes.resolve(lamp_material)}));
    out.scripted_edits.push_back(moving_torch("torch", "a glowing ball moves from wall to wall and back, 2 m a second",
                                              {.middle = {0.0f, 1.25f, 0.55f}, .to_end = {0.8f, 0.0f, 0.0f}, .nits = {48.0f, 40.0f, 30.0f}}));
    out.scripted_edits.push_back(passing_lights("sparks", "twelve small lights come and go, each for half a second", make_sparks(), spark_is_there));
    out.scripted_edits.push_back({"leave", "the short box stands for a second, then leaves by the open side, to come back after 4", [low = changes.resolve(low)](const Scene&, double seconds) {
                                      const double t = std::fmod(seconds, 4.0), gone = std::clamp(t - 1.0, 0.0, 1.0) - std::clamp(t - 3.0, 0.0, 1.0);
                                      Transform local = kShortBox;
                                      local.translation.z += 6.0f * float(gone);
                                      SceneEdit step;
                                      step.set_transform(low, local);
                                      return step;
                                  }});
    out.scripted_edits.push_back(camera_cut("cut", "the camera jumps into the box and out again, every second", out.scene, *out.scene.cameras().handle_at(0), {place_looking({0.7f, 1.5f, 0.8f}, {-0.5f, 0.4f, -0.4f})}));
    return out;
}

// Half as bright to half as bright again, once in 4 seconds.
float swing(double seconds) { return float(1.0 + 0.5 * std::sin(1.5707963267948966 * seconds)); }

// A convex, flat-faced Lambert solid in constant light shows albedo x light everywhere.
LoadedScene make_furnace(const BuiltinOptions& options) {
    SceneEdit edit;
    Material material = lambert("furnace", options.albedo);
    material.roughness = options.roughness;
    material.metallic = options.metallic;
    if (options.roughness != 1.0f || options.metallic != 0.0f) material.specular = 1.0f;
    add_object(edit, "sphere", make_sphere(1.0f, 24, options.metallic != 0.0f), edit.add(std::move(material)));
    const Environment light{.name = "constant", .scale = options.emission};
    edit.set_environment(light);
    add_camera(edit, "front", {0.0f, 0.0f, 4.0f}, glm::vec3(0.0f), glm::radians(40.0f));
    LoadedScene out;
    out.scene.apply(std::move(edit));
    out.scripted_edits.push_back({"swing", "the light around swings, once in 4 seconds", [light](const Scene&, double seconds) {
                                      Environment now = light;
                                      now.scale *= swing(seconds);
                                      SceneEdit step;
                                      step.set_environment(std::move(now));
                                      return step;
                                  }});
    return out;
}

// A closed room whose walls all reflect `albedo` and emit `emission`: radiance is emission / (1 - albedo) along every ray.
LoadedScene make_diffuse_box(const BuiltinOptions& options) {
    SceneEdit edit;
    Primitive room;
    add_box(room, glm::vec3(-1.0f), glm::vec3(1.0f), Facing::In);
    const Material wall = lambert("wall", options.albedo, options.emission);
    const Handle<Material> material = edit.add(wall);
    add_object(edit, "room", std::move(room), material);
    add_camera(edit, "inside", {0.3f, 0.2f, 0.4f}, {-0.2f, -0.1f, -1.0f}, glm::radians(60.0f));
    LoadedScene out;
    const ChangeSet changes = out.scene.apply(std::move(edit));
    out.scripted_edits.push_back({"swing", "the light of the walls swings, once in 4 seconds", [wall, handle = changes.resolve(material)](const Scene&, double seconds) {
                                      Material now = wall;
                                      now.emission *= swing(seconds);
                                      SceneEdit step;
                                      step.set_material(handle, now);
                                      return step;
                                  }});
    return out;
}

}  // namespace builtin

namespace {

using MakeScene = LoadedScene (*)(const BuiltinOptions&);
struct Row {
    BuiltinEntry entry;
    MakeScene make;
};
const Row kRows[] = {
    {{"builtin:cornell", "the Cornell box: diffuse walls, two boxes, one lamp"}, builtin::make_cornell},
    {{"builtin:furnace", "a sphere in constant light (albedo, emission, roughness, metallic)"}, builtin::make_furnace},
    {{"builtin:diffuse-box", "a closed room that reflects and emits everywhere (albedo, emission)"}, builtin::make_diffuse_box},
    {{"builtin:spheres", "spheres of five roughnesses by five metalnesses under a plain sky"}, builtin::make_spheres},
    {{"builtin:diorama", "a reading nook in the evening sun: wood, cloth, metal, plants, lamps"}, builtin::make_diorama},
    {{"builtin:forest", "trees without end, each a mesh of its own, with cut-out leaves (--triangles N)"}, builtin::make_forest},
    {{"builtin:many-lights", "8,000 boxes under 441 glowing spheres, after Bevy Solari's scene"}, builtin::make_many_lights},
    {{"builtin:reflections", "a hall of mirrors and metals of several roughnesses, after Bevy Solari's scene"}, builtin::make_reflections},
    {{"builtin:glass", "glass clear, rough, tinted and thin, water in a tumbler, a mirror, lacquer and velvet"}, builtin::make_glass},
    {{"builtin:leak-box", "closed dark boxes with walls of 1, 5 and 20 cm in a bright room"}, builtin::make_leak_box},
    {{"builtin:room", "a closed room with bumpy spheres as one mesh, to measure rays (--triangles: 10,368, 249,600 or 1,997,568)"}, builtin::make_room},
    {{"builtin:room-instanced", "the same triangles as a few meshes with many instances (--triangles likewise)"}, builtin::make_room_instanced},
    {{"builtin:textured", "textures, normal maps, alpha, mirrored and stretched instances, a point light and an emitting panel"},
     builtin::make_textured},
};

}  // namespace

const std::vector<BuiltinEntry>& builtin_scenes() {
    static const std::vector<BuiltinEntry> entries = [] {
        std::vector<BuiltinEntry> out;
        for (const Row& row : kRows) out.push_back(row.entry);
        return out;
    }();
    return entries;
}

bool is_builtin(std::string_view name) { return name.starts_with("builtin:"); }

LoadedScene make_builtin(std::string_view name, const BuiltinOptions& options) {
    std::string names;
    for (const Row& row : kRows) {
        if (row.entry.name == name) {
            LoadedScene loaded = row.make(options);
            SceneEdit edit;
            edit.set_source({.name = std::string(name)});
            loaded.scene.apply(std::move(edit));
            return loaded;
        }
        names += (names.empty() ? "" : ", ") + std::string(row.entry.name);
    }
    throw Error(ErrorCode::Usage, fmt::format("there is no built-in scene '{}'", escape_name(name)), "SCENE", names);
}

}  // namespace parhelion
