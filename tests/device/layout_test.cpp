// The structs of shaders/shared are laid out alike in C++ and GLSL: numbers that a shader writes into every field are compared byte
// for byte, and every struct of those headers must take part.
#include <cstring>
#include <fstream>
#include <regex>

#include "device/shaders/layout_fill.h"
#include "support/gpu_fixture.h"

namespace parhelion::testing::layout_test {
namespace {

class Layout : public GpuTest {};

constexpr const char* kHeaders[] = {"bvh.h", "cache.h", "chunks.h", "deform.h", "hit.h", "raster.h", "realtime.h", "reference.h", "reservoir.h", "sampler.h", "scene.h", "view.h", "wavefront.h"};

// struct name -> text between its braces, of all shared headers.
std::map<std::string, std::string> shared_structs() {
    std::map<std::string, std::string> out;
    for (const char* header : kHeaders) {
        std::ifstream file(std::string(PARHELION_SOURCE_DIR "/shaders/shared/") + header);
        const std::string text(std::istreambuf_iterator<char>(file), {});
        EXPECT_FALSE(text.empty()) << header;
        static const std::regex pattern("struct (\\w+) \\{([^}]*)\\}");
        for (std::sregex_iterator i(text.begin(), text.end(), pattern), end; i != end; ++i) out[(*i)[1]] = (*i)[2];
    }
    return out;
}

TEST_F(Layout, a_shader_writes_what_the_host_reads) {
    shared::LayoutStructs expected{};
    uint32_t n = 1;
    for (uint32_t i = 0; i < 2; ++i) fill_entry(n, expected, i);
    EXPECT_GT(n, 400u);

    const gpu::Buffer all(device(), "test/all", sizeof(expected));
    Frame frame(device(), {}, test_shader_pack());
    frame.fill(all, 0);
    frame.compute("device/layout").read_write("all_structs", all).over(1);
    frame.run();
    const std::vector<std::byte> found = download<std::byte>(all);
    const auto* bytes = reinterpret_cast<const std::byte*>(&expected);
    for (size_t i = 0; i < sizeof(expected); ++i) ASSERT_EQ(found[i], bytes[i]) << "byte " << i;
}

TEST_F(Layout, every_shared_struct_takes_part_with_all_its_members) {
    const gpu::ShaderCode* code = test_shader_pack().find("device/layout", "", gpu::Stage::Compute);
    ASSERT_NE(code, nullptr);
    const std::map<std::string, std::string> structs = shared_structs();
    EXPECT_GE(structs.size(), 20u);
    for (const auto& [name, body] : structs) {
        const auto found = std::find_if(code->structs.begin(), code->structs.end(), [&, wanted = name](const gpu::ShaderStruct& s) { return s.name == wanted; });
        ASSERT_NE(found, code->structs.end()) << name << " is missing from layout.comp";
        // Every member is named in the function that fills it, and lies where the one before it ends: scalar layout has no padding.
        uint32_t end = 0;
        for (const gpu::ShaderStructMember& member : found->members) {
            EXPECT_TRUE(std::regex_search(body, std::regex("\\b" + member.name + "\\b"))) << name << '.' << member.name;
            EXPECT_EQ(member.offset, end) << name << '.' << member.name;
            end = member.offset + member.bytes;
        }
        EXPECT_LE(end, found->bytes) << name;
        EXPECT_LT(found->bytes - end, 8u) << name;
    }
}

TEST_F(Layout, structs_have_the_same_size_on_both_sides) {
    const std::map<std::string, size_t> sizes = {
        {"Affine", sizeof(shared::Affine)}, {"Instance", sizeof(shared::Instance)}, {"Geometry", sizeof(shared::Geometry)}, {"VertexAttributes", sizeof(shared::VertexAttributes)},
        {"TextureRef", sizeof(shared::TextureRef)}, {"Material", sizeof(shared::Material)}, {"Emitter", sizeof(shared::Emitter)}, {"AliasEntry", sizeof(shared::AliasEntry)},
        {"Environment", sizeof(shared::Environment)}, {"SceneHeader", sizeof(shared::SceneHeader)}, {"Hit", sizeof(shared::Hit)}, {"Camera", sizeof(shared::Camera)}, {"CameraMotion", sizeof(shared::CameraMotion)},
        {"ViewData", sizeof(shared::ViewData)}, {"Slice", sizeof(shared::Slice)}, {"DumpedRay", sizeof(shared::DumpedRay)}, {"BvhNode", sizeof(shared::BvhNode)}, {"BvhNodeBinary", sizeof(shared::BvhNodeBinary)}, {"BvhNodeCompact", sizeof(shared::BvhNodeCompact)}, {"BvhTriangle", sizeof(shared::BvhTriangle)},
        {"BvhTopItem", sizeof(shared::BvhTopItem)}, {"BvhAddresses", sizeof(shared::BvhAddresses)}, {"TraversalRay", sizeof(shared::TraversalRay)}, {"TraversalHit", sizeof(shared::TraversalHit)},
        {"WavefrontRay", sizeof(shared::WavefrontRay)}, {"WavefrontHit", sizeof(shared::WavefrontHit)}, {"WavefrontPath", sizeof(shared::WavefrontPath)}, {"WavefrontExtra", sizeof(shared::WavefrontExtra)}, {"WavefrontSlot", sizeof(shared::WavefrontSlot)}, {"WavefrontVertex", sizeof(shared::WavefrontVertex)},
        {"WavefrontShadowRay", sizeof(shared::WavefrontShadowRay)}, {"WavefrontSplit", sizeof(shared::WavefrontSplit)}, {"WavefrontClassSums", sizeof(shared::WavefrontClassSums)}, {"WavefrontControl", sizeof(shared::WavefrontControl)}, {"WavefrontSize", sizeof(shared::WavefrontSize)},
        {"WavefrontFirst", sizeof(shared::WavefrontFirst)}, {"TileSample", sizeof(shared::TileSample)}, {"PackedLight", sizeof(shared::PackedLight)}, {"RealtimeFrame", sizeof(shared::RealtimeFrame)},
        {"LightPath", sizeof(shared::LightPath)}, {"LightPathInside", sizeof(shared::LightPathInside)}, {"LightPending", sizeof(shared::LightPending)}, {"LightSums", sizeof(shared::LightSums)},
        {"PackedSample", sizeof(shared::PackedSample)}, {"PackedReservoir", sizeof(shared::PackedReservoir)}, {"ChosenSample", sizeof(shared::ChosenSample)}, {"LightReuse", sizeof(shared::LightReuse)},
        {"ReuseFrame", sizeof(shared::ReuseFrame)},
        {"CacheHeader", sizeof(shared::CacheHeader)}, {"CacheFrameData", sizeof(shared::CacheFrameData)}, {"CacheSize", sizeof(shared::CacheSize)}, {"CacheUpdate", sizeof(shared::CacheUpdate)}, {"CachePath", sizeof(shared::CachePath)}};
    size_t seen = 0;
    for (const gpu::ShaderStruct& s : test_shader_pack().find("device/layout", "", gpu::Stage::Compute)->structs)
        if (const auto found = sizes.find(s.name); found != sizes.end()) {
            EXPECT_EQ(s.bytes, found->second) << s.name;
            ++seen;
        }
    EXPECT_GE(seen, sizes.size());
    EXPECT_EQ(sizeof(shared::Hit), 20u);
    EXPECT_EQ(sizeof(shared::BvhTriangle), 48u);
    EXPECT_EQ(sizeof(shared::BvhTopItem), 64u);
}

}  // namespace
}  // namespace parhelion::testing::layout_test
