// Images of other formats than PNG and JPEG in glTF: EXT_texture_webp, KHR_texture_basisu, and what stands in for what is not read.
#include <gtest/gtest.h>
#include <webp/encode.h>

#include "gltf_make.h"
#include "image/encode.h"
#include "support/ktx2_writer.h"

namespace parhelion::test::gltf_image_test {

namespace {

using testing::make_ktx2;

std::vector<std::byte> png() {
    return image::encode_png({.width = 2, .height = 2, .rgb = std::vector<uint8_t>(12, 90)});
}

std::vector<std::byte> webp() {
    const std::vector<uint8_t> rgba(3 * 3 * 4, 200);
    uint8_t* memory = nullptr;
    const size_t size = WebPEncodeLosslessRGBA(rgba.data(), 3, 3, 12, &memory);
    const auto* begin = reinterpret_cast<const std::byte*>(memory);
    std::vector<std::byte> out(begin, begin + size);
    WebPFree(memory);
    return out;
}

std::vector<std::byte> bc7() {
    return make_ktx2({.format = 146, .width = 4, .height = 4, .level_count = 2, .model = 134, .levels = {std::vector<uint8_t>(16, 64), std::vector<uint8_t>(16, 64)}});
}

std::vector<std::byte> basis() {
    return make_ktx2({.format = 0, .width = 4, .height = 4, .scheme = 1, .model = 163, .levels = {std::vector<uint8_t>(8)}});
}

// A triangle with texture 0.
GltfMaker with_texture(json texture) {
    GltfMaker maker;
    maker.add_triangle()["material"] = 0;
    maker.push("materials", {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
    maker.push("textures", std::move(texture));
    return maker;
}

void add_image(GltfMaker& maker, const std::vector<std::byte>& bytes, const std::string& mime_type) {
    maker.push("images", {{"bufferView", maker.view_bytes(bytes)}, {"mimeType", mime_type}});
}

json with_extension(const std::string& name, int image) { return {{"extensions", {{name, {{"source", image}}}}}}; }

const Image& only_image(const Scene& scene) {
    EXPECT_EQ(scene.images().size(), 1u);
    return (*scene.images().begin()).value;
}

std::string warnings_of(const Scene& scene) {
    std::string out;
    for (const std::string& warning : scene.source().warnings) out += warning + "\n";
    return out;
}

}  // namespace

TEST(GltfImages, webp_and_ktx2_are_read_through_their_extensions_and_as_plain_sources) {
    for (const bool required : {false, true}) {
        GltfMaker maker = with_texture(with_extension("EXT_texture_webp", 0));
        add_image(maker, webp(), "image/webp");
        maker.doc["extensionsUsed"] = {"EXT_texture_webp"};
        if (required) maker.doc["extensionsRequired"] = {"EXT_texture_webp"};
        const Scene scene = maker.load();
        EXPECT_EQ(only_image(scene).width, 3u);
        EXPECT_EQ(only_image(scene).texels[5], 200);
        EXPECT_EQ(warnings_of(scene), "");
    }
    for (const json& texture : {with_extension("KHR_texture_basisu", 0), json{{"source", 0}}}) {
        GltfMaker maker = with_texture(texture);
        add_image(maker, bc7(), "image/ktx2");
        const Scene scene = maker.load();
        EXPECT_EQ(only_image(scene).format, TexelFormat::Bc7);
        EXPECT_EQ(only_image(scene).level_count, 2u);
        EXPECT_EQ(warnings_of(scene), "");
    }
}

TEST(GltfImages, the_plain_source_stands_in_for_basis_universal_with_one_warning) {
    json texture = with_extension("KHR_texture_basisu", 1);
    texture["source"] = 0;
    GltfMaker maker = with_texture(texture);
    maker.push("textures", texture);
    maker.doc["materials"][0]["emissiveTexture"] = {{"index", 1}};
    add_image(maker, png(), "image/png");
    add_image(maker, basis(), "image/ktx2");
    maker.doc["extensionsUsed"] = maker.doc["extensionsRequired"] = {"KHR_texture_basisu"};
    const Scene scene = maker.load();
    EXPECT_EQ(only_image(scene).width, 2u);
    ASSERT_EQ(scene.source().warnings.size(), 1u) << warnings_of(scene);
    EXPECT_CONTAINS(scene.source().warnings[0], "Basis Universal");
}

TEST(GltfImages, basis_universal_alone_is_left_out_with_a_warning_or_an_error_where_it_is_required) {
    GltfMaker maker = with_texture(with_extension("KHR_texture_basisu", 0));
    add_image(maker, basis(), "image/ktx2");
    const Scene scene = maker.load();
    EXPECT_EQ(scene.images().size(), 0u);
    EXPECT_FALSE(only_material(scene).base_color_texture.texture);
    EXPECT_CONTAINS(warnings_of(scene), "textures[0]: its image is a KTX2 with Basis Universal texels, which is not supported; the texture is left out");
    maker.doc["extensionsUsed"] = maker.doc["extensionsRequired"] = {"KHR_texture_basisu"};
    EXPECT_CONTAINS(maker.error(), "textures[0]: its image is a KTX2 with Basis Universal texels, which is not supported");
    EXPECT_CONTAINS(maker.error(), "BC7");
}

TEST(GltfImages, content_decides_and_a_mime_type_that_lies_is_a_warning) {
    GltfMaker maker = with_texture({{"source", 0}});
    add_image(maker, webp(), "image/jpeg");
    const Scene scene = maker.load();
    EXPECT_EQ(only_image(scene).width, 3u);
    EXPECT_CONTAINS(warnings_of(scene), "images[0]: its mimeType is 'image/jpeg', but it is a WebP image");
}

TEST(GltfImages, keep_their_files_where_that_is_asked_for) {
    for (const std::vector<std::byte>& bytes : {png(), webp(), bc7()}) {
        GltfMaker maker = with_texture({{"source", 0}});
        add_image(maker, bytes, "");
        EXPECT_EQ(only_image(maker.load()).encoded, nullptr);
        const Scene kept = maker.load({.keep_encoded = true});
        ASSERT_NE(only_image(kept).encoded, nullptr);
        EXPECT_EQ(*only_image(kept).encoded, bytes);
    }
}

}  // namespace parhelion::test::gltf_image_test
