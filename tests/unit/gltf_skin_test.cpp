// Skins, joints and weights of vertices, and morph targets of glTF files.
#include <gtest/gtest.h>

#include <functional>

#include "gltf_make.h"
#include "scene/deform.h"
#include "scene/pose.h"

namespace parhelion::test {

namespace {

constexpr std::initializer_list<float> kUp = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 2, 0, 1};  // moves by (0, 2, 0)

// A triangle whose corners hang on joints 0, 1, 1 of nodes 1 and 2; the mesh is on node 0.
GltfMaker skinned() {
    GltfMaker maker;
    json& attributes = maker.add_triangle()["attributes"];
    attributes["JOINTS_0"] = maker.accessor<uint8_t>({0, 9, 9, 9, 1, 0, 0, 0, 1, 0, 0, 0}, GltfMaker::kUByte, "VEC4");
    attributes["WEIGHTS_0"] = maker.floats({1, 0, 0, 0, 1, 0, 0, 0, 0.5f, 0.5f, 0, 0}, "VEC4");
    maker.add_node({{"name", "lower"}, {"translation", {5, 0, 0}}, {"children", {2}}});
    maker.push("nodes", {{"name", "upper"}, {"translation", {0, 1, 0}}});
    std::vector<float> matrices = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    matrices.insert(matrices.end(), kUp);
    maker.push("skins", {{"name", "rig"}, {"joints", {1, 2}}, {"inverseBindMatrices", maker.floats(matrices, "MAT4")}});
    maker.doc["nodes"][0]["skin"] = 0;
    return maker;
}

json& attributes_of(GltfMaker& maker) { return maker.doc["meshes"][0]["primitives"][0]["attributes"]; }
json& primitive_of(GltfMaker& maker) { return maker.doc["meshes"][0]["primitives"][0]; }

GltfMaker morphed() {
    GltfMaker maker;
    json& primitive = maker.add_triangle();
    primitive["targets"] = json::array({{{"POSITION", maker.floats({1, 0, 0, 1, 0, 0, 1, 0, 0}, "VEC3")}},
                                        {{"POSITION", maker.floats({0, 0, 1, 0, 0, 2, 0, 0, 3}, "VEC3")},
                                         {"NORMAL", maker.floats({1, 0, 0, 0, 0, 0, 0, 0, 0}, "VEC3")}}});
    return maker;
}

const Instance& first_instance(const Scene& scene) { return (*scene.instances().begin()).value; }

bool has_warning(const Scene& scene, const std::string& part) {
    for (const std::string& warning : scene.source().warnings)
        if (contains(warning, part)) return true;
    return false;
}

}  // namespace

TEST(GltfSkin, joints_and_inverse_bind_matrices_are_read) {
    const Scene scene = skinned().load();
    ASSERT_EQ(scene.skins().size(), 1u);
    const Skin& skin = (*scene.skins().begin()).value;
    EXPECT_EQ(skin.name, "rig");
    EXPECT_EQ(scene.get(skin.joints[0]).name, "lower");
    EXPECT_EQ(scene.get(skin.joints[1]).name, "upper");
    EXPECT_EQ(skin.inverse_bind[1][3], glm::vec4(0, 2, 0, 1));
    EXPECT_TRUE(first_instance(scene).skin);
    EXPECT_TRUE(scene.source().warnings.empty());
}

TEST(GltfSkin, without_inverse_bind_matrices_they_are_the_identity) {
    GltfMaker maker = skinned();
    maker.doc["skins"][0].erase("inverseBindMatrices");
    EXPECT_EQ((*maker.load().skins().begin()).value.inverse_bind, std::vector<glm::mat4>(2, glm::mat4(1.0f)));
}

TEST(GltfSkin, vertices_have_their_joints_and_those_of_no_weight_count_as_0) {
    const Scene scene = skinned().load();
    const Primitive& p = only_primitive(scene);
    EXPECT_EQ(p.influence_count, 4u);
    EXPECT_EQ(p.joints, (std::vector<uint16_t>{0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}));
    EXPECT_EQ(p.joint_weights[9], 0.5f);
}

TEST(GltfSkin, a_loaded_skin_poses_its_mesh) {
    Scene scene = skinned().load();
    scene.apply(pose_at(scene, 0.0));
    Primitive storage;
    const Primitive& p = drawn_shape(scene, scene.get(first_instance(scene).drawn_mesh()), 0, storage);
    EXPECT_EQ(p.positions[0], glm::vec3(5, 0, 0));
    EXPECT_EQ(p.positions[1], glm::vec3(6, 3, 0));     // one up by its joint, two by its inverse bind matrix
    EXPECT_EQ(p.positions[2], glm::vec3(5, 2.5f, 0));  // half of each
}

TEST(GltfSkin, several_sets_of_all_types_make_one_list) {
    GltfMaker maker = skinned();
    json& attributes = attributes_of(maker);
    attributes["JOINTS_1"] = maker.accessor<uint16_t>({1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, GltfMaker::kUShort, "VEC4");
    attributes["WEIGHTS_0"] = maker.accessor<uint8_t>({51, 0, 0, 0, 255, 0, 0, 0, 255, 0, 0, 0}, GltfMaker::kUByte, "VEC4");
    attributes["WEIGHTS_1"] = maker.accessor<uint16_t>({52428, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, GltfMaker::kUShort, "VEC4");
    for (const char* name : {"WEIGHTS_0", "WEIGHTS_1"}) maker.doc["accessors"][attributes[name].get<size_t>()]["normalized"] = true;
    const Scene scene = maker.load();
    const Primitive& p = only_primitive(scene);
    EXPECT_EQ(p.influence_count, 8u);
    EXPECT_EQ(p.joints[4], 1);
    EXPECT_NEAR(p.joint_weights[0], 0.2f, 1e-6f);
    EXPECT_NEAR(p.joint_weights[4], 0.8f, 1e-6f);
    EXPECT_TRUE(scene.source().warnings.empty());
}

TEST(GltfSkin, weights_that_do_not_sum_to_one_are_scaled_with_a_warning) {
    GltfMaker maker = skinned();
    attributes_of(maker)["WEIGHTS_0"] = maker.floats({0, 0, 0, 0, 2, -1, 0, 0, 1, 3, 0, 0}, "VEC4");
    const Scene scene = maker.load();
    EXPECT_TRUE(has_warning(scene, "weights of 3 vertices did not sum to 1"));
    const std::vector<float>& w = only_primitive(scene).joint_weights;
    EXPECT_EQ((std::vector<float>{w[0], w[4], w[5], w[8], w[9]}), (std::vector<float>{1, 1, 0, 0.25f, 0.75f}));
}

TEST(GltfSkin, what_does_not_fit_together_is_refused_by_name) {
    const auto error = [](const std::function<void(GltfMaker&)>& change) {
        GltfMaker maker = skinned();
        change(maker);
        return maker.error();
    };
    EXPECT_CONTAINS(error([](GltfMaker& m) { m.doc["skins"][0]["joints"] = {1}; }), "nodes[0].skin: its mesh names joint 1, but the skin has 1");
    EXPECT_CONTAINS(error([](GltfMaker& m) { m.doc["skins"][0]["joints"] = json::array(); }), "skins[0].joints: is empty");
    EXPECT_CONTAINS(error([](GltfMaker& m) { m.doc["skins"][0]["joints"] = {1, 7}; }), "skins[0].joints[1]: names nodes[7]");
    EXPECT_CONTAINS(error([](GltfMaker& m) { m.doc["skins"][0]["joints"] = {1, 2, 1}; }), "has 2 matrices, but there are 3 joints");
    EXPECT_CONTAINS(error([](GltfMaker& m) { m.doc["nodes"][0]["skin"] = 1; }), "nodes[0].skin: names skins[1]");
    EXPECT_CONTAINS(error([](GltfMaker& m) { m.doc["skins"][0]["inverseBindMatrices"] = attributes_of(m)["WEIGHTS_0"]; }), "is not a MAT4 of floats");
    EXPECT_CONTAINS(error([](GltfMaker& m) { m.doc["skins"][0]["inverseBindMatrices"] = m.floats(std::vector<float>(32, 1), "MAT4"); }),
                    "matrix 0 is not affine");
    EXPECT_CONTAINS(error([](GltfMaker& m) { attributes_of(m)["JOINTS_0"] = attributes_of(m)["WEIGHTS_0"]; }), "is not a VEC4 of unsigned bytes or shorts");
    EXPECT_CONTAINS(error([](GltfMaker& m) { attributes_of(m)["WEIGHTS_0"] = attributes_of(m)["JOINTS_0"]; }), "floats or normalised integers");
    EXPECT_CONTAINS(error([](GltfMaker& m) { attributes_of(m)["WEIGHTS_0"] = m.floats({1, 0, 0, 0}, "VEC4"); }), "has 1 elements, but there are 3 positions");
    EXPECT_CONTAINS(error([](GltfMaker& m) { attributes_of(m)["COLOR_0"] = m.floats(std::vector<float>(48, 1), "MAT4"); }), "expected VEC3 or VEC4");
    EXPECT_CONTAINS(error([](GltfMaker& m) {
                        for (int i = 1; i < 17; ++i)
                            for (const char* name : {"JOINTS_", "WEIGHTS_"})
                                attributes_of(m)[name + std::to_string(i)] = attributes_of(m)[name + std::string("0")];
                    }),
                    "JOINTS_16: is one set too many");
}

TEST(GltfSkin, halves_of_a_skin_are_warnings_and_the_mesh_stays_rigid) {
    GltfMaker no_weights = skinned();
    attributes_of(no_weights).erase("WEIGHTS_0");
    const Scene a = no_weights.load();
    EXPECT_TRUE(has_warning(a, "JOINTS_0 has no WEIGHTS_0"));
    EXPECT_TRUE(has_warning(a, "has a skin, but its mesh has no joints"));
    EXPECT_FALSE(first_instance(a).skin);
    GltfMaker no_skin = skinned();
    no_skin.doc["nodes"][0].erase("skin");
    EXPECT_TRUE(has_warning(no_skin.load(), "its mesh has joints, but the node has no skin"));
}

TEST(GltfSkin, joints_of_another_scene_are_there_but_not_drawn) {
    GltfMaker maker = skinned();
    maker.doc["nodes"][1]["mesh"] = 0;
    maker.doc["nodes"][2]["camera"] = 0;
    maker.push("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 1.0}, {"znear", 0.1}}}});
    maker.doc["scenes"][0]["nodes"] = {0};
    Scene scene = maker.load();
    EXPECT_TRUE(has_warning(scene, "skins[0]: has joints that the scene does not have"));
    EXPECT_EQ(scene.nodes().size(), 3u);
    EXPECT_EQ(scene.instances().size(), 1u);
    EXPECT_TRUE(scene.cameras().empty());
    scene.apply(pose_at(scene, 0.0));
    Primitive storage;
    EXPECT_EQ(drawn_shape(scene, scene.get(first_instance(scene).drawn_mesh()), 0, storage).positions[1], glm::vec3(6, 3, 0));
}

TEST(GltfMorph, targets_weights_and_names_are_read) {
    GltfMaker maker = morphed();
    maker.doc["meshes"][0]["weights"] = {0.5, 0};
    maker.doc["meshes"][0]["extras"]["targetNames"] = {"smile", "frown"};
    maker.doc["nodes"][0]["weights"] = {0, 1};
    const Scene scene = maker.load();
    const Mesh& mesh = (*scene.meshes().begin()).value;
    ASSERT_EQ(mesh.primitives[0].targets.size(), 2u);
    EXPECT_EQ(mesh.primitives[0].targets[1].positions[2], glm::vec3(0, 0, 3));
    EXPECT_EQ(mesh.primitives[0].targets[1].normals[0], glm::vec3(1, 0, 0));
    EXPECT_TRUE(mesh.primitives[0].targets[0].normals.empty());
    EXPECT_EQ(mesh.weights, (std::vector<float>{0.5f, 0.0f}));
    EXPECT_EQ(mesh.target_names, (std::vector<std::string>{"smile", "frown"}));
    EXPECT_EQ(first_instance(scene).weights, (std::vector<float>{0, 1}));
}

TEST(GltfMorph, sparse_targets_need_no_buffer_view) {
    GltfMaker maker = morphed();
    const int indices = maker.view(std::vector<uint16_t>{1, 2}), values = maker.view(std::vector<float>{7, 8, 9, 4, 5, 6});
    primitive_of(maker)["targets"][0]["POSITION"] =
        maker.push("accessors", {{"componentType", GltfMaker::kFloat}, {"type", "VEC3"}, {"count", 3},
                                 {"sparse", {{"count", 2}, {"indices", {{"bufferView", indices}, {"componentType", GltfMaker::kUShort}}}, {"values", {{"bufferView", values}}}}}});
    const Scene scene = maker.load();
    EXPECT_EQ(only_primitive(scene).targets[0].positions, (std::vector<glm::vec3>{{0, 0, 0}, {7, 8, 9}, {4, 5, 6}}));
}

TEST(GltfMorph, counts_that_differ_are_refused_and_odd_extras_are_not) {
    GltfMaker maker = morphed();
    maker.doc["meshes"][0]["weights"] = {1};
    EXPECT_CONTAINS(maker.error(), "meshes[0].weights: has 1 numbers, but there are 2 morph targets");
    maker = morphed();
    maker.doc["nodes"][0]["weights"] = {1, 2, 3};
    EXPECT_CONTAINS(maker.error(), "nodes[0].weights: has 3 numbers");
    maker = morphed();
    maker.doc["meshes"][0]["primitives"].push_back(primitive_of(maker));
    maker.doc["meshes"][0]["primitives"][1]["targets"].erase(0);
    EXPECT_CONTAINS(maker.error(), "meshes[0].primitives: one has 2 morph targets, another 1");
    maker = morphed();
    primitive_of(maker)["targets"][0]["POSITION"] = maker.floats({1, 2, 3}, "VEC3");
    EXPECT_CONTAINS(maker.error(), "targets[0].POSITION: has 1 elements, but there are 3 positions");
    for (const json& extras : {json(3), json{{"targetNames", 3}}, json{{"targetNames", {1, 2}}}, json{{"targetNames", {"one"}}}}) {
        maker = morphed();
        maker.doc["meshes"][0]["extras"] = extras;
        EXPECT_EQ(maker.error(), "");
    }
}

TEST(GltfMorph, deltas_of_what_the_mesh_lacks_are_ignored_and_of_colors_warned) {
    GltfMaker maker = morphed();
    attributes_of(maker).erase("NORMAL");
    primitive_of(maker)["targets"][0]["COLOR_0"] = 0;
    const Scene scene = maker.load();
    EXPECT_TRUE(only_primitive(scene).targets[1].normals.empty());
    EXPECT_TRUE(has_warning(scene, "morph targets of COLOR_0 are not drawn"));
}

TEST(GltfMorph, made_vertices_keep_their_targets_and_joints_and_stay_flat) {
    GltfMaker maker = skinned();
    // Two triangles share corners 1 and 2; a normal map makes tangents, and no normals make corners of their own.
    const int target = maker.floats({0, 0, 1, 0, 0, 2, 0, 0, 3}, "VEC3");
    primitive_of(maker)["targets"] = json::array({{{"POSITION", target}}});
    primitive_of(maker)["indices"] = maker.accessor<uint16_t>({0, 1, 2, 2, 1, 0}, GltfMaker::kUShort, "SCALAR");
    attributes_of(maker).erase("NORMAL");
    maker.push("images", {{"uri", "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNkYPhfDwAChwGA60e6kgAAAABJRU5ErkJggg=="}});
    maker.push("textures", {{"source", 0}});
    maker.push("materials", {{"normalTexture", {{"index", 0}}}});
    primitive_of(maker)["material"] = 0;
    const Scene scene = maker.load();
    const Primitive& p = only_primitive(scene);
    ASSERT_EQ(p.positions.size(), 6u);
    EXPECT_EQ(p.tangents.size(), 6u);
    EXPECT_TRUE(p.normals.empty());
    const std::vector<float> z{1, 2, 3, 3, 2, 1};
    for (size_t i = 0; i < 6; ++i) {
        EXPECT_EQ(p.targets[0].positions[i].z, z[i]) << i;
        EXPECT_EQ(p.joints[4 * i], z[i] == 1 ? 0 : 1) << i;
        EXPECT_EQ(p.joint_weights[4 * i], z[i] == 3 ? 0.5f : 1.0f) << i;
    }
}

}  // namespace parhelion::test
