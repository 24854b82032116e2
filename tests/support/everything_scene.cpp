#include "support/everything_scene.h"

#include "image/encode.h"
#include "scene/shapes.h"

namespace parhelion::testing {

namespace {

glm::vec3 unit(glm::vec3 v) { return glm::vec3(glm::normalize(glm::dvec3(v))); }
glm::quat turn(float w, float x, float y, float z) { return glm::quat(glm::normalize(glm::dquat(w, x, y, z))); }

Image noise_image(std::string name, uint32_t width, uint32_t height, uint32_t seed) {
    Image image{.name = std::move(name), .width = width, .height = height};
    for (uint32_t i = 0; i < 4 * width * height; ++i) image.texels.push_back(static_cast<uint8_t>((seed = seed * 1664525u + 1013904223u) >> 24));
    return image;
}

Primitive strip(uint32_t quads) {
    Primitive p;
    for (uint32_t i = 0; i <= quads; ++i)
        for (uint32_t side = 0; side < 2; ++side) {
            const float x = 0.1f * float(i), y = float(side) * 0.7f;
            p.positions.emplace_back(x, y, 0.3f * x * y);
            p.normals.push_back(unit({0.1f * x, -0.2f * y, 1.0f}));
            p.tangents.emplace_back(unit({1.0f, 0.05f * x, 0.0f}), side == 0 ? 1.0f : -1.0f);
            p.uv0.emplace_back(x / 3.0f, y);
            p.uv1.emplace_back(1.0f - x, y / 7.0f);
            p.colors.emplace_back(x / 10.0f, y, 0.3f, 1.0f);
        }
    for (uint32_t i = 0; i < quads; ++i) {
        p.triangles.emplace_back(2 * i, 2 * i + 2, 2 * i + 1);
        p.triangles.emplace_back(2 * i + 1, 2 * i + 2, 2 * i + 3);
    }
    return p;
}

// All 17 textures, of two images and two samplers, each with a use of its own.
void add_textures(SceneEdit& edit, Material& m) {
    const Handle<Image> plain = edit.add(noise_image("plain", 3, 2, 1));
    Image kept = noise_image("kept as it was", 2, 2, 2);
    kept.encoded = std::make_shared<const std::vector<std::byte>>(image::encode_png(image::Texture8{2, 2, kept.texels}));
    const Handle<Image> encoded = edit.add(std::move(kept));
    uint32_t i = 0;
    for (const MaterialTexture& use : material_textures()) {
        Texture texture{.name = fmt::format("texture {}", i), .image = i % 2 == 0 ? plain : encoded, .color_space = use.color_space};
        if (i % 3 == 0) texture.sampler = {Wrap::MirroredRepeat, Wrap::ClampToEdge, Filter::Nearest, Filter::Nearest, std::nullopt};
        if (i % 3 == 1) texture.sampler.mip = Filter::Nearest;
        TextureRef& ref = m.*use.ref;
        ref.texture = edit.add(std::move(texture));
        ref.uv_set = i % 2;
        if (i % 4 == 1) ref.offset = {0.1f, -0.2f};
        if (i % 4 == 2) ref.rotation = 0.3f, ref.scale = {2.0f, 0.7f};
        ++i;
    }
}

Material full_material(SceneEdit& edit) {
    Material m{.name = "full", .base_color = {0.1f, 0.2f, 0.3f, 0.4f}, .metallic = 0.7f, .roughness = 0.1f};
    m.normal_scale = 0.9f, m.occlusion_strength = 0.8f;
    m.emission = {0.3f, 1000.1f, 7.7f};
    m.alpha_mode = AlphaMode::Mask, m.alpha_cutoff = 0.3f, m.double_sided = true;
    m.ior = 1.33f, m.specular = 0.6f, m.specular_color = {0.9f, 0.8f, 0.7f};
    m.transmission = 0.2f, m.thickness = 0.01f, m.attenuation_distance = 0.77f, m.attenuation_color = {0.3f, 0.6f, 0.9f};
    m.nested_priority = -3, m.dispersion = 0.36f, m.clearcoat = 0.4f, m.clearcoat_roughness = 0.11f, m.clearcoat_normal_scale = 0.6f;
    m.sheen_color = {0.11f, 0.22f, 0.33f}, m.sheen_roughness = 0.44f;
    m.anisotropy = 0.55f, m.anisotropy_rotation = 0.66f;
    m.iridescence = 0.77f, m.iridescence_ior = 1.88f, m.iridescence_thickness_min = 99.9f, m.iridescence_thickness_max = 333.3f;
    add_textures(edit, m);
    return m;
}

void add_lights(SceneEdit& edit, Handle<Node> node) {
    edit.add(Light{.name = "sun", .kind = LightKind::Directional, .intensity = 1e5f, .angular_radius = 0.00465f, .place = {.node = node}});
    edit.add(Light{.name = "lamp", .color = {1.0f, 0.9f, 0.7f}, .intensity = 3.3f, .range = 12.1f, .place = {.node = node}});
    edit.add(Light{.name = "spot", .kind = LightKind::Spot, .inner_cone = 0.1f, .outer_cone = 0.6f,
                   .place = {.node_from_object = glm::mat4(glm::vec4(1, 0, 0, 0), glm::vec4(0, 1, 0, 0), glm::vec4(0, 0, 1, 0), glm::vec4(1, 2, 3, 1))}});
}

void add_cameras(SceneEdit& edit, Handle<Node> node) {
    edit.add(Camera{.name = "eye", .yfov = 0.77f, .near_plane = 0.03f, .far_plane = 99.9f, .place = {.node = node}});
    edit.add(Camera{.name = "plan", .kind = CameraKind::Orthographic, .xmag = 3.3f, .ymag = 2.2f, .near_plane = 0.0f, .place = {.node = node}});
}

}  // namespace

Scene everything_scene() {
    SceneEdit edit;
    const Handle<Material> full = edit.add(full_material(edit)), plain = edit.add(Material{.name = "plain", .alpha_mode = AlphaMode::Blend, .unlit = true}),
                           lambert = edit.add(Material{.name = "", .specular = 0.0f});
    Mesh mesh{.name = "strips", .primitives = {strip(3), strip(3), strip(40000)}};
    mesh.primitives[0].material = full;
    mesh.primitives[0].variant_materials = {plain, {}, lambert, plain};
    mesh.primitives[1].material = plain;
    mesh.primitives[1].triangles.resize(2);  // other triangles of the same vertices
    mesh.primitives[2].material = lambert;
    for (auto* gone : {&mesh.primitives[2].uv0, &mesh.primitives[2].uv1}) gone->clear();
    mesh.primitives[2].normals.clear(), mesh.primitives[2].tangents.clear(), mesh.primitives[2].colors.clear();
    const Handle<Mesh> strips = edit.add(std::move(mesh));

    const Handle<Node> late_parent = edit.add(Node{.name = "root", .local = {.translation = {0.1f, 0.2f, 0.3f}, .rotation = turn(1, 2, 3, 4)}});
    const Handle<Node> second = edit.add(Node{.name = "second root", .local = {.scale = {-1.0f, 0.5f, 3.0f}}});
    glm::mat4 matrix(1.0f);
    matrix[0] = {0.0f, 0.3f, 0.0f, 0.0f}, matrix[1] = {-0.3f, 0.0f, 0.0f, 0.0f}, matrix[3] = {9.9f, -8.8f, 7.7f, 1.0f};
    const Handle<Node> by_matrix = edit.add(Node{.name = "by matrix", .parent = second, .local = {.matrix = matrix}});
    const Handle<Node> deep = edit.add(Node{.name = "", .parent = late_parent, .local = {.rotation = turn(-0.1f, 0.7f, 0.7f, 0.1f)}});
    edit.add(Instance{.mesh = strips, .place = {.node = by_matrix, .node_from_object = matrix}});
    edit.add(Instance{.mesh = strips, .place = {.node = by_matrix}});
    edit.add(Instance{.mesh = strips, .place = {.node = by_matrix}});
    edit.add(Instance{.mesh = strips, .place = {.node = deep}});
    edit.add(Instance{.mesh = strips, .place = {.node_from_object = matrix}});
    add_lights(edit, late_parent);
    add_cameras(edit, by_matrix);
    edit.set_source({.copyright = "nobody", .variants = {"first", "same as ever", "third", "like the first"}});
    Scene scene;
    scene.apply(std::move(edit));
    return scene;
}

Scene moving_scene() {
    SceneEdit edit;
    Primitive p = strip(2);
    p.material = edit.add(Material{.name = "skin"});
    p.influence_count = 4;
    for (size_t v = 0; v < p.positions.size(); ++v) {
        p.joints.insert(p.joints.end(), {0, 1, 1, 0});
        p.joint_weights.insert(p.joint_weights.end(), {0.1f, 0.7f, 0.2f, 0.0f});
    }
    p.targets.resize(2);
    p.targets[0].positions.assign(p.positions.size(), {0.1f, 0.2f, 0.3f});
    p.targets[1] = {p.targets[0].positions, p.targets[0].positions, p.targets[0].positions};
    p.targets[1].positions[3] = {-4.4f, 5.5f, 6.6f};
    const Handle<Mesh> mesh = edit.add(Mesh{.name = "body", .primitives = {std::move(p)}, .weights = {0.1f, 0.9f}, .target_names = {"smile", "frown"}});
    const Handle<Node> body = edit.add(Node{.name = "body"});
    const Handle<Node> hip = edit.add(Node{.name = "hip", .local = {.translation = {0.0f, 0.1f, 0.0f}}});
    const Handle<Node> knee = edit.add(Node{.name = "knee", .parent = hip});
    glm::mat4 bind(1.0f);
    bind[3] = {0.1f, -0.1f, 0.0f, 1.0f};
    const Handle<Skin> skin = edit.add(Skin{.name = "bones", .joints = {knee, hip}, .inverse_bind = {bind, glm::mat4(1.0f)}});
    edit.add(Instance{.mesh = mesh, .place = {.node = body}, .skin = skin, .weights = {0.3f, 0.4f}});
    Animation walk{.name = "walk"};
    const std::vector<float> times{0.0f, 0.1f, 0.7f};
    walk.channels.push_back({hip, AnimatedPath::Translation, Interpolation::Linear, 3, times, {0, 0, 0, 1, 2, 3, 0.1f, 0.2f, 0.3f}});
    walk.channels.push_back({hip, AnimatedPath::Rotation, Interpolation::Step, 4, times, {0, 0, 0, 1, 0, 0, 1, 0, 0, 0.6f, 0.8f, 0}});
    walk.channels.push_back({knee, AnimatedPath::Scale, Interpolation::CubicSpline, 3, {0.5f}, {0, 0, 0, 1, 2, 3, 0.5f, 0.5f, 0.5f}});
    walk.channels.push_back({body, AnimatedPath::Weights, Interpolation::CubicSpline, 2, {0.0f, 1.0f}, {0, 0, 0.1f, 0.2f, 0, 0, 0, 0, 0.9f, 0.8f, 0, 0}});
    const Handle<Light> lamp = edit.add(Light{.name = "lamp", .kind = LightKind::Spot, .place = {.node = body}});
    const Handle<Camera> eye = edit.add(Camera{.name = "eye", .place = {.node = body}});
    const Handle<Camera> plan = edit.add(Camera{.name = "plan", .kind = CameraKind::Orthographic, .far_plane = 9.0f, .place = {.node = hip}});
    const auto point = [&](AnimatedPath path, std::vector<float> values, Handle<Light> light, Handle<Camera> camera) {
        walk.channels.push_back({.path = path, .width = static_cast<uint32_t>(values.size()), .times = {0.5f}, .values = std::move(values), .light = light, .camera = camera});
    };
    for (const Handle<Node> node : {knee, body}) walk.channels.push_back({node, AnimatedPath::Visible, Interpolation::Step, 1, times, {1, 0, 1}});
    point(AnimatedPath::Color, {0.1f, 0.2f, 0.3f}, lamp, {});
    point(AnimatedPath::Intensity, {0.4f}, lamp, {});
    point(AnimatedPath::InnerCone, {0.1f}, lamp, {});
    point(AnimatedPath::OuterCone, {0.6f}, lamp, {});
    point(AnimatedPath::Yfov, {0.9f}, {}, eye);
    point(AnimatedPath::Xmag, {2.5f}, {}, plan);
    point(AnimatedPath::Ymag, {1.5f}, {}, plan);
    edit.add(Node{.name = "hidden", .parent = knee, .visible = false});
    edit.add(std::move(walk));
    edit.add(Animation{.name = "jump", .channels = {{hip, AnimatedPath::Translation, Interpolation::Linear, 3, {0.25f}, {0, 1, 0}}}});
    Scene scene;
    scene.apply(std::move(edit));
    return scene;
}

}  // namespace parhelion::testing
