// Triangles of every mode, and the attributes that files leave out.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "gltf_make.h"

namespace parhelion::test::gltf_mesh_test {

namespace {

std::vector<float> zigzag(int count) {
    std::vector<float> out;
    for (int i = 0; i < count; ++i) out.insert(out.end(), {float(i / 2), float(i % 2), 0.0f});
    return out;
}

std::vector<glm::uvec3> triangles_of(int mode, const std::vector<uint16_t>& indices, int vertex_count) {
    GltfMaker maker;
    json primitive{{"attributes", {{"POSITION", maker.floats(zigzag(vertex_count), "VEC3")}}}, {"mode", mode}};
    if (!indices.empty()) primitive["indices"] = maker.accessor(indices, GltfMaker::kUShort, "SCALAR");
    maker.add_primitive(std::move(primitive));
    return only_primitive(maker.load()).triangles;
}

using Triangles = std::vector<glm::uvec3>;

}  // namespace

TEST(GltfMesh, lists_strips_and_fans_become_triangles_with_kept_winding) {
    EXPECT_EQ(triangles_of(4, {}, 6), (Triangles{{0, 1, 2}, {3, 4, 5}}));
    EXPECT_EQ(triangles_of(4, {2, 1, 0, 3, 4, 5}, 6), (Triangles{{2, 1, 0}, {3, 4, 5}}));
    EXPECT_EQ(triangles_of(5, {}, 5), (Triangles{{0, 1, 2}, {1, 3, 2}, {2, 3, 4}}));
    EXPECT_EQ(triangles_of(6, {}, 5), (Triangles{{1, 2, 0}, {2, 3, 0}, {3, 4, 0}}));
    EXPECT_EQ(triangles_of(6, {4, 0, 1, 2}, 5), (Triangles{{0, 1, 4}, {1, 2, 4}}));
}

TEST(GltfMesh, triangles_that_join_strips_are_dropped) {
    EXPECT_EQ(triangles_of(5, {0, 1, 2, 2, 3, 3, 4, 5}, 6), (Triangles{{0, 1, 2}, {3, 5, 4}}));
}

TEST(GltfMesh, left_over_corners_points_and_missing_positions_are_warnings) {
    GltfMaker maker;
    const int positions = maker.floats(zigzag(5), "VEC3");
    maker.add_primitive({{"attributes", {{"POSITION", positions}}}});
    json& primitives = maker.doc["meshes"][0]["primitives"];
    primitives.push_back({{"attributes", {{"POSITION", positions}}}, {"mode", 1}});
    primitives.push_back({{"attributes", {{"NORMAL", positions}}}});
    const Scene scene = maker.load();
    EXPECT_EQ(only_primitive(scene).triangles, (Triangles{{0, 1, 2}}));
    EXPECT_EQ((*scene.meshes().begin()).value.primitives.size(), 1u);
    const std::vector<std::string> expected{"meshes[0].primitives[0]: 5 corners do not make whole triangles",
                                            "meshes[0].primitives[1]: points and lines are not drawn",
                                            "meshes[0].primitives[2]: has no POSITION and is left out"};
    EXPECT_EQ(scene.source().warnings, expected);
}

TEST(GltfMesh, triangles_without_area_are_counted_in_a_warning) {
    GltfMaker maker;
    maker.add_primitive({{"attributes", {{"POSITION", maker.floats({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1, 1, 2, 2, 2}, "VEC3")}}}});
    EXPECT_EQ(maker.load().source().warnings, std::vector<std::string>{"triangles without area, which are never seen: 1"});
}

TEST(GltfMesh, indices_out_of_range_are_refused_by_name) {
    GltfMaker maker;
    maker.add_triangle()["indices"] = maker.accessor<uint16_t>({0, 1, 3}, GltfMaker::kUShort, "SCALAR");
    EXPECT_CONTAINS(maker.error(), "meshes[0].primitives[0].indices: index 2 is 3, but there are 3 vertices");
}

TEST(GltfMesh, the_primitive_restart_value_is_refused_even_where_a_vertex_has_that_number) {
    GltfMaker maker;
    const int positions = maker.floats(zigzag(300), "VEC3");
    maker.add_primitive(
        {{"attributes", {{"POSITION", positions}}}, {"indices", maker.accessor<uint8_t>({0, 1, 255}, GltfMaker::kUByte, "SCALAR")}});
    EXPECT_CONTAINS(maker.error(), "index 2 is 255, the primitive restart value");
}

TEST(GltfMesh, indices_must_be_unsigned_scalars) {
    for (const auto& [component, type] : {std::pair{GltfMaker::kShort, "SCALAR"}, std::pair{GltfMaker::kUShort, "VEC2"}}) {
        GltfMaker maker;
        maker.add_triangle()["indices"] = maker.accessor<uint16_t>({0, 1, 2, 0}, component, type);
        EXPECT_CONTAINS(maker.error(), "is not a SCALAR of unsigned integers");
    }
}

TEST(GltfMesh, attributes_of_another_length_are_refused) {
    for (const char* name : {"NORMAL", "TANGENT", "TEXCOORD_0", "TEXCOORD_1", "COLOR_0"}) {
        GltfMaker maker;
        const std::string type = std::string(name) == "NORMAL" ? "VEC3" : std::string(name).starts_with("TEX") ? "VEC2" : "VEC4";
        maker.add_triangle()["attributes"][name] = maker.floats(std::vector<float>(type == "VEC2"   ? 4
                                                                                   : type == "VEC3" ? 6
                                                                                                    : 8,
                                                                                   1.0f),
                                                                type);
        const std::string error = maker.error();
        EXPECT_CONTAINS(error, "has 2 elements, but there are 3 positions");
        EXPECT_CONTAINS(error, name);
    }
}

TEST(GltfMesh, colors_may_have_three_or_four_components_and_are_clamped) {
    GltfMaker maker;
    maker.add_triangle()["attributes"]["COLOR_0"] = maker.floats({0.5f, 0.25f, 0.125f, 2, -1, 0, 1, 1, 1}, "VEC3");
    const Scene scene = maker.load();
    EXPECT_EQ(only_primitive(scene).colors[0], glm::vec4(0.5f, 0.25f, 0.125f, 1.0f));
    EXPECT_EQ(only_primitive(scene).colors[1], glm::vec4(1, 0, 0, 1));
    GltfMaker bytes;
    const int accessor = bytes.accessor<uint8_t>({255, 0, 51, 102, 0, 0, 0, 0, 0, 0, 0, 0}, GltfMaker::kUByte, "VEC4");
    bytes.doc["accessors"][accessor]["normalized"] = true;
    bytes.add_triangle()["attributes"]["COLOR_0"] = accessor;
    const Scene byte_scene = bytes.load();
    const glm::vec4 color = only_primitive(byte_scene).colors[0];
    EXPECT_FLOAT_EQ(color.z, 0.2f);
    EXPECT_FLOAT_EQ(color.w, 0.4f);
}

TEST(GltfMesh, normals_come_out_unit_and_without_any_the_mesh_stays_flat) {
    GltfMaker maker;
    maker.add_triangle()["attributes"]["NORMAL"] = maker.floats({0, 0, 5, 0, 3, 0, 0, 0, 0}, "VEC3");
    const Scene scene = maker.load();
    EXPECT_EQ(only_primitive(scene).normals[0], glm::vec3(0, 0, 1));
    EXPECT_EQ(only_primitive(scene).normals[1], glm::vec3(0, 1, 0));
    EXPECT_EQ(only_primitive(scene).normals[2], glm::vec3(0));
    EXPECT_EQ(scene.source().warnings.size(), 1u);

    GltfMaker flat;
    flat.add_triangle()["attributes"].erase("NORMAL");
    const Scene flat_scene = flat.load();
    EXPECT_TRUE(only_primitive(flat_scene).normals.empty());
    EXPECT_TRUE(only_primitive(flat_scene).tangents.empty());
}

TEST(GltfMesh, positions_beyond_all_measure_are_refused) {
    GltfMaker maker;
    maker.add_triangle()["attributes"]["POSITION"] = maker.floats({0, 0, 0, 1, 0, 0, 0, 1e30f, 0}, "VEC3");
    EXPECT_CONTAINS(maker.error(), "meshes[0].primitives[0].attributes.POSITION: position 2 is beyond 1e+18 metres");
}

TEST(GltfMesh, an_empty_list_of_primitives_is_refused) {
    GltfMaker maker;
    maker.add_triangle();
    maker.doc["meshes"][0]["primitives"] = json::array();
    EXPECT_CONTAINS(maker.error(), "meshes[0].primitives: is empty");
    maker.doc["meshes"][0].erase("primitives");
    EXPECT_CONTAINS(maker.error(), "meshes[0]: lacks 'primitives'");
}

TEST(GltfMesh, triangles_are_median_ordered_on_import_and_stay_the_same_set) {
    GltfMaker maker;
    std::vector<float> positions;
    constexpr int kCount = 64;
    for (int i = 0; i < kCount; ++i) {
        const float x = float(i * 37 % kCount);
        positions.insert(positions.end(), {x, 0, 0, x + 1, 0, 0, x, 1, 0});
    }
    maker.add_primitive({{"attributes", {{"POSITION", maker.floats(positions, "VEC3")}}}});
    const Scene as_is = maker.load({.median_order = false}), ordered = maker.load({.median_order = true});
    const auto key = [](const glm::uvec3& t) { return std::array{t.x, t.y, t.z}; };
    const auto sorted = [&](Triangles list) {
        std::sort(list.begin(), list.end(), [&](const glm::uvec3& a, const glm::uvec3& b) { return key(a) < key(b); });
        return list;
    };
    const Primitive& primitive = only_primitive(ordered);
    EXPECT_EQ(sorted(primitive.triangles), sorted(only_primitive(as_is).triangles));
    float left = -1e9f, right = 1e9f;
    for (int i = 0; i < kCount; ++i) {
        const float x = primitive.positions[primitive.triangles[static_cast<size_t>(i)].x].x;
        if (i < kCount / 2)
            left = std::max(left, x);
        else
            right = std::min(right, x);
    }
    EXPECT_LT(left, right);
}

}  // namespace parhelion::test::gltf_mesh_test
