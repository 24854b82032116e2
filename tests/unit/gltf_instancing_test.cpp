// EXT_mesh_gpu_instancing.
#include <gtest/gtest.h>

#include "gltf_make.h"

namespace parhelion::test::gltf_instancing_test {

namespace {

// A node at (10, 0, 0) whose triangle stands where `attributes` say.
struct InstancedFile {
    GltfMaker maker;
    InstancedFile() {
        maker.add_triangle();
        maker.doc["extensionsUsed"] = maker.doc["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
        maker.doc["nodes"][0]["translation"] = {10, 0, 0};
    }
    json& attributes() { return maker.doc["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]; }
    std::vector<glm::mat4> places() const {
        const Scene scene = maker.load();
        EXPECT_EQ(scene.meshes().size(), 1u);
        std::vector<glm::mat4> out;
        for (const auto& [handle, instance] : scene.instances()) out.push_back(instance.place.world_from_object);
        return out;
    }
};

glm::vec3 at(const glm::mat4& m, glm::vec3 p) { return glm::vec3(m * glm::vec4(p, 1.0f)); }

void expect_near(glm::vec3 a, glm::vec3 b) { EXPECT_LT(glm::length(a - b), 1e-5f) << a.x << " " << a.y << " " << a.z; }

}  // namespace

TEST(GltfInstancing, each_instance_is_scaled_then_turned_then_moved_within_its_node) {
    InstancedFile file;
    const float h = std::sqrt(0.5f);
    file.attributes() = {{"TRANSLATION", file.maker.floats({1, 2, 3, 0, 0, 5}, "VEC3")},
                         {"ROTATION", file.maker.floats({0, 0, h, h, 0, 0, 0, 1}, "VEC4")},
                         {"SCALE", file.maker.floats({2, 3, 1, -1, 1, 1}, "VEC3")}};
    const std::vector<glm::mat4> places = file.places();
    ASSERT_EQ(places.size(), 2u);
    expect_near(at(places[0], {0, 0, 0}), {11, 2, 3});
    expect_near(at(places[0], {1, 0, 0}), {11, 4, 3});  // x doubled, then a quarter turn about z
    expect_near(at(places[0], {0, 1, 0}), {8, 2, 3});
    expect_near(at(places[1], {1, 0, 0}), {9, 0, 5});
}

TEST(GltfInstancing, any_one_attribute_will_do_and_others_are_not_read) {
    InstancedFile file;
    file.attributes() = {{"SCALE", file.maker.floats({2, 2, 2, 3, 3, 3, 4, 4, 4}, "VEC3")}, {"_ID", 9999}};
    const std::vector<glm::mat4> places = file.places();
    ASSERT_EQ(places.size(), 3u);
    expect_near(at(places[2], {1, 0, 0}), {14, 0, 0});
}

TEST(GltfInstancing, rotations_may_be_normalised_integers) {
    InstancedFile bytes, shorts;
    const int a = bytes.maker.accessor<int8_t>({0, 0, 127, 0}, GltfMaker::kByte, "VEC4");
    const int b = shorts.maker.accessor<int16_t>({0, 0, 23170, 23170}, GltfMaker::kShort, "VEC4");
    bytes.maker.doc["accessors"][a]["normalized"] = shorts.maker.doc["accessors"][b]["normalized"] = true;
    bytes.attributes() = {{"ROTATION", a}};
    shorts.attributes() = {{"ROTATION", b}};
    expect_near(at(bytes.places().at(0), {1, 0, 0}), {9, 0, 0});
    expect_near(at(shorts.places().at(0), {1, 0, 0}), {10, 1, 0});
}

TEST(GltfInstancing, rotations_without_length_turn_nothing_and_are_told) {
    InstancedFile file;
    file.attributes() = {{"ROTATION", file.maker.floats({0, 0, 0, 0, 0, 0, 5, 0}, "VEC4")}};
    const std::vector<glm::mat4> places = file.places();
    expect_near(at(places.at(0), {1, 0, 0}), {11, 0, 0});
    expect_near(at(places.at(1), {1, 0, 0}), {9, 0, 0});  // of any length
    const Scene scene = file.maker.load();
    ASSERT_EQ(scene.source().warnings.size(), 1u);
    EXPECT_CONTAINS(scene.source().warnings[0], "1 rotations have no length");
}

TEST(GltfInstancing, without_a_count_nothing_is_placed) {
    InstancedFile file;
    file.attributes() = json::object();
    const Scene scene = file.maker.load();
    EXPECT_EQ(scene.instances().size(), 0u);
    EXPECT_CONTAINS(scene.source().warnings.at(0), "places no instance");
}

TEST(GltfInstancing, counts_that_differ_or_take_all_memory_and_places_beyond_measure_are_refused) {
    InstancedFile file;
    file.attributes() = {{"TRANSLATION", file.maker.floats({0, 0, 0, 1, 1, 1}, "VEC3")}, {"SCALE", file.maker.floats({1, 1, 1}, "VEC3")}};
    EXPECT_CONTAINS(file.maker.error(), "SCALE: has 1 elements, but there are 2 instances");
    file.attributes() = {{"TRANSLATION", file.maker.push("accessors", {{"componentType", 5126}, {"type", "VEC3"}, {"count", 20000}})}};
    EXPECT_CONTAINS(error_of(to_bytes(file.maker.text()), {.budget_base_bytes = 2u << 20}), "EXT_mesh_gpu_instancing: would take");
    file.attributes() = {{"SCALE", file.maker.floats({1e30f, 1, 1}, "VEC3")}};
    EXPECT_CONTAINS(file.maker.error(), "beyond all measure");
}

}  // namespace parhelion::test::gltf_instancing_test
