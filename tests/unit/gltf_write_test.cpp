// Scenes written as glTF and read again: the same scene, and the same bytes when it is written once more.
#include "scene/gltf/write.h"

#include <gtest/gtest.h>

#include <set>

#include <nlohmann/json.hpp>

#include "gltf_make.h"
#include "scene/builtin.h"
#include "scene/deform.h"
#include "scene/pose.h"
#include "support/everything_scene.h"
#include "support/scene_compare.h"

namespace parhelion::test {

namespace {

using testing::everything_scene;
using testing::moving_scene;
using testing::scene_difference;

json json_of(const std::vector<std::byte>& glb) {
    uint32_t length = 0;
    std::memcpy(&length, glb.data() + 12, 4);
    return json::parse(std::string_view(reinterpret_cast<const char*>(glb.data()) + 20, length));
}

// The bytes of an accessor's numbers as floats.
std::vector<float> floats_of(const std::vector<std::byte>& glb, const json& doc, size_t accessor) {
    uint32_t length = 0;
    std::memcpy(&length, glb.data() + 12, 4);
    const json& view = doc["bufferViews"][doc["accessors"][accessor]["bufferView"].get<size_t>()];
    std::vector<float> out(view["byteLength"].get<size_t>() / sizeof(float));
    std::memcpy(out.data(), glb.data() + 28 + length + view["byteOffset"].get<size_t>(), out.size() * sizeof(float));
    return out;
}

void expect_round_trip(const Scene& scene) {
    const std::vector<std::byte> once = write_glb(scene);
    const Scene again = load_bytes(once);
    EXPECT_EQ(again.source().warnings, std::vector<std::string>{});
    EXPECT_EQ(scene_difference(scene, again), "");
    EXPECT_TRUE(once == write_glb(again));
}

Scene edited(Scene scene, const std::function<void(SceneEdit&)>& change) {
    SceneEdit edit;
    change(edit);
    scene.apply(std::move(edit));
    return scene;
}

}  // namespace

TEST(GltfWrite, every_builtin_scene_comes_back_bit_for_bit) {
    for (const BuiltinEntry& entry : builtin_scenes()) {
        SCOPED_TRACE(entry.name);
        expect_round_trip(make_builtin(entry.name, {.triangles = 2000}).scene);
    }
}

TEST(GltfWrite, a_scene_of_everything_comes_back_bit_for_bit) { expect_round_trip(everything_scene()); }

TEST(GltfWrite, a_moving_scene_comes_back_bit_for_bit) { expect_round_trip(moving_scene()); }

TEST(GltfWrite, what_shares_a_node_or_has_none_gets_a_nameless_node_of_its_own) {
    const Scene scene = everything_scene(), again = load_bytes(write_glb(scene));
    EXPECT_EQ(again.instances().size(), scene.instances().size());
    EXPECT_EQ(again.nodes().size(), scene.nodes().size() + 6);  // three of the instances, one of the cameras, two of the lights
    for (const auto& [handle, instance] : again.instances()) EXPECT_EQ(instance.place.node_from_object, glm::mat4(1.0f));
}

TEST(GltfWrite, the_compared_scenes_differ_where_one_bit_does) {
    const Scene scene = everything_scene();
    const auto difference = [&](const std::function<void(SceneEdit&)>& change) { return scene_difference(scene, edited(scene, change)); };
    EXPECT_EQ(difference([](SceneEdit&) {}), "");
    const auto [material_handle, material] = *scene.materials().begin();
    Material other = material;
    other.sheen_color.y = std::nextafter(other.sheen_color.y, 1.0f);
    EXPECT_CONTAINS(difference([&](SceneEdit& edit) { edit.set_material(material_handle, other); }), "sheen color: differs");
    const auto [node_handle, node] = *scene.nodes().begin();
    Transform moved = node.local;
    moved.translation.x = std::nextafter(moved.translation.x, 1.0f);
    EXPECT_CONTAINS(difference([&](SceneEdit& edit) { edit.set_transform(node_handle, moved); }), "root 0 'root' translation: differs");
}

TEST(GltfWrite, the_extensions_that_are_used_are_listed_and_no_others) {
    using Names = std::set<std::string>;
    EXPECT_FALSE(json_of(write_glb(make_builtin("builtin:diffuse-box", {.emission = glm::vec3(0.5f)}).scene)).contains("extensionsRequired"));
    Scene plain;
    EXPECT_FALSE(json_of(write_glb(plain)).contains("extensionsUsed"));
    const json everything = json_of(write_glb(everything_scene()));
    EXPECT_EQ(everything["extensionsUsed"].get<Names>(),
              (Names{"KHR_lights_punctual", "KHR_materials_anisotropy", "KHR_materials_clearcoat", "KHR_materials_dispersion",
                     "KHR_materials_emissive_strength", "KHR_materials_ior", "KHR_materials_iridescence", "KHR_materials_sheen", "KHR_materials_specular",
                     "KHR_materials_transmission", "KHR_materials_unlit", "KHR_materials_variants", "KHR_materials_volume", "KHR_texture_transform"}));
    EXPECT_FALSE(everything.contains("extensionsRequired"));
}

TEST(GltfWrite, emission_above_1_is_a_factor_within_1_times_a_power_of_two) {
    const json doc = json_of(write_glb(everything_scene()));
    const json& full = doc["materials"][0];
    EXPECT_EQ(full["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"], 1024.0);
    EXPECT_EQ(full["emissiveFactor"][1].get<float>(), 1000.1f / 1024.0f);
    EXPECT_FALSE(doc["materials"][1].contains("emissiveFactor"));
}

TEST(GltfWrite, arrays_that_primitives_share_are_written_once_and_indices_are_as_small_as_they_may_be) {
    const json doc = json_of(write_glb(everything_scene()));
    const json& primitives = doc["meshes"][0]["primitives"];
    EXPECT_EQ(primitives[0]["attributes"], primitives[1]["attributes"]);
    EXPECT_NE(primitives[0]["indices"], primitives[1]["indices"]);
    EXPECT_EQ(doc["accessors"][primitives[0]["indices"].get<size_t>()]["componentType"], 5123);
    EXPECT_EQ(doc["accessors"][primitives[2]["indices"].get<size_t>()]["componentType"], 5125);
    const json& positions = doc["accessors"][primitives[0]["attributes"]["POSITION"].get<size_t>()];
    EXPECT_EQ(positions["min"], json::array({0.0, 0.0, 0.0}));
    EXPECT_EQ(positions["max"][1], 0.7);
    for (const json& view : doc["bufferViews"]) EXPECT_EQ(view["byteOffset"].get<uint64_t>() % 4, 0u);
}

TEST(GltfWrite, a_kept_image_file_is_written_as_it_was_and_others_as_png) {
    const Scene scene = everything_scene();
    const std::vector<std::byte> glb = write_glb(scene);
    const json doc = json_of(glb);
    ASSERT_EQ(doc["images"].size(), 2u);
    for (const json& image : doc["images"]) EXPECT_EQ(image["mimeType"], "image/png");
    for (const auto& [handle, image] : scene.images()) {
        if (!image.encoded) continue;
        const auto found = std::search(glb.begin(), glb.end(), image.encoded->begin(), image.encoded->end());
        EXPECT_NE(found, glb.end());
    }
}

TEST(GltfWrite, webp_and_ktx2_files_name_their_extension_as_required) {
    const auto write_with = [](std::string_view magic) {
        std::string file(magic);
        file.resize(64);
        const std::vector<std::byte> bytes = to_bytes(file);
        SceneEdit edit;
        const Handle<Image> image = edit.add(Image{
            .name = "i", .width = 4, .height = 4, .format = TexelFormat::Bc7, .texels = std::vector<uint8_t>(16), .encoded = std::make_shared<const std::vector<std::byte>>(bytes)});
        const Handle<Texture> texture = edit.add(Texture{.image = image});
        edit.add(Material{.base_color_texture = {.texture = texture}});
        Scene scene;
        scene.apply(std::move(edit));
        return json_of(write_glb(scene));
    };
    const json webp = write_with(std::string_view("RIFF\x38\0\0\0WEBPVP8 ", 16)), ktx2 = write_with("\xABKTX 20\xBB\r\n\x1A\n");
    EXPECT_EQ(webp["extensionsRequired"], json::array({"EXT_texture_webp"}));
    EXPECT_EQ(webp["textures"][0]["extensions"]["EXT_texture_webp"]["source"], 0);
    EXPECT_FALSE(webp["textures"][0].contains("source"));
    EXPECT_EQ(ktx2["extensionsRequired"], json::array({"KHR_texture_basisu"}));
    EXPECT_EQ(ktx2["images"][0]["mimeType"], "image/ktx2");
}

TEST(GltfWrite, compressed_blocks_without_their_file_are_an_error_that_says_what_to_do) {
    Scene scene = edited(Scene{}, [](SceneEdit& edit) {
        edit.add(Image{.name = "bricks", .width = 4, .height = 4, .format = TexelFormat::Bc1, .texels = std::vector<uint8_t>(8)});
    });
    try {
        write_glb(scene);
        FAIL();
    } catch (const Error& error) {
        EXPECT_CONTAINS(error.line, "image 'bricks': is stored as compressed blocks");
        EXPECT_CONTAINS(error.line, "keep_encoded");
    }
}

TEST(GltfWrite, skins_targets_and_animations_are_written) {
    const std::vector<std::byte> glb = write_glb(moving_scene());
    const json doc = json_of(glb);
    const json& mesh = doc["meshes"][0];
    EXPECT_EQ(mesh["extras"]["targetNames"], json::array({"smile", "frown"}));
    EXPECT_EQ(mesh["weights"], json::array({0.1, 0.9}));
    EXPECT_EQ(mesh["primitives"][0]["targets"].size(), 2u);
    EXPECT_EQ(doc["accessors"][mesh["primitives"][0]["attributes"]["JOINTS_0"].get<size_t>()]["componentType"], 5123);
    EXPECT_EQ(doc["nodes"][0]["skin"], 0);
    EXPECT_EQ(doc["nodes"][0]["weights"], json::array({0.3, 0.4}));
    EXPECT_EQ(doc["skins"][0]["joints"], json::array({2, 1}));
    EXPECT_EQ(floats_of(glb, doc, doc["skins"][0]["inverseBindMatrices"]).size(), 32u);
    ASSERT_EQ(doc["animations"].size(), 2u);
    const json& walk = doc["animations"][0];
    EXPECT_EQ(walk["channels"][3]["target"], json({{"node", 0}, {"path", "weights"}}));
    EXPECT_EQ(walk["samplers"][1]["interpolation"], "STEP");
    EXPECT_EQ(walk["samplers"][0]["input"], walk["samplers"][1]["input"]);
    const json& times = doc["accessors"][walk["samplers"][0]["input"].get<size_t>()];
    EXPECT_EQ(times["min"], json::array({0.0}));
    EXPECT_EQ(times["max"], json::array({0.7}));
    EXPECT_EQ(doc["accessors"][walk["samplers"][3]["output"].get<size_t>()]["count"], 12);
    EXPECT_EQ(floats_of(glb, doc, walk["samplers"][2]["output"]), (std::vector<float>{0, 0, 0, 1, 2, 3, 0.5f, 0.5f, 0.5f}));
}

TEST(GltfWrite, weights_of_instances_that_shared_a_node_still_move) {
    GltfMaker maker;
    maker.add_triangle()["targets"] = json::array({{{"POSITION", maker.floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3")}}});
    maker.doc["extensionsUsed"] = {"EXT_mesh_gpu_instancing"};
    maker.doc["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] = maker.floats({-1, 0, 0, 1, 0, 0}, "VEC3");
    const json sampler{{"input", maker.floats({0, 1}, "SCALAR")}, {"output", maker.floats({0, 1}, "SCALAR")}};
    maker.push("animations", {{"samplers", {sampler}}, {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}}}});
    Scene again = load_bytes(write_glb(maker.load()));
    EXPECT_EQ(again.source().warnings, std::vector<std::string>{});
    again.apply(pose_at(again, 0.5));
    EXPECT_EQ(again.instances().size(), 2u);
    Primitive storage;
    for (const auto& [handle, instance] : again.instances()) EXPECT_EQ(drawn_shape(again, again.get(instance.drawn_mesh()), 0, storage).positions[0].z, 0.5f);
}

TEST(GltfWrite, a_posed_instance_is_written_at_rest) {
    Scene scene = moving_scene();
    const auto [handle, instance] = *scene.instances().begin();
    const std::vector<std::byte> before = write_glb(scene);
    SceneEdit edit;
    Mesh posed = scene.get(instance.mesh);
    for (glm::vec3& p : posed.primitives[0].positions) p += 1.0f;
    edit.set_pose(handle, edit.add(std::move(posed)), instance.weights);
    scene.apply(std::move(edit));
    EXPECT_TRUE(before == write_glb(scene));
}

TEST(GltfWrite, what_gltf_cannot_say_is_warned_of) {
    std::vector<std::string> warnings;
    write_glb(everything_scene(), {}, &warnings);
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_CONTAINS(warnings[0], "light 'sun' has a size");
    write_glb(make_builtin("builtin:furnace").scene, {}, &warnings);
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_CONTAINS(warnings[0], "the environment is left out");
    glm::mat4 shear(1.0f);
    shear[1][0] = 0.5f;
    write_glb(edited(Scene{}, [&](SceneEdit& edit) { edit.add(Node{.name = "leaning", .local = {.matrix = shear}}); }), {}, &warnings);
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_CONTAINS(warnings[0], "node 'leaning' is sheared");
}

TEST(GltfWrite, an_empty_scene_is_a_file_of_an_empty_scene) {
    const json doc = json_of(write_glb(Scene{}));
    EXPECT_EQ(doc["scenes"], json::array({json::object()}));
    EXPECT_FALSE(doc.contains("buffers"));
    EXPECT_TRUE(load_bytes(write_glb(Scene{})).nodes().empty());
}

TEST(GltfWrite, a_glb_that_would_be_too_large_is_refused_with_the_way_out) {
    try {
        write_glb(everything_scene(), {.max_glb_bytes = 1000});
        FAIL();
    } catch (const Error& error) {
        EXPECT_CONTAINS(error.line, "but a .glb ends at 1000 (name the output .gltf");
    }
}

}  // namespace parhelion::test
