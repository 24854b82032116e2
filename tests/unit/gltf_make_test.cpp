// The maker of small glTF files that the other glTF tests use, and its own test.
#include "gltf_make.h"

#include <gtest/gtest.h>

namespace parhelion::test {

std::string base64(std::span<const std::byte> bytes) {
    constexpr std::string_view kAlphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (size_t i = 0; i < bytes.size(); i += 3) {
        const size_t left = std::min<size_t>(3, bytes.size() - i);
        uint32_t bits = 0;
        for (size_t k = 0; k < 3; ++k) bits = bits << 8 | (k < left ? std::to_integer<uint32_t>(bytes[i + k]) : 0u);
        for (size_t k = 0; k < 4; ++k) out += k <= left ? kAlphabet[bits >> (18 - 6 * k) & 63u] : '=';
    }
    return out;
}

GltfMaker::GltfMaker() { doc = {{"asset", {{"version", "2.0"}}}, {"scene", 0}, {"scenes", json::array({{{"nodes", json::array()}}})}}; }

int GltfMaker::push(const std::string& table, json value) {
    doc[table].push_back(std::move(value));
    return static_cast<int>(doc[table].size()) - 1;
}

int GltfMaker::view_bytes(std::span<const std::byte> bytes) {
    while (buffer_.size() % 4 != 0) buffer_.push_back(std::byte{0});
    const size_t offset = buffer_.size();
    buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
    return push("bufferViews", {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", bytes.size()}});
}

json& GltfMaker::add_primitive(json primitive) {
    const int mesh = push("meshes", {{"primitives", json::array({std::move(primitive)})}});
    add_node({{"mesh", mesh}});
    return doc["meshes"].back()["primitives"][0];
}

json& GltfMaker::add_triangle() {
    const int positions = floats({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3"), normals = floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
    const int uvs = floats({0, 1, 1, 1, 0, 0}, "VEC2"), indices = accessor<uint16_t>({0, 1, 2}, kUShort, "SCALAR");
    return add_primitive({{"attributes", {{"POSITION", positions}, {"NORMAL", normals}, {"TEXCOORD_0", uvs}}}, {"indices", indices}});
}

int GltfMaker::add_node(json node) {
    const int index = push("nodes", std::move(node));
    doc["scenes"][0]["nodes"].push_back(index);
    return index;
}

std::string GltfMaker::text() const {
    json out = doc;
    if (!buffer_.empty() && !out.contains("buffers"))
        out["buffers"] =
            json::array({{{"byteLength", buffer_.size()}, {"uri", "data:application/octet-stream;base64," + base64(buffer_)}}});
    return out.dump();
}

std::vector<std::byte> GltfMaker::glb() const {
    json shown = doc;
    if (!buffer_.empty()) shown["buffers"] = json::array({{{"byteLength", buffer_.size()}}});
    std::vector<std::byte> text = to_bytes(shown.dump()), data = buffer_, out;
    while (text.size() % 4 != 0) text.push_back(std::byte{' '});
    while (data.size() % 4 != 0) data.push_back(std::byte{0});
    const auto add_u32 = [&](size_t value) {
        for (int i = 0; i < 4; ++i) out.push_back(static_cast<std::byte>(value >> (8 * i) & 0xFFu));
    };
    add_u32(0x46546C67u);
    add_u32(2);
    add_u32(20 + text.size() + (data.empty() ? 0 : 8 + data.size()));
    add_u32(text.size());
    add_u32(0x4E4F534Au);
    out.insert(out.end(), text.begin(), text.end());
    if (data.empty()) return out;
    add_u32(data.size());
    add_u32(0x004E4942u);
    out.insert(out.end(), data.begin(), data.end());
    return out;
}

std::vector<std::byte> to_bytes(const std::string& text) {
    const auto* begin = reinterpret_cast<const std::byte*>(text.data());
    return {begin, begin + text.size()};
}

Scene load_bytes(std::span<const std::byte> bytes, const SceneFileLimits& limits, const GltfOptions& options) {
    SceneFiles files({}, limits);
    Scene scene;
    scene.apply(read_gltf(files, bytes, "test.gltf", options));
    return scene;
}

std::string error_of(std::span<const std::byte> bytes, const SceneFileLimits& limits) {
    try {
        load_bytes(bytes, limits);
    } catch (const Error& error) {
        return error.line;
    }
    return {};
}

Scene GltfMaker::load(const GltfOptions& options) const { return load_bytes(to_bytes(text()), {}, options); }
std::string GltfMaker::error() const { return error_of(to_bytes(text())); }

const Primitive& only_primitive(const Scene& scene) {
    EXPECT_EQ(scene.meshes().size(), 1u);
    return (*scene.meshes().begin()).value.primitives.at(0);
}

const Material& only_material(const Scene& scene) {
    EXPECT_EQ(scene.materials().size(), 1u);
    return (*scene.materials().begin()).value;
}

TEST(Gltf, a_minimal_triangle_loads_from_gltf_and_glb_alike) {
    GltfMaker maker;
    maker.add_triangle();
    for (const Scene& scene : {maker.load(), load_bytes(maker.glb())}) {
        const Primitive& primitive = only_primitive(scene);
        ASSERT_EQ(primitive.positions.size(), 3u);
        EXPECT_EQ(primitive.positions[1], glm::vec3(1, 0, 0));
        EXPECT_EQ(primitive.normals[2], glm::vec3(0, 0, 1));
        EXPECT_EQ(primitive.uv0[2], glm::vec2(0, 0));
        ASSERT_EQ(primitive.triangles.size(), 1u);
        EXPECT_EQ(primitive.triangles[0], glm::uvec3(0, 1, 2));
        EXPECT_EQ(only_material(scene).name, "default");
        EXPECT_EQ(scene.instances().size(), 1u);
        EXPECT_EQ(scene.bounds().max, glm::vec3(1, 1, 0));
        EXPECT_TRUE(scene.source().warnings.empty());
    }
}

}  // namespace parhelion::test
