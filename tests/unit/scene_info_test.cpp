// What `parhelion info` says is not drawn: features by the materials that use them, extensions that are not read.
#include <gtest/gtest.h>

#include "gltf_make.h"
#include "scene/gltf/extensions.h"
#include "scene/info.h"

namespace parhelion::test::scene_info_test {

namespace {

LoadedScene loaded(const GltfMaker& maker) { return {.scene = maker.load(), .scripted_edits = {}}; }

GltfMaker with_materials(const std::vector<json>& extensions) {
    GltfMaker maker;
    for (const json& extension : extensions) maker.add_triangle()["material"] = maker.push("materials", {{"extensions", extension}});
    return maker;
}

std::vector<std::string> not_drawn(const GltfMaker& maker) {
    std::vector<std::string> out;
    for (const NotDrawnRow& row : describe(loaded(maker)).not_drawn) out.push_back(fmt::format("{} {}", row.materials, row.feature));
    return out;
}

}  // namespace

TEST(SceneInfo, names_the_features_of_materials_that_are_not_drawn_and_how_many_use_them) {
    const json brushed = {{"KHR_materials_anisotropy", {{"anisotropyStrength", 1}}}};
    const json glass = {{"KHR_materials_transmission", {{"transmissionFactor", 1}}}, {"KHR_materials_volume", {{"thicknessFactor", 1}}}, {"KHR_materials_dispersion", {{"dispersion", 1}}}};
    const json rest = {{"KHR_materials_sheen", {{"sheenColorFactor", {0, 0, 0.1}}}},  // drawn
                       {"KHR_materials_anisotropy", {{"anisotropyStrength", 0.5}}},
                       {"KHR_materials_iridescence", {{"iridescenceFactor", 0.5}}}};
    const GltfMaker maker = with_materials({brushed, glass, rest});
    EXPECT_EQ(not_drawn(maker), (std::vector<std::string>{"1 dispersion", "2 anisotropy", "1 iridescence"}));
    EXPECT_CONTAINS(format_info(describe(loaded(maker))), "  not drawn    dispersion (1 material), anisotropy (2 materials), iridescence");
}

TEST(SceneInfo, features_that_nothing_shows_are_not_named) {
    const json idle = {{"KHR_materials_clearcoat", {{"clearcoatRoughnessFactor", 1}}},
                       {"KHR_materials_volume", {{"thicknessFactor", 1}}},
                       {"KHR_materials_dispersion", {{"dispersion", 1}}},
                       {"KHR_materials_iridescence", {{"iridescenceIor", 1.5}}}};
    const json unlit = {{"KHR_materials_anisotropy", {{"anisotropyStrength", 1}}}, {"KHR_materials_unlit", json::object()}};
    const json drawn = {{"KHR_materials_specular", {{"specularColorFactor", {1, 0, 0}}}}, {"KHR_materials_ior", {{"ior", 2}}}, {"KHR_materials_emissive_strength", {{"emissiveStrength", 2}}}};
    GltfMaker maker = with_materials({idle, unlit, drawn});
    maker.doc["extensionsUsed"] = {"KHR_materials_clearcoat", "KHR_materials_volume"};
    EXPECT_EQ(not_drawn(maker), std::vector<std::string>{});
    EXPECT_FALSE(contains(format_info(describe(loaded(maker))), "not drawn"));
    // A material that only a variant that is not shown wears.
    maker.push("materials", {{"extensions", {{"KHR_materials_iridescence", {{"iridescenceFactor", 1}}}}}});
    maker.doc["extensions"]["KHR_materials_variants"]["variants"] = json::array({{{"name", "glass"}}});
    maker.doc["meshes"][0]["primitives"][0]["extensions"]["KHR_materials_variants"]["mappings"] = json::array({{{"variants", {0}}, {"material", 3}}});
    EXPECT_EQ(not_drawn(maker), std::vector<std::string>{});
    EXPECT_CONTAINS(format_info(describe(loaded(maker))), "  variants     glass\n");
}

TEST(SceneInfo, extensions_of_which_something_is_not_drawn_are_named) {
    GltfMaker maker = with_materials({json::object()});
    maker.doc["extensionsUsed"] = {"KHR_animation_pointer", "KHR_xmp_json_ld", "KHR_materials_sheen", "ACME_gizmo"};
    maker.doc["extensionsRequired"] = {"KHR_animation_pointer", "KHR_xmp_json_ld", "KHR_materials_sheen"};
    const SceneInfo info = describe(loaded(maker));
    EXPECT_EQ(info.extensions_not_drawn, std::vector<std::string>{"ACME_gizmo"});
    EXPECT_EQ(info.warnings, std::vector<std::string>{"the extension ACME_gizmo is unknown and ignored"});
    EXPECT_CONTAINS(format_info(info), "  not drawn    ACME_gizmo\n");
    const json target{{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", {{"pointer", "/materials/0/emissiveFactor"}}}}}};
    maker.push("animations", {{"samplers", json::array()}, {"channels", {{{"sampler", 0}, {"target", target}}}}});
    EXPECT_CONTAINS(format_info(describe(loaded(maker))), "  not drawn    ACME_gizmo, KHR_animation_pointer\n");
}

TEST(SceneInfo, cameras_without_a_name_are_listed_too) {
    GltfMaker maker;
    EXPECT_CONTAINS(format_info(describe(loaded(maker))), "  cameras      none\n");
    for (int i = 0; i < 2; ++i) maker.add_node({{"camera", maker.push("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}}}})}});
    EXPECT_CONTAINS(format_info(describe(loaded(maker))), "  cameras      (no name), (no name)\n");
}

TEST(GltfExtensions, are_known_by_their_whole_names) {
    EXPECT_EQ(extension_use("KHR_materials_volume"), ExtensionUse::Read);
    EXPECT_EQ(extension_use("KHR_xmp_json_ld"), ExtensionUse::Harmless);
    for (const char* name : {"", "KHR_materials_vol", "KHR_materials_volume_scatter", "khr_materials_volume"}) EXPECT_EQ(extension_use(name), ExtensionUse::Unknown);
}

}  // namespace parhelion::test::scene_info_test
