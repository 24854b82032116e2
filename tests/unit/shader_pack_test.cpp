// The shader pack's reader: everything comes back, and nothing that is cut or changed is taken for a pack.
#include <gtest/gtest.h>

#include "base/error.h"
#include "support/pack_writer.h"

namespace parhelion::testing::shader_pack_test {
namespace {

using gpu::ShaderCode;
using gpu::ShaderPack;

std::vector<ShaderCode> sample_shaders() {
    ShaderCode first;
    first.name = "post/tonemap";
    first.local_size[0] = first.local_size[1] = 8;
    first.push_bytes = 24;
    first.bindings = {{"hdr", 1, 0, gpu::BindingKind::StorageImage, true, false, 10}, {"textures", 0, 3, gpu::BindingKind::TextureTable, true, false, 0}};
    first.push_pointers = {{"values", 8, true, true}};
    first.structs = {{"Material", 48, {{"base_color", 0, 16}, {"roughness", 16, 4}}}};
    first.words = {0x07230203, 1, 2, 3};
    ShaderCode second;
    second.name = "scene/hit";
    second.variant = "pipeline+ALPHA";
    second.stage = gpu::Stage::AnyHit;
    second.words = {0x07230203};
    return {first, second};
}

TEST(ShaderPack, what_was_written_is_read) {
    const std::vector<ShaderCode> shaders = sample_shaders();
    const ShaderPack pack(PackWriter().write(shaders));
    ASSERT_EQ(pack.all().size(), 2u);
    const ShaderCode& first = pack.all()[0];
    EXPECT_EQ(first.name, "post/tonemap");
    EXPECT_EQ(first.local_size[1], 8u);
    EXPECT_EQ(first.push_bytes, 24u);
    ASSERT_EQ(first.bindings.size(), 2u);
    EXPECT_EQ(first.bindings[0].name, "hdr");
    EXPECT_EQ(first.bindings[0].set, 1u);
    EXPECT_EQ(first.bindings[0].kind, gpu::BindingKind::StorageImage);
    EXPECT_TRUE(first.bindings[0].reads);
    EXPECT_FALSE(first.bindings[0].writes);
    EXPECT_EQ(first.bindings[0].format, 10u);
    EXPECT_EQ(first.bindings[1].binding, 3u);
    ASSERT_EQ(first.push_pointers.size(), 1u);
    EXPECT_EQ(first.push_pointers[0].offset, 8u);
    EXPECT_TRUE(first.push_pointers[0].writes);
    ASSERT_EQ(first.structs.size(), 1u);
    EXPECT_EQ(first.structs[0].bytes, 48u);
    EXPECT_EQ(first.structs[0].members[1].name, "roughness");
    EXPECT_EQ(first.structs[0].members[1].offset, 16u);
    EXPECT_EQ(first.words, shaders[0].words);
    EXPECT_NE(first.hash, pack.all()[1].hash);
    EXPECT_EQ(PackWriter().write(pack.all()), PackWriter().write(shaders));
}

TEST(ShaderPack, shaders_are_found_by_name_variant_and_stage) {
    const ShaderPack pack(PackWriter().write(sample_shaders()));
    EXPECT_EQ(pack.find("scene/hit", "pipeline+ALPHA", gpu::Stage::AnyHit), &pack.all()[1]);
    EXPECT_EQ(pack.find("scene/hit", "pipeline+ALPHA", gpu::Stage::ClosestHit), nullptr);
    EXPECT_EQ(pack.find("scene/hit", "", gpu::Stage::AnyHit), nullptr);
    EXPECT_EQ(pack.find("scene/hi", "pipeline+ALPHA", gpu::Stage::AnyHit), nullptr);
}

TEST(ShaderPack, a_pack_cut_at_any_byte_is_refused) {
    const std::vector<std::byte> whole = PackWriter().write(sample_shaders());
    for (size_t size = 0; size < whole.size(); ++size) EXPECT_THROW(ShaderPack(std::span(whole).first(size)), Error) << size;
    EXPECT_NO_THROW(ShaderPack{whole});
}

TEST(ShaderPack, bytes_after_the_end_are_refused) {
    std::vector<std::byte> bytes = PackWriter().write(sample_shaders());
    bytes.push_back(std::byte{0});
    EXPECT_THROW(ShaderPack{bytes}, Error);
}

// A changed byte may change a name unnoticed, but never crashes and never asks for more memory than the file has bytes.
TEST(ShaderPack, no_changed_byte_does_harm) {
    const std::vector<std::byte> whole = PackWriter().write(sample_shaders());
    size_t refused = 0;
    for (size_t at = 0; at < whole.size(); ++at)
        for (const unsigned flip : {0x01u, 0x80u, 0xFFu}) {
            std::vector<std::byte> bytes = whole;
            bytes[at] ^= static_cast<std::byte>(flip);
            try {
                const ShaderPack pack(bytes);
                EXPECT_LE(pack.all().size(), 2u);
            } catch (const Error&) {
                ++refused;
            }
        }
    EXPECT_GT(refused, whole.size());
}

TEST(ShaderPack, wrong_contents_are_refused) {
    const auto refused = [](auto change) {
        std::vector<ShaderCode> shaders = sample_shaders();
        change(shaders[0]);
        EXPECT_THROW(ShaderPack(PackWriter().write(shaders)), Error);
    };
    refused([](ShaderCode& s) { s.words[0] = 1; });
    refused([](ShaderCode& s) { s.words.clear(); });
    refused([](ShaderCode& s) { s.stage = static_cast<gpu::Stage>(7); });
    refused([](ShaderCode& s) { s.bindings[0].kind = static_cast<gpu::BindingKind>(7); });
    refused([](ShaderCode& s) { s.push_pointers[0].offset = 17; });
    refused([](ShaderCode& s) { s.push_pointers[0].offset = 0xFFFFFFFF; });
}

}  // namespace
}  // namespace parhelion::testing::shader_pack_test
