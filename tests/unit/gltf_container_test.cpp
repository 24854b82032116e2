// Files as a whole: containers, versions, extensions, limits, and damage of every kind.
#include <gtest/gtest.h>

#include <random>

#include "gltf_make.h"
#include "image/encode.h"
#include "scene/gltf/json.h"

namespace parhelion::test::gltf_container_test {

namespace {

GltfMaker triangle() {
    GltfMaker maker;
    maker.add_triangle();
    return maker;
}

// Something of everything that the reader reads.
GltfMaker rich_file() {
    GltfMaker maker;
    json& primitive = maker.add_triangle();
    primitive["material"] = 0;
    primitive["attributes"]["COLOR_0"] = maker.floats({1, 0, 0, 0, 1, 0, 0, 0, 1}, "VEC3");
    const int sparse = maker.floats({9, 9, 8, 8, 7, 7}, "VEC2");
    const int indices = maker.view<uint8_t>({0, 2}), values = maker.view<float>({1, 2, 3, 4});
    maker.doc["accessors"][sparse]["sparse"] = {
        {"count", 2}, {"indices", {{"bufferView", indices}, {"componentType", 5121}}}, {"values", {{"bufferView", values}}}};
    maker.doc["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] = sparse;
    const image::Picture8 picture{.width = 2, .height = 2, .rgb = std::vector<uint8_t>(12, 100)};
    maker.push("images", {{"bufferView", maker.view_bytes(image::encode_png(picture))}, {"mimeType", "image/png"}});
    maker.push("samplers", {{"wrapS", 33071}});
    maker.push("textures", {{"source", 0}, {"sampler", 0}});
    maker.push("materials", {{"normalTexture", {{"index", 0}}}, {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
    maker.push("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}}}});
    maker.doc["extensions"]["KHR_lights_punctual"]["lights"] = json::array({{{"type", "point"}}});
    maker.doc["nodes"][0]["camera"] = 0;
    maker.doc["nodes"][0]["rotation"] = {0, 0, 0, 1};
    maker.doc["nodes"][0]["extensions"] = {{"KHR_lights_punctual", {{"light", 0}}}};
    return maker;
}

void patch_u32(std::vector<std::byte>& bytes, size_t offset, uint32_t value) {
    for (size_t i = 0; i < 4; ++i) bytes[offset + i] = static_cast<std::byte>(value >> (8 * i) & 0xFFu);
}

}  // namespace

TEST(GltfContainer, every_truncation_of_a_glb_is_an_error) {
    const std::vector<std::byte> glb = rich_file().glb();
    ASSERT_EQ(error_of(glb), "");
    for (size_t size = 0; size < glb.size(); ++size) {
        const std::string error = error_of(std::span(glb).first(size));
        ASSERT_NE(error, "") << "cut to " << size;
        ASSERT_TRUE(error.starts_with("test.gltf")) << error;
    }
}

TEST(GltfContainer, wrong_glb_headers_are_refused) {
    const std::vector<std::byte> good = triangle().glb();
    const auto patched = [&](size_t offset, uint32_t value) {
        std::vector<std::byte> bytes = good;
        patch_u32(bytes, offset, value);
        return error_of(bytes);
    };
    EXPECT_CONTAINS(patched(4, 1), "is a GLB of version 1");
    EXPECT_CONTAINS(patched(8, 0xFFFFFFFFu), "promises 4294967295 bytes");
    EXPECT_CONTAINS(patched(8, 13), "its last GLB chunk header is cut off");
    EXPECT_CONTAINS(patched(12, 0xFFFFFFF0u), "GLB chunk 0 has 4294967280 bytes");
    EXPECT_CONTAINS(patched(16, 0), "first GLB chunk is not JSON");
    std::vector<std::byte> longer = good;
    longer.resize(longer.size() + 5);
    EXPECT_EQ(load_bytes(longer).source().warnings.size(), 1u);
}

TEST(GltfContainer, a_buffer_without_uri_is_the_binary_chunk_only_as_buffer_zero) {
    GltfMaker maker = triangle();
    EXPECT_EQ(error_of(maker.glb()), "");
    maker.doc["buffers"] = json::array({{{"byteLength", 4}}, {{"byteLength", 4}}});
    maker.doc["bufferViews"][0]["buffer"] = 1;
    EXPECT_CONTAINS(maker.error(), "buffers[1]: has no uri");
}

TEST(GltfContainer, json_is_checked_before_it_is_parsed) {
    std::string deep = R"({"asset":{"version":"2.0"},"extras":)";
    for (int i = 0; i < 100000; ++i) deep += '[';
    EXPECT_CONTAINS(error_of(to_bytes(deep)), "nested 100001 levels deep; the limit is 64");
    EXPECT_EQ(measure_json(R"({"a":"[[[\"[","b":[1,[2]]})").depth, 3u);
    EXPECT_CONTAINS(error_of(to_bytes("{\"asset\":")), "is not valid JSON");
    EXPECT_CONTAINS(error_of(to_bytes("[1,2,3]")), "neither GLB nor a JSON object");
    EXPECT_CONTAINS(error_of(to_bytes("\xEF\xBB\xBF o cube")), "neither GLB nor a JSON object");
    EXPECT_CONTAINS(error_of(to_bytes("")), "too short");
    EXPECT_CONTAINS(error_of(to_bytes("{\"asset\":\xFF\xFE}")), "is not valid JSON");
    // A million values take a hundred times their text once parsed: they are counted first.
    std::string many = R"({"asset":{"version":"2.0"},"extras":[0)";
    for (int i = 0; i < 1000000; ++i) many += ",0";
    EXPECT_CONTAINS(error_of(to_bytes(many + "]}"), {.budget_base_bytes = 1u << 20}), "its JSON holds 1000005 values");
}

TEST(GltfContainer, a_key_that_comes_twice_is_refused_by_name) {
    EXPECT_CONTAINS(error_of(to_bytes(R"({"asset":{"version":"2.0"},"extras":[{"a:b":1,"c":2},{"c":1,"deep":{"x":":","d\u0065ep":[],"x":0}}]})")),
                    "has the key 'x' twice");
    EXPECT_CONTAINS(error_of(to_bytes(R"({"asset":{"version":"2.0"},"nodes":[],"nodes":[]})")), "has the key 'nodes' twice");
    EXPECT_EQ(error_of(to_bytes(R"({"asset":{"version":"2.0"},"extras":{"a":":\":","b":{"a":{"a":0}}}})")), "");
}

TEST(GltfContainer, numbers_out_of_range_are_refused_wherever_they_are) {
    const auto with = [](const std::string& value) { return error_of(to_bytes(R"({"asset":{"version":"2.0"},"scene":)" + value + R"(,"scenes":[{}]})")); };
    for (const char* zero : {"0", "-0", "0.0", "-0.0", "0e5"}) EXPECT_EQ(with(zero), "") << zero;
    for (const char* wrong : {"1", "-1", "0.5", "1e300", "4294967296", "18446744073709551615", "18446744073709551616", "-9223372036854775809"})
        EXPECT_CONTAINS(with(wrong), "scene");
    for (const char* broken : {"1e999", "-1e999", "NaN", "Infinity", "0x1", "01", "+1", ".5"}) EXPECT_CONTAINS(with(broken), "is not valid JSON");
}

TEST(GltfContainer, versions_other_than_two_are_refused) {
    const auto error = [](json asset) {
        GltfMaker maker;
        maker.doc["asset"] = std::move(asset);
        return maker.error();
    };
    EXPECT_CONTAINS(error({{"version", "1.0"}}), "asset.version: is glTF 1.0; only glTF 2 is read");
    EXPECT_CONTAINS(error({{"version", "3.0"}}), "asset.version: is glTF 3.0");
    EXPECT_CONTAINS(error({{"version", "two"}}), "asset.version: 'two' is not a version");
    EXPECT_CONTAINS(error({{"version", 2.0}}), "asset.version: is 2.0, expected a string");
    EXPECT_CONTAINS(error({{"version", "2.1"}, {"minVersion", "2.1"}}), "asset.minVersion: asks for glTF 2.1");
    EXPECT_CONTAINS(error(json::object()), "asset: lacks 'version'");
    EXPECT_EQ(error({{"version", "2.1"}, {"minVersion", "2.0"}}), "");
    GltfMaker maker;
    maker.doc.erase("asset");
    EXPECT_CONTAINS(maker.error(), "test.gltf: lacks 'asset'");
}

TEST(GltfContainer, required_extensions_that_are_unknown_are_named_and_used_ones_warn_once) {
    GltfMaker maker = triangle();
    maker.doc["extensionsUsed"] = {"ACME_gizmo", "KHR_lights_punctual", "ACME_gizmo", "KHR_materials_clearcoat"};
    const Scene scene = maker.load();
    EXPECT_EQ(scene.source().extensions_not_drawn, std::vector<std::string>{"ACME_gizmo"});
    EXPECT_EQ(scene.source().warnings, std::vector<std::string>{"the extension ACME_gizmo is unknown and ignored"});
    maker.doc["extensionsRequired"] = {"KHR_lights_punctual", "ACME_gizmo"};
    EXPECT_CONTAINS(maker.error(), "test.gltf: extensionsRequired: needs the extension ACME_gizmo, which is not supported");
}

TEST(GltfContainer, an_extension_that_is_required_but_not_used_is_a_warning) {
    GltfMaker maker = triangle();
    maker.doc["extensionsRequired"] = {"KHR_lights_punctual"};
    const Scene scene = maker.load();
    ASSERT_EQ(scene.source().warnings.size(), 1u);
    EXPECT_CONTAINS(scene.source().warnings[0], "KHR_lights_punctual is required, but not among those used");
}

// RFC 8259, 8.1 lets a reader skip the mark; names are text, and text is UTF-8.
TEST(GltfContainer, a_byte_order_mark_is_skipped_and_text_that_is_not_unicode_is_refused) {
    EXPECT_EQ(error_of(to_bytes("\xEF\xBB\xBF" + triangle().text())), "");
    GltfMaker maker = triangle();
    std::string text = maker.text();
    text.insert(1, "\"extras\": \"\xE9\", ");
    EXPECT_CONTAINS(error_of(to_bytes(text)), "ill-formed UTF-8");
}

TEST(GltfContainer, wrong_types_are_errors_that_name_the_place) {
    const std::pair<const char*, const char*> cases[] = {
        {R"("nodes": 3)", "nodes: is 3, expected an array"},
        {R"("nodes": [3], "scenes": [{"nodes": [0]}])", "nodes[0]: is 3, expected an object"},
        {R"("scenes": [[]])", "scenes[0]: is array, expected an object"},
        {R"("scene": "first")", "scene: is \"first\", expected a whole number"},
        {R"("extensionsUsed": [1])", "extensionsUsed[0]: is 1, expected a string"},
        {R"("nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}])", "nodes[0].mesh: names meshes[0], but the file has none"},
        {R"("nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": []}]}], "scenes": [{"nodes": [0]}])",
         "meshes[0].primitives[0].attributes: is array, expected an object"},
        {R"("nodes": [{"extensions": {"KHR_lights_punctual": 4}}], "scenes": [{"nodes": [0]}])",
         "nodes[0].extensions.KHR_lights_punctual: is 4, expected an object"},
    };
    for (const auto& [members, expected] : cases)
        EXPECT_CONTAINS(error_of(to_bytes(std::string(R"({"asset": {"version": "2.0"}, )") + members + "}")), expected);
}

TEST(GltfContainer, names_from_files_are_escaped_in_errors) {
    GltfMaker maker = triangle();
    maker.doc["extensionsRequired"] = {"\x1b[31mred\n"};
    EXPECT_CONTAINS(maker.error(), "needs the extension \\x1b[31mred\\x0a,");
}

// 3,000 damaged copies: each loads or is refused with an Error; anything else ends the test program.
TEST(GltfContainer, random_damage_never_does_more_than_fail) {
    const GltfMaker maker = rich_file();
    const std::vector<std::byte> glb = maker.glb(), text = to_bytes(maker.text());
    std::mt19937 random(7);
    const auto below = [&](size_t n) { return static_cast<size_t>(random() % n); };
    int refused = 0;
    constexpr int kRuns = 3000;
    for (int run = 0; run < kRuns; ++run) {
        std::vector<std::byte> bytes = run % 2 == 0 ? glb : text;
        for (size_t flips = 1 + below(4); flips > 0; --flips) {
            const size_t at = below(bytes.size());
            if (below(4) == 0)
                bytes[at] ^= static_cast<std::byte>(1u << below(8));
            else if (below(2) == 0)
                bytes[at] = static_cast<std::byte>("0123456789-.,:{}[]\"e"[below(20)]);
            else
                bytes[at] = static_cast<std::byte>(below(256));
        }
        if (below(10) == 0) bytes.resize(below(bytes.size()));
        const std::string error = error_of(bytes, {.budget_base_bytes = 64u << 20});
        refused += error.empty() ? 0 : 1;
        ASSERT_FALSE(contains(error, "internal error")) << error;
    }
    EXPECT_GT(refused, kRuns / 4);
    EXPECT_LT(refused, kRuns);
}

}  // namespace parhelion::test::gltf_container_test
