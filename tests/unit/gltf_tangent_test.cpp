// Tangents where a normal map needs them.
#include <gtest/gtest.h>

#include "gltf_make.h"
#include "image/encode.h"
#include "scene/shapes.h"
#include "scene/tangents.h"

namespace parhelion::test::gltf_tangent_test {

namespace {

// A material with a normal map, as number 0 of the file.
void add_normal_map(GltfMaker& maker, int uv_set = 0) {
    image::Picture8 picture{.width = 1, .height = 1, .rgb = {128, 128, 255}};
    maker.push("images", {{"bufferView", maker.view_bytes(image::encode_png(picture))}, {"mimeType", "image/png"}});
    maker.push("textures", {{"source", 0}});
    maker.push("materials", {{"normalTexture", {{"index", 0}, {"texCoord", uv_set}}}});
}

}  // namespace

TEST(GltfTangents, follow_u_with_the_bitangent_up_in_the_image) {
    GltfMaker maker;
    add_normal_map(maker);
    maker.add_triangle()["material"] = 0;  // u = x, v = 1 - y
    const Scene scene = maker.load();
    const Primitive& primitive = only_primitive(scene);
    ASSERT_EQ(primitive.tangents.size(), 3u);
    for (const glm::vec4& t : primitive.tangents) {
        EXPECT_NEAR(glm::length(t - glm::vec4(1, 0, 0, 1)), 0.0f, 1e-6f);
        EXPECT_NEAR(glm::length(glm::cross(primitive.normals[0], glm::vec3(t)) * t.w - glm::vec3(0, 1, 0)), 0.0f, 1e-6f);
    }
}

TEST(GltfTangents, are_kept_from_the_file_but_not_without_normals) {
    GltfMaker maker;
    add_normal_map(maker);
    json& primitive_json = maker.add_triangle();
    primitive_json["material"] = 0;
    primitive_json["attributes"]["TANGENT"] = maker.floats({0, 2, 0, -1, 0, 1, 0, -1, 0, 1, 0, -1}, "VEC4");
    const Scene scene = maker.load();
    EXPECT_EQ(only_primitive(scene).tangents[0], glm::vec4(0, 1, 0, -1));
    maker.doc["meshes"][0]["primitives"][0]["attributes"].erase("NORMAL");
    const Scene bare = maker.load();
    EXPECT_EQ(only_primitive(bare).tangents[0], glm::vec4(1, 0, 0, 1));
    EXPECT_EQ(only_primitive(bare).normals[0], glm::vec3(0, 0, 1));
}

TEST(GltfTangents, use_the_uv_set_of_the_normal_map) {
    GltfMaker maker;
    add_normal_map(maker, 1);
    json& primitive_json = maker.add_triangle();
    primitive_json["material"] = 0;
    primitive_json["attributes"]["TEXCOORD_1"] = maker.floats({0, 0, 0, 1, 1, 0}, "VEC2");  // u = y, v = x
    const Scene scene = maker.load();
    EXPECT_NEAR(glm::length(only_primitive(scene).tangents[0] - glm::vec4(0, 1, 0, 1)), 0.0f, 1e-6f);
    maker.doc["meshes"][0]["primitives"][0]["attributes"].erase("TEXCOORD_1");
    const Scene missing = maker.load();
    EXPECT_TRUE(only_primitive(missing).tangents.empty());
    ASSERT_EQ(missing.source().warnings.size(), 1u);
    EXPECT_CONTAINS(missing.source().warnings[0], "no TEXCOORD_1");
}

TEST(Tangents, are_smooth_over_corners_that_agree_though_vertices_are_not_shared) {
    // Two triangles of a plane, each with its own vertices; the second one's UVs are sheared.
    Primitive primitive;
    primitive.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    primitive.normals.assign(6, glm::vec3(0, 0, 1));
    primitive.uv0 = {{0, 1}, {1, 1}, {0, 0}, {1, 1}, {1, 0.5f}, {0, 0}};
    primitive.triangles = {{0, 1, 2}, {3, 4, 5}};
    generate_tangents(primitive, 0);
    EXPECT_EQ(primitive.tangents[1], primitive.tangents[3]);
    EXPECT_EQ(primitive.tangents[2], primitive.tangents[5]);
    EXPECT_NE(primitive.tangents[0], primitive.tangents[4]);
}

TEST(Tangents, split_a_vertex_where_mirrored_uvs_meet) {
    // A strip folded in u about the middle: u = 1 - |x|.
    Primitive primitive;
    primitive.positions = {{-1, 0, 0}, {0, 0, 0}, {0, 1, 0}, {1, 0, 0}};
    primitive.normals.assign(4, glm::vec3(0, 0, 1));
    primitive.uv0 = {{0, 1}, {1, 1}, {1, 0}, {0, 1}};
    primitive.uv1 = primitive.uv0;
    primitive.triangles = {{0, 1, 2}, {1, 3, 2}};
    generate_tangents(primitive, 0);
    ASSERT_EQ(primitive.positions.size(), 6u);
    EXPECT_EQ(primitive.uv1.size(), 6u);
    EXPECT_EQ(primitive.tangents.size(), 6u);
    for (int corner = 0; corner < 3; ++corner) {
        EXPECT_EQ(primitive.tangents[primitive.triangles[0][corner]], glm::vec4(1, 0, 0, 1));
        EXPECT_EQ(primitive.tangents[primitive.triangles[1][corner]], glm::vec4(-1, 0, 0, -1));
    }
    EXPECT_EQ(primitive.positions[primitive.triangles[1].x], glm::vec3(0, 0, 0));
}

TEST(Tangents, are_zero_where_uvs_are_degenerate) {
    Primitive primitive;
    primitive.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    primitive.normals.assign(3, glm::vec3(0, 0, 1));
    primitive.uv0.assign(3, glm::vec2(0.5f));
    primitive.triangles = {{0, 1, 2}};
    generate_tangents(primitive, 0);
    for (const glm::vec4& t : primitive.tangents) EXPECT_EQ(t, glm::vec4(0, 0, 0, 1));
}

TEST(Tangents, of_a_sphere_match_the_analytic_ones) {
    Primitive sphere = make_sphere(2.0f, 32, true);
    const std::vector<glm::vec4> analytic = sphere.tangents;
    generate_tangents(sphere, 0);
    ASSERT_EQ(sphere.tangents.size(), analytic.size());
    for (size_t i = 0; i < analytic.size(); ++i) {
        if (std::abs(sphere.normals[i].y) > 0.95f) continue;  // the poles have no single tangent
        EXPECT_GT(glm::dot(glm::vec3(sphere.tangents[i]), glm::vec3(analytic[i])), 0.99f) << i;
        EXPECT_EQ(sphere.tangents[i].w, analytic[i].w);
    }
}

}  // namespace parhelion::test::gltf_tangent_test
