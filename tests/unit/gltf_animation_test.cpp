// Animations of glTF files, right and wrong.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>

#include "base/platform.h"
#include "gltf_make.h"
#include "scene/info.h"
#include "scene/load.h"

namespace parhelion::test::gltf_animation_test {

namespace {

// A triangle on node 0 that one animation moves; the sampler may be changed.
struct Moving : GltfMaker {
    Moving() {
        add_triangle();
        doc["nodes"][0]["name"] = "mover";
        doc["animations"][0] = {{"name", "move"}, {"samplers", json::array()}, {"channels", json::array()}};
        channel("translation", floats({0.5, 1, 2}, "SCALAR"), floats({0, 0, 0, 1, 0, 0, 1, 5, 0}, "VEC3"));
    }
    json& channel(const std::string& path, int input, int output, const std::string& interpolation = "LINEAR") {
        json& animation = doc["animations"][0];
        animation["samplers"].push_back({{"input", input}, {"output", output}, {"interpolation", interpolation}});
        animation["channels"].push_back({{"sampler", animation["samplers"].size() - 1}, {"target", {{"node", 0}, {"path", path}}}});
        return animation["channels"].back();
    }
    json& sampler(size_t i = 0) { return doc["animations"][0]["samplers"][i]; }
    json& target(size_t i = 0) { return doc["animations"][0]["channels"][i]["target"]; }
};

const Animation& only_animation(const Scene& scene) {
    EXPECT_EQ(scene.animations().size(), 1u);
    return (*scene.animations().begin()).value;
}

std::string error_with(const std::function<void(Moving&)>& change) {
    Moving maker;
    change(maker);
    return maker.error();
}

bool has_warning(const Scene& scene, const std::string& part) {
    for (const std::string& warning : scene.source().warnings)
        if (contains(warning, part)) return true;
    return false;
}

}  // namespace

TEST(GltfAnimation, channels_of_every_path_and_interpolation_are_read) {
    Moving maker;
    maker.doc["meshes"][0]["primitives"][0]["targets"] = json::array({json::object(), json::object()});
    const int times = maker.floats({0, 1}, "SCALAR");
    const int turns = maker.accessor<int16_t>({0, 0, 0, 32767, 0, 0, 32767, 0}, GltfMaker::kShort, "VEC4");
    maker.doc["accessors"][static_cast<size_t>(turns)]["normalized"] = true;
    maker.channel("rotation", times, turns, "STEP");
    maker.channel("scale", times, maker.floats(std::vector<float>(18, 2), "VEC3"), "CUBICSPLINE");
    const int weights = maker.accessor<uint8_t>({0, 255, 51, 0}, GltfMaker::kUByte, "SCALAR");
    maker.doc["accessors"][static_cast<size_t>(weights)]["normalized"] = true;
    maker.channel("weights", times, weights);
    const Scene scene = maker.load();
    const Animation& animation = only_animation(scene);
    EXPECT_EQ(animation.name, "move");
    ASSERT_EQ(animation.channels.size(), 4u);
    for (const AnimationChannel& c : animation.channels) EXPECT_EQ(scene.get(c.node).name, "mover");
    const AnimationChannel &move = animation.channels[0], &turn = animation.channels[1], &scale = animation.channels[2], &morph = animation.channels[3];
    EXPECT_EQ(move.times, (std::vector<float>{0.5f, 1, 2}));
    EXPECT_EQ(move.values, (std::vector<float>{0, 0, 0, 1, 0, 0, 1, 5, 0}));
    EXPECT_EQ(turn.interpolation, Interpolation::Step);
    EXPECT_EQ(turn.values, (std::vector<float>{0, 0, 0, 1, 0, 0, 1, 0}));
    EXPECT_EQ(scale.interpolation, Interpolation::CubicSpline);
    EXPECT_EQ(scale.values.size(), 18u);
    EXPECT_EQ(morph.path, AnimatedPath::Weights);
    EXPECT_EQ(morph.width, 2u);
    ASSERT_EQ(morph.values.size(), 4u);
    EXPECT_EQ(morph.values[1], 1.0f);
    EXPECT_NEAR(morph.values[2], 0.2f, 1e-6f);
    EXPECT_TRUE(scene.source().warnings.empty());
}

TEST(GltfAnimation, channels_without_a_node_in_the_scene_and_pointers_are_left_out) {
    Moving maker;
    maker.doc["nodes"].push_back(json::object());  // in no scene
    const int input = maker.sampler()["input"], output = maker.sampler()["output"];
    maker.channel("scale", input, output)["target"].erase("node");
    maker.channel("scale", input, output)["target"]["node"] = 1;
    for (int i = 0; i < 2; ++i)
        maker.channel("pointer", input, output)["target"] = {{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", {{"pointer", "/materials/0"}}}}}};
    maker.channel("weights", input, output);
    maker.channel("colour", input, output);
    const Scene scene = maker.load();
    EXPECT_EQ(only_animation(scene).channels.size(), 1u);
    EXPECT_EQ(scene.source().warnings.size(), 3u);
    EXPECT_TRUE(has_warning(scene, "of what KHR_animation_pointer animates, all but nodes, their visibility, lights and cameras stands still"));
    EXPECT_TRUE(has_warning(scene, "animations[0].channels[5].target: animates weights, but its node has no morph targets"));
    EXPECT_TRUE(has_warning(scene, "'colour' cannot be animated"));
}

TEST(GltfAnimation, pointers_move_nodes_their_visibility_lights_and_cameras) {
    Moving maker;
    maker.doc["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "spot"}, {"spot", json::object()}}};
    const int wide = maker.push("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}}}});
    const int flat = maker.push("cameras", {{"type", "orthographic"}, {"orthographic", {{"xmag", 1}, {"ymag", 1}, {"znear", 1}, {"zfar", 9}}}});
    for (int i = 0; i < 2; ++i) maker.add_node({{"camera", i == 0 ? wide : flat}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
    maker.doc["nodes"][0]["extensions"]["KHR_node_visibility"]["visible"] = false;
    const int times = maker.floats({0, 1}, "SCALAR"), numbers = maker.floats({0.25, 0.5}, "SCALAR"), vectors = maker.floats({1, 0, 0, 0, 1, 0}, "VEC3");
    const int bytes = maker.accessor<uint8_t>({1, 0}, GltfMaker::kUByte, "SCALAR"), shorts = maker.accessor<uint16_t>({100, 300}, GltfMaker::kUShort, "SCALAR");
    const auto point = [&](const std::string& pointer, int output, const std::string& interpolation = "LINEAR") {
        maker.channel("pointer", times, output, interpolation)["target"] = {{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", {{"pointer", pointer}}}}}};
    };
    point("/nodes/0/scale", vectors);
    point("/nodes/0/extensions/KHR_node_visibility/visible", bytes, "STEP");
    point("/extensions/KHR_lights_punctual/lights/0/color", vectors);
    point("/extensions/KHR_lights_punctual/lights/0/intensity", shorts);
    point("/extensions/KHR_lights_punctual/lights/0/spot/outerConeAngle", numbers);
    point("/extensions/KHR_lights_punctual/lights/0/spot/innerConeAngle", numbers);
    point("/cameras/0/perspective/yfov", numbers);
    point("/cameras/1/orthographic/xmag", numbers);
    point("/cameras/1/orthographic/ymag", numbers);
    const Scene scene = maker.load();
    EXPECT_EQ(scene.source().warnings, std::vector<std::string>{});
    const std::vector<AnimationChannel>& channels = only_animation(scene).channels;
    ASSERT_EQ(channels.size(), 14u);  // each of the two lights is one of its own
    EXPECT_EQ(channels[1].path, AnimatedPath::Scale);
    EXPECT_EQ(scene.get(channels[2].node).name, "mover");
    EXPECT_EQ(channels[2].path, AnimatedPath::Visible);
    EXPECT_EQ(channels[2].values, (std::vector<float>{1, 0}));
    EXPECT_FALSE(scene.get(channels[2].node).visible);
    EXPECT_EQ(channels[3].path, AnimatedPath::Color);
    EXPECT_TRUE(channels[3].light && channels[4].light && channels[3].light != channels[4].light);
    EXPECT_EQ(channels[5].values, (std::vector<float>{100, 300}));
    EXPECT_EQ(channels[11].path, AnimatedPath::Yfov);
    EXPECT_EQ(scene.get(channels[11].camera).kind, CameraKind::Perspective);
    EXPECT_EQ(scene.get(channels[13].camera).kind, CameraKind::Orthographic);

    const auto error = [&](const std::string& pointer, int output, const std::string& interpolation) {
        Moving other = maker;
        other.channel("pointer", times, output, interpolation)["target"] = {{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", {{"pointer", pointer}}}}}};
        return other.error();
    };
    EXPECT_CONTAINS(error("/nodes/7/scale", vectors, "LINEAR"), "points to nothing in the file");
    EXPECT_CONTAINS(error("/cameras/2/perspective/yfov", numbers, "LINEAR"), "points to nothing in the file");
    EXPECT_CONTAINS(error("/extensions/KHR_lights_punctual/lights/1/color", vectors, "LINEAR"), "points to nothing in the file");
    EXPECT_CONTAINS(error("/nodes/0/translation", vectors, "LINEAR"), "moves what a channel before it moves");
    EXPECT_CONTAINS(error("/nodes/1/extensions/KHR_node_visibility/visible", bytes, "LINEAR"), "is not interpolated");
    EXPECT_CONTAINS(error("/nodes/1/scale", numbers, "LINEAR"), "expected 3");
    EXPECT_EQ(error("/nodes/-1/scale", vectors, "LINEAR"), "");  // no pointer to anything that moves
    maker.channel("pointer", times, vectors)["target"].erase("node");
    EXPECT_TRUE(has_warning(maker.load(), "animates a pointer, but names none"));
}

TEST(GltfAnimation, keys_must_be_in_order_and_as_many_as_values) {
    EXPECT_CONTAINS(error_with([](Moving& m) { m.sampler()["input"] = m.floats({0, 1, 1}, "SCALAR"); }), "samplers[0].input: key 2 at 1 seconds does not follow key 1 at 1");
    EXPECT_CONTAINS(error_with([](Moving& m) { m.sampler()["input"] = m.floats({-1, 0, 1}, "SCALAR"); }), "its first key is at -1 seconds");
    EXPECT_CONTAINS(error_with([](Moving& m) { m.sampler()["input"] = m.floats({0, 1}, "SCALAR"); }), "samplers[0].output: has 3 elements, but 2 keys need 2");
    EXPECT_CONTAINS(error_with([](Moving& m) { m.sampler()["interpolation"] = "CUBICSPLINE"; }), "has 3 elements, but 3 keys need 9");
    EXPECT_CONTAINS(error_with([](Moving& m) { m.sampler()["input"] = m.floats({NAN, 1, 2}, "SCALAR"); }), "element 0 is not a finite number");
    EXPECT_CONTAINS(error_with([](Moving& m) { m.doc["accessors"][m.sampler()["input"].get<size_t>()]["count"] = 0; }), "has no keys");
}

TEST(GltfAnimation, times_without_data_and_animations_without_channels_are_warnings) {
    Moving maker;
    maker.sampler()["input"] = maker.push("accessors", {{"componentType", GltfMaker::kFloat}, {"type", "SCALAR"}, {"count", 3}});
    maker.push("animations", {{"channels", json::array()}, {"samplers", json::array()}});
    const Scene scene = maker.load();
    EXPECT_EQ(scene.animations().size(), 2u);
    EXPECT_TRUE(has_warning(scene, "animations[0].channels[0]: has times without data and is left out"));
    EXPECT_TRUE(has_warning(scene, "animations[1]: has no channels"));
}

TEST(GltfAnimation, types_and_references_that_do_not_fit_are_refused) {
    EXPECT_CONTAINS(error_with([](Moving& m) { m.sampler()["output"] = m.sampler()["input"]; }), "expected 3");
    EXPECT_CONTAINS(error_with([](Moving& m) { m.sampler()["input"] = m.accessor<uint8_t>({0, 1, 2}, GltfMaker::kUByte, "SCALAR"); }), "does not have floats");
    EXPECT_CONTAINS(error_with([](Moving& m) { m.sampler()["interpolation"] = "MAGIC"; }), "'MAGIC' is no interpolation");
    EXPECT_CONTAINS(error_with([](Moving& m) { m.doc["animations"][0]["channels"][0]["sampler"] = 4; }), "names sampler 4, but there are 1");
    EXPECT_CONTAINS(error_with([](Moving& m) { m.target()["node"] = 4; }), "names nodes[4]");
    EXPECT_CONTAINS(error_with([](Moving& m) { m.channel("translation", m.sampler()["input"], m.sampler()["output"]); }),
                    "animations[0].channels[1].target: moves what a channel before it moves");
    EXPECT_CONTAINS(error_with([](Moving& m) { m.doc["nodes"][0]["matrix"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}; }), "its node has a matrix");
}

TEST(GltfAnimation, rotations_that_are_not_unit_are_a_warning) {
    Moving maker;
    maker.channel("rotation", maker.floats({0}, "SCALAR"), maker.floats({0, 0, 0, 2}, "VEC4"));
    EXPECT_TRUE(has_warning(maker.load(), "the rotation of key 0 is not a unit quaternion"));
}

TEST(GltfAnimation, keys_are_counted_as_memory_before_they_are_read) {
    Moving maker;
    maker.sampler()["output"] = maker.push("accessors", {{"componentType", GltfMaker::kFloat}, {"type", "VEC3"}, {"count", 4000000000u}});
    EXPECT_CONTAINS(error_of(to_bytes(maker.text())), "memory");
}

TEST(GltfAnimation, loading_poses_the_scene_and_info_lists_what_moves) {
    const std::filesystem::path path = std::filesystem::temp_directory_path() / fmt::format("parhelion-animation-{}.gltf", platform::process_id());
    std::ofstream(path) << Moving().text();
    const auto x_at = [&](double seconds, const std::string& animation) {
        const LoadedScene loaded = load_scene(path.string(), {.animation = animation, .time = seconds});
        return (*loaded.scene.instances().begin()).value.place.world_from_object[3].x;
    };
    EXPECT_EQ(x_at(0.0, ""), 0.0f);
    EXPECT_EQ(x_at(0.75, ""), 0.5f);
    EXPECT_EQ(x_at(100.0, "move"), 1.0f);
    EXPECT_THROW(x_at(0.0, "stand"), Error);
    const std::string text = format_info(describe(load_scene(path.string())));
    EXPECT_CONTAINS(text, "animations   0 'move': 2 seconds, 1 channels");
    std::filesystem::remove(path);
}

TEST(SceneInfo, counts_meshes_at_rest_and_names_skins_and_morph_targets) {
    LoadedScene loaded;
    SceneEdit edit;
    Primitive p{.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, .triangles = {{0, 1, 2}}, .material = edit.add(Material{})};
    p.targets.resize(2);
    Mesh mesh{.name = "face", .primitives = {p}, .target_names = {"smile", ""}};
    Mesh posed{.primitives = {p}};
    posed.primitives[0].targets.clear();
    const Handle<Node> joint = edit.add(Node{});
    const Handle<Skin> skin = edit.add(Skin{.name = "rig", .joints = {joint}, .inverse_bind = {glm::mat4(1.0f)}});
    edit.set_pose(edit.add(Instance{.mesh = edit.add(std::move(mesh)), .skin = skin}), edit.add(std::move(posed)), {});
    loaded.scene.apply(std::move(edit));
    const SceneInfo info = describe(loaded);
    EXPECT_EQ(info.meshes, 1u);
    EXPECT_EQ(info.triangles, 1u);
    EXPECT_EQ(info.vertices, 3u);
    EXPECT_EQ(info.instanced_triangles, 1u);
    const std::string text = format_info(info);
    EXPECT_CONTAINS(text, "skins        'rig': 1 joints");
    EXPECT_CONTAINS(text, "morphs       'face': 2 targets (smile)");
}

}  // namespace parhelion::test::gltf_animation_test
