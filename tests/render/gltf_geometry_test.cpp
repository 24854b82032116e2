// One bumpy sheet, stored in every way that glTF knows: the pictures are the same.
#include <cstring>
#include <functional>

#include <draco/compression/encode.h>
#include <meshoptimizer.h>
#include <nlohmann/json.hpp>

#include "scene/gltf/read.h"
#include "support/render_fixture.h"

namespace parhelion::testing::gltf_geometry_test {
namespace {

using nlohmann::json;
using Bytes = std::vector<std::byte>;

constexpr int kUByte = 5121, kShort = 5122, kUShort = 5123, kUInt = 5125, kFloat = 5126;
constexpr uint32_t kSide = 9, kCount = kSide * kSide;

// A GLB in the making: `doc` and one buffer.
struct Glb {
    json doc;
    Bytes data;

    Glb() {
        // A lamp above, which stands in the first node.
        doc = json::parse(R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"translation": [1, 3, 0.5]}]})");
        doc["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 0;
        doc["extensions"]["KHR_lights_punctual"]["lights"] = json::array({{{"type", "point"}, {"intensity", 100}}});
        doc["extensionsUsed"] = {"KHR_lights_punctual"};
        doc["materials"] = json::array({{{"doubleSided", false}}});
    }
    int push(const char* table, json value) {
        doc[table].push_back(std::move(value));
        return static_cast<int>(doc[table].size()) - 1;
    }
    template <class T>
    int view(const std::vector<T>& values, size_t stride = 0) {
        const size_t offset = data.size(), size = values.size() * sizeof(T);
        data.resize(offset + (size + 3) / 4 * 4);
        std::memcpy(data.data() + offset, values.data(), size);
        json out{{"buffer", 0}, {"byteOffset", offset}, {"byteLength", size}};
        if (stride != 0) out["byteStride"] = stride;
        return push("bufferViews", out);
    }
    int accessor(std::optional<int> view, int component_type, const char* type, size_t count, bool normalized = false, size_t offset = 0) {
        json out{{"componentType", component_type}, {"type", type}, {"count", count}, {"normalized", normalized}, {"byteOffset", offset}};
        if (view) out["bufferView"] = *view;
        return push("accessors", out);
    }
    void node(json value) { doc["scenes"][0]["nodes"].push_back(push("nodes", std::move(value))); }
    int mesh(json primitive) {
        primitive["material"] = 0;
        return push("meshes", {{"primitives", json::array({std::move(primitive)})}});
    }
    Bytes bytes() const {
        json shown = doc;
        shown["buffers"] = json::array({{{"byteLength", data.size()}}});
        std::string text = shown.dump();
        text.resize((text.size() + 3) / 4 * 4, ' ');
        Bytes out;
        const auto add = [&](const void* from, size_t size) {
            const auto* begin = static_cast<const std::byte*>(from);
            out.insert(out.end(), begin, begin + size);
        };
        const uint32_t head[5] = {0x46546C67u, 2, static_cast<uint32_t>(28 + text.size() + data.size()), static_cast<uint32_t>(text.size()),
                                  0x4E4F534Au};
        const uint32_t binary[2] = {static_cast<uint32_t>(data.size()), 0x004E4942u};
        add(head, sizeof(head));
        add(text.data(), text.size());
        add(binary, sizeof(binary));
        add(data.data(), data.size());
        return out;
    }
};

// The sheet spans [-1, 1] in x and z, with normals that lean and vertex colours.
struct Sheet {
    std::vector<glm::vec3> positions, normals;
    std::vector<glm::vec4> colors;
    std::vector<uint32_t> triangles, strip;
    Sheet() {
        for (uint32_t i = 0; i < kCount; ++i) {
            const float x = float(i % kSide) / 4.0f - 1.0f, z = float(i / kSide) / 4.0f - 1.0f;
            positions.emplace_back(x, 0.25f * float((i * 7) % 5) / 4.0f, z);
            normals.push_back(glm::normalize(glm::vec3(0.3f * x, 1.0f, 0.2f * z)));
            colors.emplace_back(0.5f + 0.4f * x, 0.5f + 0.4f * z, 0.5f, 1.0f);
        }
        for (uint32_t row = 0; row + 1 < kSide; ++row) {
            const uint32_t first = row * kSide;
            if (row > 0) strip.insert(strip.end(), {strip.back(), first});  // joined by triangles without area
            for (uint32_t i = first; i < first + kSide; ++i) {
                strip.insert(strip.end(), {i, i + kSide});
                if (i + 1 < first + kSide) triangles.insert(triangles.end(), {i, i + kSide, i + 1, i + 1, i + kSide, i + kSide + 1});
            }
        }
    }
};

template <class T>
Bytes encode_vertices(const std::vector<T>& values) {
    std::vector<unsigned char> out(meshopt_encodeVertexBufferBound(values.size(), sizeof(T)));
    out.resize(meshopt_encodeVertexBuffer(out.data(), out.size(), values.data(), values.size(), sizeof(T)));
    const auto* begin = reinterpret_cast<const std::byte*>(out.data());
    return {begin, begin + out.size()};
}

Bytes encode_triangles(const std::vector<uint32_t>& indices) {
    std::vector<unsigned char> out(meshopt_encodeIndexBufferBound(indices.size(), kCount));
    out.resize(meshopt_encodeIndexBuffer(out.data(), out.size(), indices.data(), indices.size()));
    const auto* begin = reinterpret_cast<const std::byte*>(out.data());
    return {begin, begin + out.size()};
}

template <class T>
void add_draco(draco::Mesh& mesh, draco::GeometryAttribute::Type type, const std::vector<T>& values) {
    draco::GeometryAttribute attribute;
    attribute.Init(type, nullptr, sizeof(T) / sizeof(float), draco::DT_FLOAT32, false, sizeof(T), 0);
    const int id = mesh.AddAttribute(attribute, true, kCount);
    for (uint32_t i = 0; i < kCount; ++i) mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(i), &values[i]);
}

Bytes encode_draco(const Sheet& sheet, int method) {
    draco::Mesh mesh;
    mesh.set_num_points(kCount);
    for (size_t i = 0; i < sheet.triangles.size(); i += 3)
        mesh.AddFace(
            {draco::PointIndex(sheet.triangles[i]), draco::PointIndex(sheet.triangles[i + 1]), draco::PointIndex(sheet.triangles[i + 2])});
    add_draco(mesh, draco::GeometryAttribute::POSITION, sheet.positions);
    add_draco(mesh, draco::GeometryAttribute::GENERIC, sheet.normals);
    add_draco(mesh, draco::GeometryAttribute::GENERIC, sheet.colors);
    draco::Encoder encoder;
    encoder.SetEncodingMethod(method);
    draco::EncoderBuffer buffer;
    EXPECT_TRUE(encoder.EncodeMeshToBuffer(mesh, &buffer).ok());
    const auto* begin = reinterpret_cast<const std::byte*>(buffer.data());
    return {begin, begin + buffer.size()};
}

class GltfGeometry : public GpuTest {
protected:
    // By light samples alone: which lobe a path takes may flip with the last bit of a normal.
    static image::ImageF draw(const Glb& file) {
        SceneFiles files({});
        const Bytes bytes = file.bytes();
        Stage stage(make_scene(read_gltf(files, bytes, "sheet.glb")));
        return stage.picture({.view = {.width = 32, .height = 32, .max_bounces = 1, .filter = PixelFilter::Point, .light_sampling = 1},
                              .camera = camera_from_above(6.0f, 1.1f),
                              .sample_count = 1});
    }
    static json plain_attributes(Glb& file, const Sheet& sheet) {
        return {{"POSITION", file.accessor(file.view(sheet.positions), kFloat, "VEC3", kCount)},
                {"NORMAL", file.accessor(file.view(sheet.normals), kFloat, "VEC3", kCount)},
                {"COLOR_0", file.accessor(file.view(sheet.colors), kFloat, "VEC4", kCount)}};
    }
    static int plain_mesh(Glb& file, const Sheet& sheet) {
        const int indices = file.accessor(file.view(sheet.triangles), kUInt, "SCALAR", sheet.triangles.size());
        return file.mesh({{"attributes", plain_attributes(file, sheet)}, {"indices", indices}});
    }
    static const image::ImageF& plain_picture() {
        static const image::ImageF picture = [] {
            Glb file;
            file.node({{"mesh", plain_mesh(file, Sheet())}});
            return draw(file);
        }();
        return picture;
    }
};

}  // namespace

TEST_F(GltfGeometry, strips_interleaved_and_sparse_data_draw_the_same_picture) {
    const Sheet sheet;
    Glb strip, interleaved, sparse;
    const int strip_indices = strip.accessor(strip.view(sheet.strip), kUInt, "SCALAR", sheet.strip.size());
    strip.node({{"mesh", strip.mesh({{"attributes", plain_attributes(strip, sheet)}, {"indices", strip_indices}, {"mode", 5}})}});

    std::vector<float> mixed;
    for (uint32_t i = 0; i < kCount; ++i) {
        const glm::vec3 p = sheet.positions[i], n = sheet.normals[i];
        const glm::vec4 c = sheet.colors[i];
        mixed.insert(mixed.end(), {p.x, p.y, p.z, n.x, n.y, n.z, c.x, c.y, c.z, c.w});
    }
    const int view = interleaved.view(mixed, 40),
              indices = interleaved.accessor(interleaved.view(sheet.triangles), kUInt, "SCALAR", sheet.triangles.size());
    interleaved.node({{"mesh", interleaved.mesh({{"attributes",
                                                  {{"POSITION", interleaved.accessor(view, kFloat, "VEC3", kCount)},
                                                   {"NORMAL", interleaved.accessor(view, kFloat, "VEC3", kCount, false, 12)},
                                                   {"COLOR_0", interleaved.accessor(view, kFloat, "VEC4", kCount, false, 24)}}},
                                                 {"indices", indices}})}});

    const int mesh = plain_mesh(sparse, sheet);
    const int positions = sparse.doc["meshes"][mesh]["primitives"][0]["attributes"]["POSITION"];
    std::vector<uint16_t> all(kCount);
    for (uint32_t i = 0; i < kCount; ++i) all[i] = static_cast<uint16_t>(i);
    const json values = sparse.doc["accessors"][positions]["bufferView"];
    sparse.doc["accessors"][positions].erase("bufferView");
    sparse.doc["accessors"][positions]["sparse"] = {{"count", kCount},
                                                    {"indices", {{"bufferView", sparse.view(all)}, {"componentType", kUShort}}},
                                                    {"values", {{"bufferView", values}}}};
    sparse.node({{"mesh", mesh}});

    EXPECT_GT(mean_rgb(plain_picture()), 0.2);
    EXPECT_GT(share_equal(draw(strip), plain_picture()), 0.99) << "strip";  // its corners come in another order
    EXPECT_EQ(share_bit_equal(draw(interleaved), plain_picture()), 1.0) << "interleaved";
    EXPECT_EQ(share_bit_equal(draw(sparse), plain_picture()), 1.0) << "sparse";
}

TEST_F(GltfGeometry, lossless_draco_and_meshopt_data_draw_the_same_picture) {
    const Sheet sheet;
    for (const int method : {int(draco::MESH_SEQUENTIAL_ENCODING), int(draco::MESH_EDGEBREAKER_ENCODING)}) {
        Glb file;
        file.doc["extensionsUsed"].push_back("KHR_draco_mesh_compression");
        const json extension{{"bufferView", file.view(encode_draco(sheet, method))},
                             {"attributes", {{"POSITION", 0}, {"NORMAL", 1}, {"COLOR_0", 2}}}};
        file.node({{"mesh", file.mesh({{"attributes",
                                        {{"POSITION", file.accessor({}, kFloat, "VEC3", kCount)},
                                         {"NORMAL", file.accessor({}, kFloat, "VEC3", kCount)},
                                         {"COLOR_0", file.accessor({}, kFloat, "VEC4", kCount)}}},
                                       {"indices", file.accessor({}, kUShort, "SCALAR", sheet.triangles.size())},
                                       {"extensions", {{"KHR_draco_mesh_compression", extension}}}})}});
        // The order of triangles and of their corners may differ, and with it roundings at edges.
        EXPECT_GT(share_equal(draw(file), plain_picture()), method == draco::MESH_SEQUENTIAL_ENCODING ? 0.9999 : 0.98)
            << "Draco, method " << method;
    }
    Glb file;
    file.doc["extensionsUsed"].push_back("EXT_meshopt_compression");
    const auto compressed = [&](const Bytes& data, size_t count, size_t stride, const char* mode) {
        const int view = file.view(data);
        json& json_view = file.doc["bufferViews"][view];
        json extension = json_view;
        extension.update({{"count", count}, {"byteStride", stride}, {"mode", mode}});
        json_view = {{"buffer", 0}, {"byteLength", count * stride}, {"extensions", {{"EXT_meshopt_compression", extension}}}};
        return view;
    };
    file.node(
        {{"mesh",
          file.mesh(
              {{"attributes",
                {{"POSITION",
                  file.accessor(compressed(encode_vertices(sheet.positions), kCount, 12, "ATTRIBUTES"), kFloat, "VEC3", kCount)},
                 {"NORMAL", file.accessor(compressed(encode_vertices(sheet.normals), kCount, 12, "ATTRIBUTES"), kFloat, "VEC3", kCount)},
                 {"COLOR_0", file.accessor(compressed(encode_vertices(sheet.colors), kCount, 16, "ATTRIBUTES"), kFloat, "VEC4", kCount)}}},
               {"indices", file.accessor(compressed(encode_triangles(sheet.triangles), sheet.triangles.size(), 4, "TRIANGLES"), kUInt,
                                         "SCALAR", sheet.triangles.size())}})}});
    EXPECT_GT(share_equal(draw(file), plain_picture()), 0.98) << "meshopt";
}

TEST_F(GltfGeometry, quantised_data_draw_the_same_picture_within_their_steps) {
    const Sheet sheet;
    Glb file;
    file.doc["extensionsUsed"].push_back("KHR_mesh_quantization");
    // Positions are whole in quarters (x, z) and sixteenths (y), which the node undoes; normals turn against it.
    const glm::vec3 scale(0.25f, 0.0625f, 0.25f);
    std::vector<int16_t> positions, normals;
    std::vector<uint16_t> colors;
    for (uint32_t i = 0; i < kCount; ++i) {
        const glm::vec3 p = sheet.positions[i] / scale, n = glm::normalize(sheet.normals[i] * scale);
        for (int c = 0; c < 3; ++c) {
            positions.push_back(static_cast<int16_t>(std::lround(p[c])));
            normals.push_back(static_cast<int16_t>(std::lround(n[c] * 32767.0f)));
            colors.push_back(static_cast<uint16_t>(std::lround(sheet.colors[i][c] * 65535.0f)));
        }
        positions.push_back(0);
        normals.push_back(0);
        colors.push_back(0);
    }
    const std::vector<uint8_t> indices(sheet.triangles.begin(), sheet.triangles.end());
    file.node({{"scale", {scale.x, scale.y, scale.z}},
               {"mesh", file.mesh({{"attributes",
                                    {{"POSITION", file.accessor(file.view(positions, 8), kShort, "VEC3", kCount)},
                                     {"NORMAL", file.accessor(file.view(normals, 8), kShort, "VEC3", kCount, true)},
                                     {"COLOR_0", file.accessor(file.view(colors, 8), kUShort, "VEC3", kCount, true)}}},
                                   {"indices", file.accessor(file.view(indices), kUByte, "SCALAR", indices.size())}})}});
    const image::ImageF picture = draw(file);
    const image::ImageF& plain = plain_picture();
    // Half a step of a normal, times the 16 that the node's scale makes of it, tilts it by 5e-4: 0.4 % of the cosine of grazing light.
    size_t near = 0;
    for (size_t i = 0; i < plain.data.size(); ++i) near += std::abs(picture.data[i] - plain.data[i]) <= 4e-3f * plain.data[i] ? 1 : 0;
    EXPECT_GT(near, plain.data.size() * 99 / 100);
}

TEST_F(GltfGeometry, instances_of_the_extension_draw_what_as_many_nodes_draw) {
    const Sheet sheet;
    const std::vector<glm::vec3> translations{{-0.5f, 0, -0.5f}, {0.5f, 0.3f, -0.4f}, {0.1f, 0.1f, 0.5f}},
        scales{{0.4f, 1, 0.4f}, {-0.3f, 0.5f, 0.3f}, {0.5f, 2, 0.3f}};
    const float h = std::sqrt(0.5f);
    const std::vector<glm::vec4> rotations{{0, h, 0, h}, {0, 0, 0, 1}, {h, 0, h, 0}};
    Glb nodes, instanced;
    const int mesh = plain_mesh(nodes, sheet);
    for (size_t i = 0; i < 3; ++i) {
        const glm::vec3 t = translations[i], s = scales[i];
        const glm::vec4 r = rotations[i];
        nodes.node({{"mesh", mesh}, {"translation", {t.x, t.y, t.z}}, {"rotation", {r.x, r.y, r.z, r.w}}, {"scale", {s.x, s.y, s.z}}});
    }
    instanced.doc["extensionsUsed"].push_back("EXT_mesh_gpu_instancing");
    const json attributes{{"TRANSLATION", instanced.accessor(instanced.view(translations), kFloat, "VEC3", 3)},
                          {"ROTATION", instanced.accessor(instanced.view(rotations), kFloat, "VEC4", 3)},
                          {"SCALE", instanced.accessor(instanced.view(scales), kFloat, "VEC3", 3)}};
    instanced.node({{"mesh", plain_mesh(instanced, sheet)}, {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", attributes}}}}}});
    const image::ImageF expected = draw(nodes);
    EXPECT_GT(mean_rgb(expected), 0.05);
    EXPECT_EQ(share_bit_equal(draw(instanced), expected), 1.0);
}

}  // namespace parhelion::testing::gltf_geometry_test
