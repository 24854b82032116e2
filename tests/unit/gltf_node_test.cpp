// Nodes: hierarchy, placement, and what hangs on them.
#include <gtest/gtest.h>

#include <cmath>

#include "gltf_make.h"
#include "scene/gltf/json.h"

namespace parhelion::test::gltf_node_test {

namespace {

const Instance& only_instance(const Scene& scene) {
    EXPECT_EQ(scene.instances().size(), 1u);
    return (*scene.instances().begin()).value;
}

GltfMaker with_node(json node) {
    GltfMaker maker;
    maker.add_triangle();
    node["mesh"] = 0;
    maker.doc["nodes"][0] = std::move(node);
    return maker;
}

glm::vec3 place(const Scene& scene, glm::vec3 p) { return glm::vec3(only_instance(scene).place.world_from_object * glm::vec4(p, 1.0f)); }
void expect_near(glm::vec3 a, glm::vec3 b) { EXPECT_LT(glm::length(a - b), 1e-5f) << a.x << " " << a.y << " " << a.z; }

}  // namespace

TEST(GltfNodes, apply_scale_then_rotation_then_translation) {
    const float half = std::sqrt(0.5f);
    const GltfMaker maker = with_node({{"translation", {10, 0, 0}}, {"rotation", {0, 0, half, half}}, {"scale", {2, 3, 4}}});
    const Scene scene = maker.load();
    expect_near(place(scene, {1, 0, 0}), {10, 2, 0});  // a quarter turn about z takes +x to +y
    expect_near(place(scene, {0, 1, 0}), {7, 0, 0});
    expect_near(place(scene, {0, 0, 1}), {10, 0, 4});
}

TEST(GltfNodes, matrices_are_column_major_and_compose_down_the_hierarchy) {
    GltfMaker maker = with_node({{"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1}}});
    maker.doc["nodes"].push_back({{"scale", {2, 2, 2}}, {"children", {0}}});
    maker.doc["scenes"][0]["nodes"] = {1};
    const Scene scene = maker.load();
    expect_near(place(scene, {1, 0, 0}), {12, 12, 14});
    EXPECT_EQ(scene.nodes().size(), 2u);
    const Node& child = scene.get(only_instance(scene).place.node);
    EXPECT_EQ(scene.get(child.parent).children.size(), 1u);
}

TEST(GltfNodes, negative_and_zero_scales_are_told) {
    const Scene mirrored = with_node({{"scale", {-1, 1, 1}}}).load();
    EXPECT_TRUE(mirrors(only_instance(mirrored).place.world_from_object));
    EXPECT_TRUE(drawable(only_instance(mirrored).place.world_from_object));
    const Scene turned = with_node({{"scale", {-1, -1, 1}}}).load();
    EXPECT_FALSE(mirrors(only_instance(turned).place.world_from_object));
    const Scene flat = with_node({{"scale", {1, 0, 1}}}).load();
    EXPECT_FALSE(drawable(only_instance(flat).place.world_from_object));
    EXPECT_TRUE(flat.bounds().empty());
}

TEST(GltfNodes, roundings_in_the_last_row_of_a_matrix_do_no_harm) {
    const Scene scene = with_node({{"matrix", {1, 0, 0, 1e-7, 0, 1, 0, 0, 0, 0, 1, -1e-7, 5, 6, 7, 0.9999999}}}).load();
    const glm::mat4 m = *(*scene.nodes().begin()).value.local.matrix;
    EXPECT_EQ(glm::vec4(m[0][3], m[1][3], m[2][3], m[3][3]), glm::vec4(0, 0, 0, 1));
    EXPECT_EQ(glm::vec3(m[3]), glm::vec3(5, 6, 7));
}

TEST(GltfNodes, broken_transforms_are_refused) {
    EXPECT_CONTAINS(with_node({{"matrix", {1, 2, 3}}}).error(), "nodes[0].matrix: is array, expected an array of 16 numbers");
    EXPECT_CONTAINS(with_node({{"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 2}}}).error(), "nodes[0].matrix: is not affine");
    EXPECT_CONTAINS(with_node({{"rotation", {0, 0, 0, 0}}}).error(), "nodes[0].rotation: has no length");
    EXPECT_CONTAINS(with_node({{"translation", {0, "x", 0}}}).error(), "nodes[0].translation[1]: is \"x\", expected a number");
    EXPECT_CONTAINS(with_node({{"scale", {1e300, 1, 1}}}).error(), "nodes[0].scale[0]: is 1e+300, expected a number in the range of float");
    GltfMaker far = with_node({{"scale", {1e20, 1, 1}}});
    far.doc["nodes"].push_back({{"scale", {1e20, 1, 1}}, {"children", {0}}});
    far.doc["scenes"][0]["nodes"] = {1};
    EXPECT_CONTAINS(far.error(), "beyond all measure");
}

TEST(GltfNodes, cycles_and_second_parents_are_refused) {
    GltfMaker maker;
    for (const json& children : {json{1}, json{2}, json{0}}) maker.push("nodes", {{"children", children}});
    EXPECT_CONTAINS(maker.error(), "nodes[0]: is among its own descendants");
    maker.doc["nodes"] = json::array({{{"children", {0}}}});
    EXPECT_CONTAINS(maker.error(), "nodes[0].children[0]: node 0 is its own child");
    maker.doc["nodes"] = json::array({{{"children", {2}}}, {{"children", {2}}}, json::object()});
    EXPECT_CONTAINS(maker.error(), "nodes[1].children[0]: node 2 is a child of node 0 already");
    maker.doc["nodes"] = json::array({{{"children", {1, 1}}}, json::object()});
    EXPECT_CONTAINS(maker.error(), "nodes[0].children[1]: node 1 is a child of node 0 already");
    maker.doc["nodes"] = json::array({{{"children", {7}}}});
    EXPECT_CONTAINS(maker.error(), "nodes[0].children[0]: names nodes[7], but the file has only 1");
}

TEST(GltfNodes, scenes_list_each_root_once) {
    GltfMaker maker;
    maker.doc["nodes"] = json::array({{{"children", {1}}}, json::object()});
    maker.doc["scenes"][0]["nodes"] = {0, 1};
    EXPECT_CONTAINS(maker.error(), "scenes[0].nodes[1]: node 1 is not a root");
    maker.doc["scenes"][0]["nodes"] = {0, 0};
    EXPECT_CONTAINS(maker.error(), "scenes[0].nodes[1]: node 0 is listed twice");
    maker.doc["scenes"][0]["nodes"] = {0};
    maker.doc["scene"] = 3;
    EXPECT_CONTAINS(maker.error(), "scene: names scenes[3], but the file has only 1");
}

TEST(GltfNodes, only_the_default_scene_is_read_and_without_scenes_all_roots) {
    GltfMaker maker;
    maker.add_triangle();
    maker.doc["nodes"].push_back({{"mesh", 0}, {"name", "other"}});
    maker.doc["scenes"].push_back({{"nodes", {1}}});
    maker.doc["scene"] = 1;
    const Scene second = maker.load();
    EXPECT_EQ((*second.nodes().begin()).value.name, "other");
    EXPECT_EQ(second.nodes().size(), 1u);
    maker.doc.erase("scene");
    maker.doc.erase("scenes");
    const Scene all = maker.load();
    EXPECT_EQ(all.nodes().size(), 2u);
    EXPECT_EQ(all.source().warnings.size(), 1u);
}

TEST(GltfNodes, an_empty_scene_is_a_warning) {
    const Scene scene = GltfMaker().load();
    EXPECT_EQ(scene.source().warnings, std::vector<std::string>{"the scene is empty"});
}

TEST(GltfNodes, a_chain_of_twenty_thousand_nodes_is_no_problem) {
    GltfMaker maker;
    constexpr int kDepth = 20000;
    json nodes = json::array();
    for (int i = 0; i + 1 < kDepth; ++i) nodes.push_back({{"translation", {1, 0, 0}}, {"children", {i + 1}}});
    nodes.push_back({{"camera", 0}});
    maker.doc["nodes"] = std::move(nodes);
    maker.doc["scenes"][0]["nodes"] = {0};
    maker.push("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 1.0}, {"znear", 0.1}}}});
    const Scene scene = maker.load();
    const Camera& camera = (*scene.cameras().begin()).value;
    EXPECT_FLOAT_EQ(camera.place.world_from_object[3].x, float(kDepth - 1));
}

// A camera or light comes once for each node that names it, and its name with it.
TEST(GltfNodes, a_long_name_that_every_node_takes_is_counted) {
    for (const bool light : {false, true}) {
        GltfMaker maker;
        const std::string name(100000, 'x');
        maker.push("cameras", {{"name", name}, {"type", "perspective"}, {"perspective", {{"yfov", 1.0}, {"znear", 0.1}}}});
        maker.doc["extensions"]["KHR_lights_punctual"]["lights"] = json::array({{{"name", name}, {"type", "point"}}});
        for (int i = 0; i < 1000; ++i)
            maker.add_node(light ? json{{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}} : json{{"camera", 0}});
        const std::string error = error_of(to_bytes(maker.text()), {.budget_base_bytes = 8u << 20});
        EXPECT_CONTAINS(error, "the budget for this scene");
        EXPECT_CONTAINS(error, light ? "KHR_lights_punctual.light" : ".camera");
    }
}

TEST(GltfNodes, memory_of_instances_is_counted_where_nodes_have_a_mesh) {
    constexpr uint64_t kCount = 1000;
    const auto charged = [](const json& node) {
        GltfMaker maker;
        maker.add_triangle();
        for (uint64_t i = 0; i < kCount; ++i) maker.add_node(node);
        const std::vector<std::byte> file = maker.glb();
        SceneFiles files({});
        read_gltf(files, file, "test.glb");
        return files.bytes_charged();
    };
    constexpr uint64_t kMember = 2 * JsonLimits::kBytesPerValue;  // what the text itself may be counted for
    const uint64_t more = charged({{"mesh", 0}}) - charged(json::object());
    EXPECT_GE(more, kCount * 2 * sizeof(Instance));
    EXPECT_LE(more, kCount * (2 * sizeof(Instance) + kMember));
    EXPECT_GE(charged(json::object()), kCount * 2 * sizeof(Node));
}

TEST(GltfNodes, cameras_of_both_kinds_are_read) {
    GltfMaker maker;
    maker.push("cameras", {{"name", "near"}, {"type", "perspective"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.25}, {"zfar", 10}}}});
    maker.push("cameras", {{"type", "orthographic"}, {"orthographic", {{"xmag", 2}, {"ymag", -3}, {"znear", 0}, {"zfar", 5}}}});
    maker.add_node({{"camera", 0}});
    maker.add_node({{"camera", 1}, {"name", "map"}, {"translation", {0, 7, 0}}});
    const Scene scene = maker.load();
    std::vector<Camera> cameras;
    for (const auto& [handle, camera] : scene.cameras()) cameras.push_back(camera);
    ASSERT_EQ(cameras.size(), 2u);
    EXPECT_EQ(cameras[0].name, "near");
    EXPECT_FLOAT_EQ(cameras[0].yfov, 0.5f);
    EXPECT_FLOAT_EQ(*cameras[0].far_plane, 10.0f);
    EXPECT_EQ(cameras[1].name, "map");
    EXPECT_EQ(cameras[1].kind, CameraKind::Orthographic);
    EXPECT_FLOAT_EQ(cameras[1].ymag, 3.0f);
    EXPECT_FLOAT_EQ(cameras[1].place.world_from_object[3].y, 7.0f);
}

TEST(GltfNodes, broken_cameras_are_refused) {
    const auto error = [](json camera) {
        GltfMaker maker;
        maker.push("cameras", std::move(camera));
        maker.add_node({{"camera", 0}});
        return maker.error();
    };
    EXPECT_CONTAINS(error({{"type", "fisheye"}}), "cameras[0].type: 'fisheye' is no kind of camera");
    EXPECT_CONTAINS(error({{"type", "perspective"}}), "cameras[0]: lacks 'perspective'");
    EXPECT_CONTAINS(error({{"type", "perspective"}, {"perspective", {{"yfov", 0}, {"znear", 1}}}}),
                    "cameras[0].perspective.yfov: is 0, expected more than 0");
    EXPECT_CONTAINS(error({{"type", "perspective"}, {"perspective", {{"yfov", 4}, {"znear", 1}}}}), "expected less than pi");
    EXPECT_CONTAINS(error({{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}, {"zfar", 1}}}}), "zfar is not beyond");
    EXPECT_CONTAINS(error({{"type", "orthographic"}, {"orthographic", {{"xmag", 0}, {"ymag", 1}, {"znear", 0}, {"zfar", 1}}}}),
                    "must not be 0");
}

TEST(GltfNodes, punctual_lights_of_all_kinds_are_read_in_their_units) {
    GltfMaker maker;
    maker.doc["extensionsUsed"] = {"KHR_lights_punctual"};
    maker.doc["extensions"]["KHR_lights_punctual"]["lights"] =
        json::array({{{"type", "directional"}, {"intensity", 3}, {"color", {1, 0.5, 0}}},
                     {{"type", "point"}, {"name", "bulb"}, {"range", 8}},
                     {{"type", "spot"}, {"spot", {{"innerConeAngle", 0.1}, {"outerConeAngle", 0.2}}}}});
    for (int i = 0; i < 3; ++i) maker.add_node({{"name", "holder"}, {"extensions", {{"KHR_lights_punctual", {{"light", i}}}}}});
    const Scene scene = maker.load();
    std::vector<Light> lights;
    for (const auto& [handle, light] : scene.lights()) lights.push_back(light);
    ASSERT_EQ(lights.size(), 3u);
    EXPECT_EQ(lights[0].kind, LightKind::Directional);
    EXPECT_EQ(lights[0].color, glm::vec3(1, 0.5f, 0));
    EXPECT_EQ(lights[0].name, "holder");
    EXPECT_EQ(lights[1].name, "bulb");
    EXPECT_FLOAT_EQ(lights[1].range, 8.0f);
    EXPECT_FLOAT_EQ(lights[1].intensity, 1.0f);
    EXPECT_EQ(lights[2].kind, LightKind::Spot);
    EXPECT_FLOAT_EQ(lights[2].inner_cone, 0.1f);

    json& table = maker.doc["extensions"]["KHR_lights_punctual"]["lights"];
    table[0]["type"] = "ambient";
    EXPECT_CONTAINS(maker.error(), "extensions.KHR_lights_punctual.lights[0].type: 'ambient' is no kind of light");
    table[0] = {{"type", "point"}, {"intensity", -1}};
    EXPECT_CONTAINS(maker.error(), "its intensity or colour is negative");
    table[0] = {{"type", "spot"}, {"spot", {{"innerConeAngle", 0.5}, {"outerConeAngle", 0.2}}}};
    EXPECT_CONTAINS(maker.error(), "out of order");
    table.erase(2);
    table[0] = {{"type", "point"}};
    EXPECT_CONTAINS(maker.error(), "nodes[2].extensions.KHR_lights_punctual.light: names light 2, but the file has 2");
}

}  // namespace parhelion::test::gltf_node_test
