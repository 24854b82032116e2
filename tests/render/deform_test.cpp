// Meshes that the device deforms: its vertices against the host's, their motion against geometry in double (real models: tests/soak/motion_test.cpp), and pictures and rays in every
// way to trace against the same shapes built in place.
#include <algorithm>
#include <cmath>

#include <glm/gtc/matrix_transform.hpp>

#include "scene/builtin/random.h"
#include "scene/builtin/scenes.h"
#include "scene/deform.h"
#include "scene/pose.h"
#include "scene/shapes.h"
#include "session/scene_setup.h"
#include "shared/scene.h"
#include "support/motion_check.h"

namespace parhelion::testing::deform_test {
namespace {

constexpr uint32_t kSize = 40, kInstances = 3;

// A pillar of rings around +Y from 0 to 2 metres, smooth, with tangents along it.
Primitive make_pillar(uint32_t rings, uint32_t sides) {
    Primitive p;
    for (uint32_t ring = 0; ring <= rings; ++ring)
        for (uint32_t side = 0; side < sides; ++side) {
            const float angle = 6.2831853f * float(side) / float(sides), height = 2.0f * float(ring) / float(rings);
            const glm::vec3 n(std::cos(angle), 0.0f, std::sin(angle));
            p.positions.push_back(0.35f * n + glm::vec3(0, height, 0));
            p.normals.push_back(n);
            p.tangents.push_back({0, 1, 0, 1});
            p.uv0.push_back({float(side) / float(sides), 0.5f * height});
            if (ring == rings) continue;
            const uint32_t next = (side + 1) % sides, a = ring * sides + side, b = ring * sides + next;
            p.triangles.push_back({a, a + sides, b});
            p.triangles.push_back({b, a + sides, b + sides});
        }
    return p;
}

// A pillar on a chain of three bones, of six influences a vertex, with two morph targets, and beside it a stump that is morphed alone, under a
// node that turns and stretches. The bones bend and stretch, the weights change and the node moves. Three instances: skinned; morphed only, and
// mirrored by its transform; and skinned under a node that mirrors, which the skin undoes by turning triangles over on the host.
Scene make_pillar_scene() {
    SceneEdit edit;
    Mesh mesh{.name = "pillar", .weights = {0.1f, 0.0f}};
    mesh.primitives = {make_pillar(8, 10), make_pillar(1, 5)};
    for (Primitive& p : mesh.primitives) {
        p.material = edit.add(builtin::lambert("clay", {0.7f, 0.4f, 0.2f}));
        p.targets.resize(2);
        for (size_t i = 0; i < p.positions.size(); ++i) {
            p.targets[0].positions.push_back(0.3f * std::sin(2.0f * p.positions[i].y) * p.normals[i]);
            p.targets[0].normals.push_back({0.0f, -0.6f * std::cos(2.0f * p.positions[i].y), 0.0f});
            p.targets[1].positions.push_back({0.1f, 0.2f, -0.1f * p.positions[i].y});
            p.targets[1].tangents.push_back({0.2f, 0.0f, 0.1f});
        }
    }
    for (glm::vec3& at : mesh.primitives[1].positions) at += glm::vec3(0.9f, -0.2f, 0.0f);
    Primitive& body = mesh.primitives[0];
    body.influence_count = 6;
    for (const glm::vec3& at : body.positions) {
        const float up = at.y, low = std::clamp(1.0f - up, 0.0f, 1.0f), high = std::clamp(up - 1.0f, 0.0f, 1.0f);
        body.joints.insert(body.joints.end(), {0, 1, 2, 0, 1, 0});
        body.joint_weights.insert(body.joint_weights.end(), {0.5f * low, 0.75f * (1.0f - low - high), high, 0.5f * low, 0.25f * (1.0f - low - high), 0.0f});
    }
    const Handle<Node> holder = edit.add(Node{.local = {.translation = {0.2f, 0.1f, -0.3f}, .rotation = glm::angleAxis(0.4f, glm::vec3(0, 0, 1)), .scale = {1.2f, 0.9f, 1.1f}}}),
                       mirror = edit.add(Node{.local = {.scale = {-1.0f, 1.0f, 1.0f}}});
    Handle<Node> bones[3];
    Skin skin, aside;
    for (int i = 0; i < 3; ++i) {
        bones[i] = edit.add(Node{.parent = i == 0 ? Handle<Node>() : bones[i - 1], .local = {.translation = {0.0f, i == 0 ? 0.0f : 0.7f, 0.0f}}});
        skin.joints.push_back(bones[i]);
        aside.joints.push_back(bones[i]);
        skin.inverse_bind.push_back(glm::translate(glm::mat4(1.0f), {0.0f, -0.7f * float(i), 0.0f}));
        aside.inverse_bind.push_back(glm::translate(skin.inverse_bind.back(), {-1.3f, 0.0f, 0.2f}));
    }
    const Handle<Mesh> pillar = edit.add(std::move(mesh));
    edit.add(Instance{.mesh = pillar, .place = {.node = holder}, .skin = edit.add(std::move(skin))});
    edit.add(Instance{.mesh = pillar, .place = {.node = holder, .node_from_object = glm::scale(glm::translate(glm::mat4(1.0f), {1.7f, 0.0f, 0.0f}), {-1.0f, 1.0f, 1.0f})}});
    edit.add(Instance{.mesh = pillar, .place = {.node = mirror}, .skin = edit.add(std::move(aside))});
    const glm::quat bent = glm::angleAxis(0.9f, glm::normalize(glm::vec3(0.3f, 0.2f, 1.0f)));
    const std::vector<float> none = {0, 0, 0, 0}, turned = {bent.x, bent.y, bent.z, bent.w};
    std::vector<float> spline;
    for (const std::vector<float>& value : {std::vector<float>{0, 0, 0, 1}, turned})
        for (const std::vector<float>* part : {&none, &value, &none}) spline.insert(spline.end(), part->begin(), part->end());
    edit.add(Animation{.channels = {{.node = bones[1], .path = AnimatedPath::Rotation, .interpolation = Interpolation::CubicSpline, .width = 4, .times = {0, 1}, .values = spline},
                                    {.node = bones[2], .path = AnimatedPath::Scale, .times = {0, 1}, .values = {1, 1, 1, 1.4f, 0.8f, 1.2f}},
                                    {.node = holder, .path = AnimatedPath::Weights, .width = 2, .times = {0, 1}, .values = {0.1f, 0.0f, 0.9f, -0.5f}},
                                    {.node = holder, .path = AnimatedPath::Translation, .times = {0, 1}, .values = {0.2f, 0.1f, -0.3f, -0.3f, 0.3f, -0.3f}}}});
    Primitive ground;
    add_quad(ground, {-3.0f, -0.3f, 3.0f}, {6.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -6.0f});
    builtin::add_object(edit, "ground", std::move(ground), edit.add(builtin::lambert("ground", glm::vec3(0.6f))));
    edit.set_environment({.scale = glm::vec3(0.5f)});
    builtin::add_camera(edit, "front", {0.4f, 1.6f, 5.0f}, {-0.3f, 0.9f, 0.0f}, 0.7f);
    return make_scene(std::move(edit));
}

// Arrays of the device by what points into them.
class DeviceArrays {
public:
    explicit DeviceArrays(Stage& stage) : stage_(stage), buffers_(stage.scene_gpu.binding().buffers) {
        instances = read<shared::Instance>(find("scene/instances").address(), stage.scene_gpu.stats().instance_rows);
        const gpu::Buffer table = find("scene/geometries");
        geometries = read<shared::Geometry>(table.address(), table.bytes() / sizeof(shared::Geometry));
    }
    template <class T>
    std::vector<T> read(uint64_t address, size_t count) {
        for (const gpu::Buffer& buffer : buffers_) {
            if (address < buffer.address() || address + count * sizeof(T) > buffer.address() + buffer.bytes()) continue;
            const gpu::Buffer copy = stage_.frame.read_back(buffer);
            stage_.frame.run();
            std::vector<T> out(count);
            std::memcpy(out.data(), copy.mapped_as<std::byte>().data() + (address - buffer.address()), count * sizeof(T));
            return out;
        }
        ADD_FAILURE() << "no buffer of the scene holds this address";
        return {};
    }
    std::vector<glm::vec3> positions(const shared::Geometry& g) { return read<glm::vec3>(g.positions, g.vertex_count); }

    std::vector<shared::Instance> instances;
    std::vector<shared::Geometry> geometries;

private:
    gpu::Buffer find(std::string_view name) const {
        return *std::ranges::find_if(buffers_, [&](const gpu::Buffer& buffer) { return buffer.name() == name; });
    }
    Stage& stage_;
    std::vector<gpu::Buffer> buffers_;
};

// Rows are slots while nothing has gone.
const Instance& instance_of(const Scene& scene, uint32_t row) { return scene.get(*scene.instances().handle_at(row)); }

double furthest(const std::vector<glm::vec3>& a, const std::vector<glm::vec3>& b) {
    double most = 0;
    for (size_t i = 0; i < a.size(); ++i) most = std::max(most, double(glm::length(a[i] - b[i])));
    return a.size() == b.size() ? most : 1e30;
}

class DeviceDeforms : public GpuTest {};

TEST_F(DeviceDeforms, vertices_as_the_host_does_and_keeps_those_of_the_frame_before) {
    Stage stage(make_pillar_scene());
    std::vector<std::vector<glm::vec3>> before;
    builtin::Random random(3u);
    for (int frame = 0; frame < 5; ++frame) {
        SCOPED_TRACE(frame);
        stage.step(pose_at(stage.scene, random.range(0.0f, 1.0f)));
        stage.scene_gpu.finish(stage.frame);
        DeviceArrays arrays(stage);
        std::vector<std::vector<glm::vec3>> now;
        for (uint32_t row = 0; row < kInstances; ++row) {
            const shared::Instance& instance = arrays.instances.at(row);
            const Mesh& form = stage.scene.get(instance_of(stage.scene, row).drawn_mesh());
            ASSERT_EQ(form.deformation.has_value(), row != 2);
            for (uint32_t g = 0; g < 2; ++g) {
                const shared::Geometry& geometry = arrays.geometries.at(instance.geometry_base + g);
                Primitive storage;
                const Primitive& expected = drawn_shape(stage.scene, form, g, storage);
                now.push_back(arrays.positions(geometry));
                EXPECT_LT(furthest(now.back(), expected.positions), 2e-6);
                for (const glm::vec3& p : now.back())
                    ASSERT_TRUE(glm::all(glm::greaterThanEqual(p, form.primitives[g].bounds.min)) && glm::all(glm::lessThanEqual(p, form.primitives[g].bounds.max)));
                const auto attributes = arrays.read<shared::VertexAttributes>(geometry.attributes, geometry.vertex_count);
                std::vector<glm::vec3> normals, tangents, tangents_expected;
                for (size_t i = 0; i < attributes.size(); ++i) {
                    normals.push_back(attributes[i].normal);
                    tangents.push_back(glm::vec3(attributes[i].tangent));
                    tangents_expected.push_back(glm::vec3(expected.tangents[i]));
                    ASSERT_EQ(attributes[i].uv0, expected.uv0[i]);
                    ASSERT_EQ(attributes[i].tangent.w, expected.tangents[i].w);
                }
                EXPECT_LT(furthest(normals, expected.normals), 2e-6);
                EXPECT_LT(furthest(tangents, tangents_expected), 2e-6);
                if (before.empty()) continue;
                EXPECT_EQ(arrays.positions(arrays.geometries.at(instance.geometry_base_before + g)), before[2 * row + g]);
                EXPECT_EQ(furthest(now.back(), before[2 * row + g]) > 1e-3, row != 2 || g == 0) << "no channel moves the stump at the mirrored pillar";
            }
        }
        before = std::move(now);
    }
}

TEST_F(DeviceDeforms, motion_leads_to_where_the_surface_was_in_every_way) {
    Stage stage(make_pillar_scene());
    stage.step(pose_at(stage.scene, 0.55));
    stage.scene_gpu.finish(stage.frame);
    const Scene before = stage.scene;
    stage.step(pose_at(stage.scene, 0.6));
    const Shot shot{.view = {.width = kSize, .height = kSize, .max_bounces = 1, .aovs = {"depth", "ids", "motion"}}, .sample_count = 1};
    const CameraView camera = view_of((*stage.scene.cameras().begin()).value, 1.0f);
    std::optional<image::FilmSums> first;
    for (const gpu::TraceWay way : kWays) {
        if (!device()->caps().supports(way)) continue;
        SCOPED_TRACE(gpu::trace_way_name(way));
        Shot of_way = shot;
        of_way.way = way;
        const image::FilmSums film = stage.render(of_way);
        const MotionFound found = check_motion(stage.scene, before, camera, film);
        ASSERT_GT(found.off.size(), 150u);
        EXPECT_LT(found.off[found.off.size() * 95 / 100], 0.25);  // what a reconstruction needs
        EXPECT_LT(found.off.back(), 2e-3);                        // what floats allow
        EXPECT_GT(found.moved, 1.0) << "it stands still";
        for (size_t layer = 0; first && layer < film.exact.size(); ++layer) EXPECT_EQ(first->exact[layer].words, film.exact[layer].words) << film.exact[layer].channel;
        first = film;
    }
    // A frame in which nothing happens: everything has come to rest.
    stage.step({});
    const image::FilmSums still = stage.render(shot);
    EXPECT_EQ(check_motion(stage.scene, stage.scene, camera, still).moved, 0.0);
}

// The scene of now with arrays instead of deformations, and nothing that deforms.
Scene in_place(const Scene& scene) {
    Scene out = scene;
    SceneEdit edit;
    for (const auto& [handle, instance] : scene.instances()) {
        const Mesh& form = scene.get(instance.drawn_mesh());
        if (!form.rest) continue;
        Mesh mesh = form.deformation ? deformed(scene.get(form.rest), {}, *form.deformation) : form;
        mesh.rest = {};
        edit.set_pose(handle, edit.add(std::move(mesh)), {});
    }
    out.apply(std::move(edit));
    return out;
}

TEST_F(DeviceDeforms, pictures_are_those_of_the_same_shapes_in_place) {
    Stage stage(make_pillar_scene());
    stage.step(pose_at(stage.scene, 0.2));
    stage.scene_gpu.finish(stage.frame);
    stage.step(pose_at(stage.scene, 0.9));  // a second form, refitted
    Stage built(in_place(stage.scene));
    for (const gpu::TraceWay way : kWays) {
        if (!device()->caps().supports(way)) continue;
        const Shot shot{.way = way, .view = {.width = kSize, .height = kSize, .max_bounces = 2, .filter = PixelFilter::Point}, .sample_count = 1};
        EXPECT_GT(share_equal(stage.picture(shot), built.picture(shot)), 0.99) << gpu::trace_way_name(way);
    }
}

// A thousand leaves that lie beside each other and then fly where others were: what was near is far apart, so the tree of the mesh at rest has
// become bad, and is made anew once. Wherever leaves are then, rays meet them as in a scene that was built so.
TEST_F(DeviceDeforms, a_tree_that_no_longer_fits_is_made_anew_of_the_form) {
    constexpr uint32_t kSide = 32;
    SceneEdit edit;
    Primitive leaves;
    std::vector<glm::vec3> places;
    for (uint32_t i = 0; i < kSide * kSide; ++i) places.push_back(glm::vec3(float(i % kSide), float(i / kSide), 0) / float(kSide) - glm::vec3(0.5f, 0.5f, 0.0f));
    builtin::Random random(5u);
    std::vector<glm::vec3> shuffled = places;
    for (size_t i = shuffled.size() - 1; i > 0; --i) std::swap(shuffled[i], shuffled[size_t(random.range(0.0f, float(i) + 0.999f))]);
    leaves.targets.resize(1);
    for (size_t i = 0; i < places.size(); ++i) {
        const auto first = static_cast<uint32_t>(leaves.positions.size());
        for (const glm::vec3& corner : {glm::vec3(0), glm::vec3(0.02f, 0, 0.01f), glm::vec3(0, 0.02f, 0)}) {
            leaves.positions.push_back(places[i] + corner);
            leaves.normals.push_back({0, 0, 1});
            leaves.targets[0].positions.push_back(shuffled[i] + glm::vec3(0, 0, random.range(-0.2f, 0.2f)) - places[i]);
        }
        leaves.triangles.push_back({first, first + 1, first + 2});
    }
    leaves.material = edit.add(Material{.name = "leaf", .base_color = glm::vec4(0.5f), .double_sided = true});
    Mesh mesh{.name = "leaves"};
    mesh.primitives.push_back(std::move(leaves));
    const Handle<Node> node = edit.add(Node{});
    edit.add(Instance{.mesh = edit.add(std::move(mesh)), .place = {.node = node}});
    edit.add(Animation{.channels = {{.node = node, .path = AnimatedPath::Weights, .width = 1, .times = {0, 1, 10}, .values = {0, 1, 1.05f}}}});
    edit.set_environment({.scale = glm::vec3(1.0f)});
    Stage stage(make_scene(std::move(edit)));
    const Shot shot{.view = {.width = kSize, .height = kSize, .max_bounces = 2, .filter = PixelFilter::Point}, .camera = look_at({0, 0, 1.6f}, {0, 0, 0}, 0.7f), .sample_count = 1};
    double worst = 0;
    for (int frame = 0; frame < 56; ++frame) {
        stage.step(pose_at(stage.scene, 0.3 + 0.05 * frame));
        stage.scene_gpu.finish(stage.frame);
        stage.frame.run();
        worst = std::max(worst, stage.scene_gpu.stats().tree_decay);
    }
    EXPECT_GT(worst, 2.0);
    EXPECT_LT(stage.scene_gpu.stats().tree_decay, 1.1);
    const uint32_t structures = 1u + uint32_t(device()->caps().supports(gpu::TraceWay::Query));  // ours, and the driver's
    EXPECT_EQ(stage.scene_gpu.stats().rebuilt_trees, structures);
    Stage built(in_place(stage.scene));
    for (const gpu::TraceWay way : kWays) {
        if (!device()->caps().supports(way)) continue;
        Shot of_way = shot;
        of_way.way = way;
        EXPECT_GT(share_equal(stage.picture(of_way), built.picture(of_way)), 0.99) << gpu::trace_way_name(way);
    }
}

// Forms that a program makes itself, torn from the first one on: the mesh at rest, which nothing draws, is still what they are held against.
TEST_F(DeviceDeforms, forms_with_arrays_are_held_against_the_mesh_at_rest_too) {
    constexpr uint32_t kSide = 32;
    const auto make_leaves = [](Handle<Material> material, bool torn, float z) {
        Primitive leaves{.material = material};
        for (uint32_t i = 0; i < kSide * kSide; ++i) {
            const uint32_t at = torn ? i * 397 % (kSide * kSide) : i, first = 3 * i;
            const glm::vec3 place = glm::vec3(float(at % kSide), float(at / kSide), 0) / float(kSide);
            for (const glm::vec3& corner : {glm::vec3(0, 0, z), glm::vec3(0.02f, 0, 0.01f), glm::vec3(0, 0.02f, 0)}) leaves.positions.push_back(place + corner);
            leaves.triangles.push_back({first, first + 1, first + 2});
        }
        Mesh mesh{.name = "leaves"};
        mesh.primitives.push_back(std::move(leaves));
        return mesh;
    };
    SceneEdit first;
    const Handle<Material> pending_material = first.add(Material{.name = "leaf"});
    const Handle<Mesh> pending_rest = first.add(make_leaves(pending_material, false, 0.0f));
    Mesh form = make_leaves(pending_material, true, 0.0f);
    form.rest = pending_rest;
    const Handle<Instance> pending = first.add(Instance{.mesh = pending_rest});
    first.set_pose(pending, first.add(std::move(form)), {});
    Scene scene;
    const ChangeSet changes = scene.apply(std::move(first));
    Stage stage(std::move(scene), {.hardware = false});
    for (int frame = 0; frame < 48; ++frame) {
        SceneEdit edit;
        Mesh next = make_leaves(changes.resolve(pending_material), true, 1e-4f * float(frame));
        next.rest = changes.resolve(pending_rest);
        edit.remove(stage.scene.get(changes.resolve(pending)).posed);
        edit.set_pose(changes.resolve(pending), edit.add(std::move(next)), {});
        stage.step(std::move(edit));
        stage.scene_gpu.finish(stage.frame);
        stage.frame.run();
    }
    EXPECT_EQ(stage.scene_gpu.stats().rebuilt_trees, 1u);
}

// A lamp that grows gives more light, and its triangles are chosen by the areas that they have now.
TEST_F(DeviceDeforms, lamps_and_their_light) {
    SceneEdit edit;
    Primitive ground, lamp;
    add_quad(ground, {-3.0f, 0.0f, 3.0f}, {6.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -6.0f});
    builtin::add_object(edit, "ground", std::move(ground), edit.add(builtin::lambert("ground", glm::vec3(0.6f))));
    add_quad(lamp, {-0.2f, 1.0f, -0.2f}, {0.4f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.4f});
    lamp.material = edit.add(builtin::lambert("glow", glm::vec3(0.0f), glm::vec3(10.0f)));
    lamp.targets.push_back({.positions = {{0, 0, 0}, {0.8f, 0, 0}, {0.4f, 0, 0.4f}, {0, 0, 0}}});
    Mesh mesh{.name = "lamp"};
    mesh.primitives.push_back(std::move(lamp));
    const Handle<Node> node = edit.add(Node{});
    edit.add(Instance{.mesh = edit.add(std::move(mesh)), .place = {.node = node}});
    edit.add(Animation{.channels = {{.node = node, .path = AnimatedPath::Weights, .width = 1, .times = {0, 1}, .values = {0, 1}}}});
    Stage stage(make_scene(std::move(edit)));
    const Shot shot{.view = {.width = 16, .height = 16, .max_bounces = 1, .filter = PixelFilter::Point}, .camera = look_at({0, 2.5f, 3.0f}, {0, 0, 0}, 0.8f), .sample_count = 16};
    const double small = mean_rgb(stage.picture(shot));
    for (const double seconds : {0.5, 1.0}) {
        stage.step(pose_at(stage.scene, seconds));
        Stage built(in_place(stage.scene));
        const image::ImageF picture = stage.picture(shot);
        EXPECT_GT(share_equal(picture, built.picture(shot)), 0.99) << seconds;
        EXPECT_GT(mean_rgb(picture), 1.2 * small);
    }
}

}  // namespace
}  // namespace parhelion::testing::deform_test
