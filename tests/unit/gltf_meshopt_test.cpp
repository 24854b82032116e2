// EXT_meshopt_compression and KHR_meshopt_compression: what the library's own encoders make is read back.
#include <gtest/gtest.h>

#include <random>

#include <meshoptimizer.h>

#include "gltf_make.h"

namespace parhelion::test::gltf_meshopt_test {

namespace {

using Bytes = std::vector<std::byte>;

template <class T>
Bytes encode_vertices(const std::vector<T>& values, size_t stride) {
    const size_t count = values.size() * sizeof(T) / stride;
    std::vector<unsigned char> out(meshopt_encodeVertexBufferBound(count, stride));
    out.resize(meshopt_encodeVertexBuffer(out.data(), out.size(), values.data(), count, stride));
    const auto* begin = reinterpret_cast<const std::byte*>(out.data());
    return {begin, begin + out.size()};
}

Bytes encode_indices(const std::vector<uint32_t>& indices, bool triangles) {
    std::vector<unsigned char> out(triangles ? meshopt_encodeIndexBufferBound(indices.size(), 100)
                                             : meshopt_encodeIndexSequenceBound(indices.size(), 100));
    out.resize(triangles ? meshopt_encodeIndexBuffer(out.data(), out.size(), indices.data(), indices.size())
                         : meshopt_encodeIndexSequence(out.data(), out.size(), indices.data(), indices.size()));
    const auto* begin = reinterpret_cast<const std::byte*>(out.data());
    return {begin, begin + out.size()};
}

// A file of one buffer with compressed data, and a fallback buffer that cannot be read.
struct CompressedFile {
    GltfMaker maker;
    std::string extension;
    explicit CompressedFile(std::string name = "EXT_meshopt_compression") : extension(std::move(name)) {
        maker.doc["extensionsUsed"] = maker.doc["extensionsRequired"] = {extension};
    }
    int view(const Bytes& data, size_t count, size_t stride, const std::string& mode, const std::string& filter = {}) {
        const int index = maker.view_bytes(data);
        json& out = maker.doc["bufferViews"][index];
        json compression{
            {"buffer", 0}, {"byteOffset", out["byteOffset"]}, {"byteLength", data.size()}, {"byteStride", stride}, {"count", count},
            {"mode", mode}};
        if (!filter.empty()) compression["filter"] = filter;
        out = {{"buffer", 1}, {"byteLength", count * stride}, {"extensions", {{extension, compression}}}};
        if (mode == "ATTRIBUTES") out["byteStride"] = stride;
        return index;
    }
    json& compression(int view) { return maker.doc["bufferViews"][view]["extensions"][extension]; }
    int accessor(int view, int component_type, const std::string& type, size_t count, bool normalized = false) {
        json out{{"bufferView", view}, {"componentType", component_type}, {"type", type}, {"count", count}};
        if (normalized) out["normalized"] = true;
        return maker.push("accessors", out);
    }
    std::string text() const {
        json out = json::parse(maker.text());
        out["buffers"].push_back({{"byteLength", 100000}, {"extensions", {{extension, {{"fallback", true}}}}}});
        return out.dump();
    }
    Scene load() const { return load_bytes(to_bytes(text())); }
    std::string error() const { return error_of(to_bytes(text())); }
};

const std::vector<float> kSquare{0, 0, 0, 2, 0, 0, 0, 2, 0, 2, 2, 1};

// A square of two triangles whose attribute `name` is what is under test.
Primitive load_with(CompressedFile& file, const std::string& name, int accessor) {
    const int positions = file.maker.floats(kSquare, "VEC3");
    file.maker.add_primitive({{"attributes", {{"POSITION", positions}, {name, accessor}}}, {"mode", 5}});
    return only_primitive(file.load());
}

}  // namespace

TEST(GltfMeshopt, attributes_and_indices_of_all_modes_come_back) {
    for (const char* extension : {"EXT_meshopt_compression", "KHR_meshopt_compression"})
        for (const bool triangles : {true, false})
            for (const size_t stride : {2u, 4u}) {
                CompressedFile file(extension);
                const int positions = file.view(encode_vertices(kSquare, 12), 4, 12, "ATTRIBUTES");
                const int indices =
                    file.view(encode_indices({0, 1, 2, 2, 1, 3}, triangles), 6, stride, triangles ? "TRIANGLES" : "INDICES");
                file.maker.add_primitive(
                    {{"attributes", {{"POSITION", file.accessor(positions, GltfMaker::kFloat, "VEC3", 4)}}},
                     {"indices", file.accessor(indices, stride == 2 ? GltfMaker::kUShort : GltfMaker::kUInt, "SCALAR", 6)}});
                const Scene scene = file.load();
                EXPECT_EQ(only_primitive(scene).positions[3], glm::vec3(2, 2, 1));
                EXPECT_EQ(only_primitive(scene).triangles, (std::vector<glm::uvec3>{{0, 1, 2}, {2, 1, 3}}));
                EXPECT_TRUE(scene.source().warnings.empty());
            }
}

TEST(GltfMeshopt, octahedral_filter_gives_unit_normals) {
    const std::vector<glm::vec4> normals{{0, 0, 1, 0}, {0.6f, 0, 0.8f, 0}, {0, -0.6f, -0.8f, 0}, {-1, 0, 0, 0}};
    for (const size_t stride : {4u, 8u}) {
        Bytes filtered(4 * stride);
        meshopt_encodeFilterOct(filtered.data(), 4, stride, stride == 4 ? 8 : 12, &normals[0].x);
        CompressedFile file;
        file.maker.doc["extensionsUsed"].push_back("KHR_mesh_quantization");
        const int view = file.view(encode_vertices(filtered, stride), 4, stride, "ATTRIBUTES", "OCTAHEDRAL");
        const Primitive primitive =
            load_with(file, "NORMAL", file.accessor(view, stride == 4 ? GltfMaker::kByte : GltfMaker::kShort, "VEC3", 4, true));
        for (size_t i = 0; i < 4; ++i)
            EXPECT_LT(glm::length(primitive.normals[i] - glm::vec3(normals[i])), stride == 4 ? 0.02f : 0.001f) << i;
    }
}

TEST(GltfMeshopt, exponential_filter_gives_floats) {
    const std::vector<float> uvs{0.5f, -3.25f, 100.0f, 1e-3f, 7.0f, 8.0f, 0.0f, 1.0f};
    Bytes filtered(32);
    meshopt_encodeFilterExp(filtered.data(), 4, 8, 16, uvs.data());
    CompressedFile file;
    const int view = file.view(encode_vertices(filtered, 8), 4, 8, "ATTRIBUTES", "EXPONENTIAL");
    const Primitive primitive = load_with(file, "TEXCOORD_0", file.accessor(view, GltfMaker::kFloat, "VEC2", 4));
    for (size_t i = 0; i < 8; ++i) EXPECT_NEAR(primitive.uv0[i / 2][int(i % 2)], uvs[i], 1e-2f);
}

TEST(GltfMeshopt, quaternion_filter_gives_rotations_of_instances) {
    const std::vector<glm::vec4> quaternions{{0, 0, std::sqrt(0.5f), std::sqrt(0.5f)}, {0.5f, 0.5f, 0.5f, 0.5f}};
    Bytes filtered(16);
    meshopt_encodeFilterQuat(filtered.data(), 2, 8, 16, &quaternions[0].x);
    CompressedFile file;
    file.maker.doc["extensionsUsed"].push_back("EXT_mesh_gpu_instancing");
    const int view = file.view(encode_vertices(filtered, 8), 2, 8, "ATTRIBUTES", "QUATERNION");
    file.maker.add_triangle();
    file.maker.doc["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"] = {
        {"attributes", {{"ROTATION", file.accessor(view, GltfMaker::kShort, "VEC4", 2, true)}}}};
    const Scene scene = file.load();
    ASSERT_EQ(scene.instances().size(), 2u);
    std::vector<glm::vec3> x;
    for (const auto& [handle, instance] : scene.instances()) x.push_back(glm::vec3(instance.place.world_from_object[0]));
    EXPECT_LT(glm::length(x[0] - glm::vec3(0, 1, 0)), 1e-3f);  // a quarter turn about z
    EXPECT_LT(glm::length(x[1] - glm::vec3(0, 1, 0)), 1e-3f);  // a third of a turn about (1, 1, 1)
}

// Values worked out by hand from the formulas of KHR_meshopt_compression, filter 4.
TEST(GltfMeshopt, color_filter_gives_colors_in_eight_and_sixteen_bits) {
    const auto load_color = [](auto in, int component_type) {
        decltype(in) four;
        for (int i = 0; i < 4; ++i) four.insert(four.end(), in.begin(), in.end());
        const size_t stride = 4 * sizeof(in[0]);
        CompressedFile file("KHR_meshopt_compression");
        const int view = file.view(encode_vertices(four, stride), 4, stride, "ATTRIBUTES", "COLOR");
        return load_with(file, "COLOR_0", file.accessor(view, component_type, "VEC4", 4, true)).colors[2];
    };
    // Y 100, Co 20, Cg -10, 7 bits of alpha 63: R = 100 + 20 + 10, G = 100 - 10, B = 100 - 20 + 10.
    const glm::vec4 eight = load_color(std::vector<uint8_t>{100, 20, uint8_t(-10), 0x80 | 63}, GltfMaker::kUByte);
    EXPECT_LT(glm::length(eight - glm::vec4(130, 90, 90, 127) / 255.0f), 1e-6f);
    // K = 10: all scaled by 65535 / 1023.
    const glm::vec4 sixteen = load_color(std::vector<uint16_t>{600, uint16_t(-100), 50, 0x200 | 0x1FF}, GltfMaker::kUShort);
    EXPECT_LT(glm::length(sixteen - glm::vec4(450, 650, 650, 1023) / 1023.0f), 1e-4f);
    // An alpha without its marker bit is against the rules, and no reason to divide by zero.
    EXPECT_EQ(load_color(std::vector<uint8_t>{9, 9, 9, 0}, GltfMaker::kUByte), glm::vec4(0.0f));
}

TEST(GltfMeshopt, versions_that_the_library_cannot_read_are_told_from_damage) {
    CompressedFile file("KHR_meshopt_compression");
    Bytes data = encode_vertices(kSquare, 12);
    data[0] = std::byte{0xA7};
    const int view = file.view(data, 4, 12, "ATTRIBUTES");
    file.maker.add_primitive({{"attributes", {{"POSITION", file.accessor(view, GltfMaker::kFloat, "VEC3", 4)}}}});
    EXPECT_CONTAINS(file.error(), "bufferViews[0].extensions.KHR_meshopt_compression: is compressed with version 7 of its codec");
    file.compression(view)["byteLength"] = data.size() - 8;
    file.compression(view)["byteOffset"] = 1;
    EXPECT_CONTAINS(file.error(), "its compressed data are damaged");
}

TEST(GltfMeshopt, layouts_that_the_extension_forbids_are_refused) {
    const auto error_with = [](const std::string& key, json value, const std::string& mode = "ATTRIBUTES") {
        CompressedFile file;
        const int view = file.view(encode_vertices(kSquare, 12), 4, 12, mode);
        file.compression(view)[key] = std::move(value);
        file.maker.add_primitive({{"attributes", {{"POSITION", file.accessor(view, GltfMaker::kFloat, "VEC3", 4)}}}});
        return file.error();
    };
    EXPECT_EQ(error_with("byteOffset", 0), "");
    EXPECT_CONTAINS(error_with("mode", "SOMETHING"), "mode: 'SOMETHING' is not known");
    EXPECT_CONTAINS(error_with("filter", "BLUR"), "filter: 'BLUR' is not known");
    EXPECT_CONTAINS(error_with("filter", "OCTAHEDRAL"), "4 or 8");
    EXPECT_CONTAINS(error_with("filter", "COLOR"), "4 or 8");
    EXPECT_CONTAINS(error_with("filter", "QUATERNION"), "8 for QUATERNION");
    EXPECT_CONTAINS(error_with("byteStride", 6), "byteStride is 4, 8");
    EXPECT_CONTAINS(error_with("byteStride", 0), "byteStride is 4, 8");
    EXPECT_CONTAINS(error_with("byteStride", 260), "byteStride");
    EXPECT_CONTAINS(error_with("count", 5), "unfolds to 5 x 12 bytes, but the buffer view has 48");
    EXPECT_CONTAINS(error_with("mode", "INDICES"), "2 or 4 for indices");
    EXPECT_CONTAINS(error_with("byteLength", 1000000), "lie outside its buffer");
}

TEST(GltfMeshopt, a_count_cannot_take_all_memory) {
    CompressedFile file;
    const int view = file.view(encode_vertices(kSquare, 12), 4, 12, "ATTRIBUTES");
    file.compression(view)["count"] = 0xFFFFFFFFu;
    file.maker.doc["bufferViews"][view]["byteLength"] = 0xFFFFFFFFull * 12;
    file.maker.add_primitive({{"attributes", {{"POSITION", file.accessor(view, GltfMaker::kFloat, "VEC3", 4)}}}});
    EXPECT_CONTAINS(file.error(), "more memory; the budget");
}

TEST(GltfMeshopt, views_without_compression_cannot_use_the_fallback_buffer) {
    CompressedFile file;
    file.maker.add_triangle();
    file.maker.doc["bufferViews"][0]["buffer"] = 1;
    EXPECT_CONTAINS(file.error(), "has no uri");
}

// Damaged copies: each loads or is refused with an Error; anything else ends the test program.
TEST(GltfMeshopt, random_damage_never_does_more_than_fail) {
    std::mt19937 random(5);
    const auto below = [&](size_t n) { return static_cast<size_t>(random() % n); };
    std::vector<float> many;
    for (int i = 0; i < 300; ++i) many.push_back(float(random() % 100));
    std::vector<uint32_t> indices;
    for (int i = 0; i < 300; ++i) indices.push_back(uint32_t(below(100)));
    const Bytes sound[] = {encode_vertices(many, 12), encode_indices(indices, true), encode_indices(indices, false)};
    int refused = 0;
    constexpr int kRuns = 1500;
    for (int run = 0; run < kRuns; ++run) {
        Bytes damaged[3] = {sound[0], sound[1], sound[2]};
        Bytes& data = damaged[run % 3];
        for (size_t flips = 1 + below(3); flips > 0; --flips) data[below(data.size())] = static_cast<std::byte>(below(256));
        if (below(10) == 0) data.resize(below(data.size()));
        CompressedFile file;
        const int positions = file.view(damaged[0], 100, 12, "ATTRIBUTES", run % 2 == 0 ? "" : "EXPONENTIAL");
        const int view = file.view(damaged[run % 3 == 2 ? 2 : 1], 300, 4, run % 3 == 2 ? "INDICES" : "TRIANGLES");
        file.maker.add_primitive({{"attributes", {{"POSITION", file.accessor(positions, GltfMaker::kFloat, "VEC3", 100)}}},
                                  {"indices", file.accessor(view, GltfMaker::kUInt, "SCALAR", 300)}});
        const std::string error = file.error();
        refused += error.empty() ? 0 : 1;
        ASSERT_FALSE(contains(error, "internal error")) << error;
    }
    EXPECT_GT(refused, kRuns / 10);
    EXPECT_LT(refused, kRuns);
}

}  // namespace parhelion::test::gltf_meshopt_test
