// KHR_materials_variants.
#include <gtest/gtest.h>

#include "gltf_make.h"
#include "scene/info.h"
#include "scene/load.h"

namespace parhelion::test::gltf_variant_test {

namespace {

// A triangle of material 0 ("plain"), which is "red" in variants 0 and 2; "lonely" is not used at all.
GltfMaker shoe() {
    GltfMaker maker;
    json& primitive = maker.add_triangle();
    primitive["material"] = 0;
    primitive["extensions"]["KHR_materials_variants"]["mappings"] = json::array({{{"variants", {0, 2}}, {"material", 1}}});
    for (const char* name : {"plain", "red", "lonely"}) maker.push("materials", {{"name", name}});
    maker.doc["extensions"]["KHR_materials_variants"]["variants"] = json::array({{{"name", "street"}}, {{"name", "beach"}}, {{"name", "evening"}}});
    maker.doc["extensionsUsed"] = {"KHR_materials_variants"};
    return maker;
}

std::string shown(const GltfMaker& maker, const std::string& variant) {
    const Scene scene = maker.load({.median_order = false, .variant = variant});
    return scene.get(only_primitive(scene).material).name;
}

}  // namespace

TEST(GltfVariants, are_read_with_the_materials_that_only_they_use) {
    const Scene scene = shoe().load();
    EXPECT_EQ(scene.source().variants, (std::vector<std::string>{"street", "beach", "evening"}));
    EXPECT_EQ(scene.materials().size(), 2u);
    const Primitive& primitive = only_primitive(scene);
    EXPECT_EQ(scene.get(primitive.material).name, "plain");
    ASSERT_EQ(primitive.variant_materials.size(), 3u);
    EXPECT_EQ(scene.get(primitive.variant_materials[0]).name, "red");
    EXPECT_FALSE(primitive.variant_materials[1]);
    EXPECT_EQ(primitive.variant_materials[2], primitive.variant_materials[0]);
    EXPECT_TRUE(scene.source().warnings.empty());
}

TEST(GltfVariants, one_that_is_chosen_is_worn_where_a_primitive_has_it) {
    EXPECT_EQ(shown(shoe(), ""), "plain");
    EXPECT_EQ(shown(shoe(), "street"), "red");
    EXPECT_EQ(shown(shoe(), "beach"), "plain");
    EXPECT_EQ(shown(shoe(), "evening"), "red");
    GltfMaker maker = shoe();
    maker.doc["meshes"][0]["primitives"][0].erase("extensions");
    EXPECT_EQ(shown(maker, "street"), "plain");
}

TEST(GltfVariants, an_unknown_name_is_a_usage_error_that_lists_the_names) {
    const auto error_of_choice = [](const auto& load) -> std::string {
        try {
            load();
        } catch (const Error& error) {
            EXPECT_EQ(error.code, ErrorCode::Usage);
            return error.line;
        }
        return {};
    };
    EXPECT_CONTAINS(error_of_choice([] { shown(shoe(), "x\n"); }), "--variant: test.gltf has no material variant 'x\\x0a' (it has: street, beach, evening)");
    GltfMaker none;
    none.add_triangle();
    EXPECT_CONTAINS(error_of_choice([&] { shown(none, "street"); }), "it has none at all");
    EXPECT_CONTAINS(error_of_choice([] { load_scene("builtin:cornell", {.variant = "street"}); }), "builtin:cornell has no material variant 'street'");
}

TEST(GltfVariants, broken_mappings_are_errors_that_name_the_place) {
    const auto broken = [](const char* pointer, json value) {
        GltfMaker maker = shoe();
        maker.doc[json::json_pointer(pointer)] = std::move(value);
        return maker.error();
    };
    const char* mapping = "/meshes/0/primitives/0/extensions/KHR_materials_variants/mappings/0";
    EXPECT_CONTAINS(broken((mapping + std::string("/variants/1")).c_str(), 3), "mappings[0].variants[1]: names variant 3, but the file has 3");
    EXPECT_CONTAINS(broken((mapping + std::string("/material")).c_str(), 7), "mappings[0].material: names materials[7]");
    EXPECT_CONTAINS(broken((mapping + std::string("/variants")).c_str(), 0), "mappings[0].variants: is 0, expected an array");
    EXPECT_CONTAINS(broken("/extensions/KHR_materials_variants/variants/1", json::object()), "variants[1]: lacks 'name'");
    EXPECT_CONTAINS(broken("/extensions/KHR_materials_variants", json::object()), "extensions.KHR_materials_variants: lacks 'variants'");
}

TEST(GltfVariants, a_variant_mapped_twice_keeps_its_first_material_with_a_warning) {
    GltfMaker maker = shoe();
    maker.doc["meshes"][0]["primitives"][0]["extensions"]["KHR_materials_variants"]["mappings"].push_back({{"variants", {2}}, {"material", 2}});
    EXPECT_EQ(shown(maker, "evening"), "red");
    EXPECT_EQ(maker.load().source().warnings.size(), 1u);
}

TEST(GltfVariants, a_table_of_variants_beyond_the_memory_budget_is_refused) {
    GltfMaker maker = shoe();
    json& primitives = maker.doc["meshes"][0]["primitives"];
    for (int i = 0; i < 200; ++i) primitives.push_back(primitives[0]);
    json& variants = maker.doc["extensions"]["KHR_materials_variants"]["variants"];
    for (int i = 0; i < 1000; ++i) variants.push_back({{"name", "v"}});
    const std::vector<std::byte> file = to_bytes(maker.text());
    EXPECT_EQ(error_of(file, {.budget_base_bytes = 9'000'000, .budget_factor = 0}), "");
    EXPECT_CONTAINS(error_of(file, {.budget_base_bytes = 3'000'000, .budget_factor = 0}), "meshes[0].primitives[");
}

TEST(GltfVariants, meshes_get_the_tangents_that_any_of_their_materials_needs) {
    GltfMaker maker = shoe();
    EXPECT_TRUE(only_primitive(maker.load()).tangents.empty());
    maker.push("images", {{"uri", "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=="}});
    maker.push("textures", {{"source", 0}});
    maker.doc["materials"][1]["normalTexture"] = {{"index", 0}};
    EXPECT_EQ(only_primitive(maker.load()).tangents.size(), 3u);
}

}  // namespace parhelion::test::gltf_variant_test
