// KHR_draco_mesh_compression: what the library's own encoder makes is read back; lies and damage are refused.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include <draco/compression/encode.h>
#include <draco/compression/expert_encode.h>

#include "gltf_make.h"
#include "scene/gltf/draco.h"
#include "scene/deform.h"
#include "scene/pose.h"

namespace parhelion::test {

namespace {

constexpr uint32_t kSide = 5, kPoints = kSide * kSide, kFaces = 2 * (kSide - 1) * (kSide - 1);

// Every attribute is a function of the position, so that vertices may come back in any order.
glm::vec3 position(uint32_t i) { return {float(i % kSide), float(i / kSide), float(i % 3) * 0.25f}; }
glm::vec3 normal_at(glm::vec3 p) { return glm::normalize(glm::vec3(0.1f * p.x, 0.1f * p.y, 1.0f)); }
std::array<uint16_t, 2> uv_at(glm::vec3 p) { return {uint16_t(p.x * 9000.0f), uint16_t(p.y * 9000.0f)}; }
std::array<uint8_t, 4> color_at(glm::vec3 p) { return {uint8_t(p.x * 50.0f), uint8_t(p.y * 50.0f), uint8_t(p.z * 400.0f), 255}; }
std::array<uint16_t, 4> joints_at(glm::vec3 p) { return {uint16_t(p.x), uint16_t(300.0f + p.y), 0, 7}; }
glm::vec4 weights_at(glm::vec3 p) { return {0.1f * p.x, 1.0f - 0.1f * p.x, 0.0f, 0.0f}; }

std::unique_ptr<draco::Mesh> grid() {
    auto mesh = std::make_unique<draco::Mesh>();
    mesh->set_num_points(kPoints);
    for (uint32_t y = 0; y + 1 < kSide; ++y)
        for (uint32_t x = 0; x + 1 < kSide; ++x) {
            const draco::PointIndex a(y * kSide + x), b(a.value() + 1), c(a.value() + kSide), d(c.value() + 1);
            mesh->AddFace({a, b, c});
            mesh->AddFace({b, d, c});
        }
    return mesh;
}

using Type = draco::GeometryAttribute;

// Returns the unique id.
template <class F>
int add(draco::Mesh& mesh, Type::Type type, draco::DataType data_type, bool normalized, F&& value_at) {
    const auto first = value_at(position(0));
    draco::GeometryAttribute attribute;
    attribute.Init(type, nullptr, static_cast<uint8_t>(sizeof(first) / static_cast<size_t>(draco::DataTypeLength(data_type))), data_type,
                   normalized, sizeof(first), 0);
    const int id = mesh.AddAttribute(attribute, true, kPoints);
    for (uint32_t i = 0; i < kPoints; ++i) {
        const auto value = value_at(position(i));
        mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(i), &value);
    }
    return static_cast<int>(mesh.attribute(id)->unique_id());
}

std::vector<std::byte> encode(const draco::Mesh& mesh, int method, int bits = 0, int speed = 5) {
    draco::Encoder encoder;
    encoder.SetSpeedOptions(speed, speed);
    encoder.SetEncodingMethod(method);
    if (bits > 0) {
        encoder.SetAttributeQuantization(Type::POSITION, bits);
        encoder.SetAttributeQuantization(Type::TEX_COORD, bits);
    }
    draco::EncoderBuffer buffer;
    EXPECT_TRUE(encoder.EncodeMeshToBuffer(mesh, &buffer).ok());
    const auto* begin = reinterpret_cast<const std::byte*>(buffer.data());
    return {begin, begin + buffer.size()};
}

// A file with one primitive under the extension, and the numbers in it at hand.
struct CompressedFile {
    GltfMaker maker;
    json ids, accessors;
    CompressedFile() { maker.doc["extensionsUsed"] = maker.doc["extensionsRequired"] = {"KHR_draco_mesh_compression"}; }

    int accessor(int component_type, const std::string& type, uint64_t count, bool normalized = false) {
        json out{{"componentType", component_type}, {"type", type}, {"count", count}};
        if (normalized) out["normalized"] = true;
        return maker.push("accessors", out);
    }
    void attribute(const std::string& name, int id, int component_type, const std::string& type, bool normalized = false) {
        ids[name] = id;
        accessors[name] = accessor(component_type, type, kPoints, normalized);
    }
    json& finish(const std::vector<std::byte>& data) {
        const json extension{{"bufferView", maker.view_bytes(data)}, {"attributes", ids}};
        return maker.add_primitive({{"attributes", accessors},
                                    {"indices", accessor(GltfMaker::kUShort, "SCALAR", 3 * kFaces)},
                                    {"extensions", {{"KHR_draco_mesh_compression", extension}}}});
    }
};

// Positions and nothing else.
std::vector<std::byte> plain_data(int method, int bits = 0) {
    const std::unique_ptr<draco::Mesh> mesh = grid();
    add(*mesh, Type::POSITION, draco::DT_FLOAT32, false, [](glm::vec3 p) { return p; });
    return encode(*mesh, method, bits);
}
CompressedFile plain_file(int method) {
    CompressedFile file;
    file.attribute("POSITION", 0, GltfMaker::kFloat, "VEC3");
    file.finish(plain_data(method));
    return file;
}

constexpr int kMethods[] = {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING};

double flat_area(const Primitive& primitive) {
    double area = 0.0;
    for (const glm::uvec3& t : primitive.triangles) {
        const glm::vec3 a = primitive.positions[t.x], b = primitive.positions[t.y], c = primitive.positions[t.z];
        EXPECT_GT(glm::cross(b - a, c - a).z, 0.0f);  // kept winding
        area += 0.5 * glm::cross(b - a, c - a).z;
    }
    return area;
}

}  // namespace

TEST(GltfDraco, compressed_primitives_hold_what_went_in) {
    for (const int method : kMethods) {
        const std::unique_ptr<draco::Mesh> mesh = grid();
        CompressedFile file;
        // In an order of their own: ids count, not places.
        file.attribute("COLOR_0", add(*mesh, Type::COLOR, draco::DT_UINT8, true, color_at), GltfMaker::kUByte, "VEC4", true);
        file.attribute("POSITION", add(*mesh, Type::POSITION, draco::DT_FLOAT32, false, [](glm::vec3 p) { return p; }), GltfMaker::kFloat,
                       "VEC3");
        file.attribute("NORMAL", add(*mesh, Type::GENERIC, draco::DT_FLOAT32, false, normal_at), GltfMaker::kFloat, "VEC3");
        file.attribute("TEXCOORD_0", add(*mesh, Type::TEX_COORD, draco::DT_UINT16, true, uv_at), GltfMaker::kUShort, "VEC2", true);
        file.finish(encode(*mesh, method));
        const Scene scene = file.maker.load();
        const Primitive& primitive = only_primitive(scene);
        ASSERT_EQ(primitive.positions.size(), kPoints);
        EXPECT_EQ(primitive.triangles.size(), kFaces);
        EXPECT_NEAR(flat_area(primitive), 16.0, 1e-5);
        for (size_t i = 0; i < kPoints; ++i) {
            const glm::vec3 p = primitive.positions[i];
            EXPECT_LT(glm::length(primitive.normals[i] - normal_at(p)), 1e-6f);
            EXPECT_FLOAT_EQ(primitive.uv0[i].y, float(uv_at(p)[1]) / 65535.0f);
            EXPECT_FLOAT_EQ(primitive.colors[i].x, float(color_at(p)[0]) / 255.0f);
            EXPECT_FLOAT_EQ(primitive.colors[i].z, float(color_at(p)[2]) / 255.0f);
        }
        EXPECT_TRUE(scene.source().warnings.empty());
    }
}

TEST(GltfDraco, joints_and_weights_are_at_hand_as_their_accessors_say) {
    const std::unique_ptr<draco::Mesh> mesh = grid();
    CompressedFile file;
    file.attribute("POSITION", add(*mesh, Type::POSITION, draco::DT_FLOAT32, false, [](glm::vec3 p) { return p; }), GltfMaker::kFloat,
                   "VEC3");
    file.attribute("JOINTS_0", add(*mesh, Type::GENERIC, draco::DT_UINT16, false, joints_at), GltfMaker::kUShort, "VEC4");
    file.attribute("WEIGHTS_0", add(*mesh, Type::GENERIC, draco::DT_FLOAT32, false, weights_at), GltfMaker::kFloat, "VEC4");
    file.finish(encode(*mesh, draco::MESH_EDGEBREAKER_ENCODING));
    const std::vector<std::byte> text = to_bytes(file.maker.text());
    SceneFiles files({});
    GltfDocument document(files, text, "test.gltf");
    const JsonRef primitive = document.root().at("meshes")[0].at("primitives")[0];
    const DracoGeometry geometry = decode_draco(document, primitive, *primitive.extension("KHR_draco_mesh_compression"));
    const auto bytes_of = [&](const char* name) { return geometry.accessors.at(file.accessors[name].get<uint32_t>()).data(); };
    for (size_t i = 0; i < kPoints; ++i) {
        glm::vec3 p;
        std::array<uint16_t, 4> joints;
        glm::vec4 weights;
        std::memcpy(&p, bytes_of("POSITION") + i * sizeof(p), sizeof(p));
        std::memcpy(&joints, bytes_of("JOINTS_0") + i * sizeof(joints), sizeof(joints));
        std::memcpy(&weights, bytes_of("WEIGHTS_0") + i * sizeof(weights), sizeof(weights));
        EXPECT_EQ(joints, joints_at(p));
        EXPECT_EQ(weights, weights_at(p));
    }
}

// Everything that a primitive can have besides: its uncompressed accessors go by the order in which the points come out.
TEST(GltfDraco, compressed_meshes_are_skinned_morphed_and_dressed_by_variant) {
    const std::unique_ptr<draco::Mesh> mesh = grid();
    CompressedFile file;
    GltfMaker& maker = file.maker;
    file.attribute("POSITION", add(*mesh, Type::POSITION, draco::DT_FLOAT32, false, [](glm::vec3 p) { return p; }), GltfMaker::kFloat,
                   "VEC3");
    file.attribute("JOINTS_0", add(*mesh, Type::GENERIC, draco::DT_UINT16, false, [](glm::vec3) { return std::array<uint16_t, 4>{1, 0, 0, 0}; }),
                   GltfMaker::kUShort, "VEC4");
    file.attribute("WEIGHTS_0", add(*mesh, Type::GENERIC, draco::DT_FLOAT32, false, [](glm::vec3) { return glm::vec4(1, 0, 0, 0); }),
                   GltfMaker::kFloat, "VEC4");
    json& primitive = file.finish(encode(*mesh, draco::MESH_EDGEBREAKER_ENCODING));
    std::vector<float> lift;
    for (uint32_t i = 0; i < kPoints; ++i) lift.insert(lift.end(), {0.0f, 0.0f, 8.0f});
    primitive["targets"] = json::array({{{"POSITION", maker.floats(lift, "VEC3")}}});
    for (const char* name : {"plain", "red"}) maker.push("materials", {{"name", name}});
    primitive["material"] = 0;
    primitive["extensions"]["KHR_materials_variants"]["mappings"] = json::array({{{"variants", {0}}, {"material", 1}}});
    maker.doc["extensions"]["KHR_materials_variants"]["variants"] = json::array({{{"name", "street"}}});
    maker.doc["extensionsUsed"].push_back("KHR_materials_variants");
    maker.doc["meshes"][0]["weights"] = {0.25};
    maker.doc["nodes"][0]["skin"] = 0;
    maker.add_node({{"name", "rest"}});
    maker.add_node({{"name", "moved"}, {"translation", {100, 0, 0}}});
    maker.push("skins", {{"joints", {1, 2}}});

    Scene scene = maker.load({.median_order = true, .variant = "street"});
    scene.apply(pose_at(scene, 0.0));
    EXPECT_TRUE(scene.source().warnings.empty());
    const Instance& instance = (*scene.instances().begin()).value;
    ASSERT_TRUE(instance.posed);
    const Mesh& form = scene.get(instance.posed);
    EXPECT_EQ(scene.get(form.primitives[0].material).name, "red");
    Primitive storage;
    const Primitive &rest = scene.get(instance.mesh).primitives[0], &posed = drawn_shape(scene, form, 0, storage);
    EXPECT_EQ(form.primitives[0].variant_materials, rest.variant_materials);
    ASSERT_EQ(posed.positions.size(), kPoints);
    for (size_t i = 0; i < kPoints; ++i) EXPECT_EQ(posed.positions[i], rest.positions[i] + glm::vec3(100.0f, 0.0f, 2.0f));
    EXPECT_EQ(posed.triangles, rest.triangles);
}

TEST(GltfDraco, quantised_positions_come_back_within_their_step) {
    CompressedFile file;
    file.attribute("POSITION", 0, GltfMaker::kFloat, "VEC3");
    file.finish(plain_data(draco::MESH_EDGEBREAKER_ENCODING, 14));
    const Scene scene = file.maker.load();
    EXPECT_NEAR(flat_area(only_primitive(scene)), 16.0, 0.02);
    EXPECT_LT(glm::length(scene.bounds().max - glm::vec3(4.0f, 4.0f, 0.5f)), 4.0f * 2.0f / 16383.0f);
}

TEST(GltfDraco, a_strip_means_the_triangles_of_the_compressed_mesh) {
    CompressedFile file = plain_file(draco::MESH_EDGEBREAKER_ENCODING);
    json& primitive = file.maker.doc["meshes"][0]["primitives"][0];
    primitive["mode"] = 5;
    file.maker.doc["accessors"][primitive["indices"].get<size_t>()]["count"] = kFaces + 2;
    EXPECT_NEAR(flat_area(only_primitive(file.maker.load())), 16.0, 1e-5);
    primitive["mode"] = 6;
    EXPECT_CONTAINS(file.maker.error(), "is compressed, but of mode 6");
}

TEST(GltfDraco, data_of_the_uncompressed_fallback_are_not_read) {
    CompressedFile file = plain_file(draco::MESH_SEQUENTIAL_ENCODING);
    file.maker.doc.erase("extensionsRequired");
    json& primitive = file.maker.doc["meshes"][0]["primitives"][0];
    const int missing = file.maker.push("bufferViews", {{"buffer", 1}, {"byteLength", 1000}});
    for (const json& accessor : {primitive["indices"], primitive["attributes"]["POSITION"]}) {
        file.maker.doc["accessors"][accessor.get<size_t>()]["bufferView"] = missing;
        file.maker.doc["accessors"][accessor.get<size_t>()]["byteOffset"] = 4;
    }
    json with_buffers = json::parse(file.maker.text());
    with_buffers["buffers"].push_back({{"byteLength", 1000}, {"uri", "not-there.bin"}});
    const Scene scene = load_bytes(to_bytes(with_buffers.dump()));
    EXPECT_NEAR(flat_area(only_primitive(scene)), 16.0, 1e-5);
}

TEST(GltfDraco, attributes_outside_of_the_compressed_data_are_read_as_usual) {
    CompressedFile file = plain_file(draco::MESH_SEQUENTIAL_ENCODING);
    std::vector<float> uvs;
    for (uint32_t i = 0; i < kPoints; ++i) uvs.insert(uvs.end(), {float(i), 0.5f});
    file.maker.doc["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] = file.maker.floats(uvs, "VEC2");
    const Scene scene = file.maker.load();
    ASSERT_EQ(only_primitive(scene).uv1.size(), kPoints);
    EXPECT_EQ(only_primitive(scene).uv1[kPoints - 1], glm::vec2(float(kPoints - 1), 0.5f));
}

TEST(GltfDraco, a_second_primitive_is_read_from_its_own_data) {
    CompressedFile file = plain_file(draco::MESH_SEQUENTIAL_ENCODING);
    // The accessor of the compressed positions, uncompressed: without data it is zeros.
    file.maker.doc["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", file.accessors["POSITION"]}}}});
    const Scene scene = file.maker.load();
    const Mesh& mesh = (*scene.meshes().begin()).value;
    ASSERT_EQ(mesh.primitives.size(), 2u);
    EXPECT_EQ(mesh.primitives[0].positions[kPoints - 1], position(kPoints - 1));
    EXPECT_EQ(mesh.primitives[1].positions[kPoints - 1], glm::vec3(0.0f));
}

TEST(GltfDraco, data_beyond_their_accessors_are_refused_before_they_are_decoded) {
    for (const int method : kMethods) {
        CompressedFile file = plain_file(method);
        json& accessors = file.maker.doc["accessors"];
        const size_t positions = file.accessors["POSITION"].get<size_t>(),
                     indices = file.maker.doc["meshes"][0]["primitives"][0]["indices"].get<size_t>();
        accessors[positions]["count"] = kPoints - 1;
        EXPECT_CONTAINS(file.maker.error(), "holds 25 vertices, but its accessors are for 24");
        accessors[positions]["count"] = kPoints;
        accessors[indices]["count"] = 3 * (kFaces - 1);
        EXPECT_CONTAINS(file.maker.error(), "holds 32 triangles, but its accessors are for 31");
    }
}

// The counts follow a header of 11 bytes and, in one method, a byte for the traversal (Draco bitstream 2.2, 3.1 and 3.2).
TEST(GltfDraco, counts_that_lie_are_refused_before_memory_is_taken) {
    for (const int method : kMethods) {
        std::vector<std::byte> data = plain_data(method);
        const bool edgebreaker = method == draco::MESH_EDGEBREAKER_ENCODING;
        const std::ptrdiff_t at = edgebreaker ? 13 : 11;  // of the number of faces; edgebreaker has the vertices before it
        ASSERT_EQ(std::to_integer<uint32_t>(data[size_t(at)]), kFaces);
        const std::vector<std::byte> lie{std::byte{0xFF}, std::byte{0xFF}, std::byte{0xFF}, std::byte{0x7F}};  // 2^28 - 1
        data.erase(data.begin() + at);
        data.insert(data.begin() + at, lie.begin(), lie.end());
        CompressedFile file;
        file.attribute("POSITION", 0, GltfMaker::kFloat, "VEC3");
        json& primitive = file.finish(data);
        EXPECT_CONTAINS(file.maker.error(), "holds 268435455 triangles, but its accessors are for 32");
        file.maker.doc["accessors"][primitive["indices"].get<size_t>()]["count"] = 0xFFFFFFFFu;
        EXPECT_CONTAINS(file.maker.error(), "its triangles would take");
    }
}

// The count stands somewhere behind the entropy-coded texture coordinates: it is found by trying everywhere.
TEST(GltfDraco, a_count_of_texture_coordinate_turns_that_lies_is_refused_before_they_are_decoded) {
    const std::unique_ptr<draco::Mesh> mesh = grid();
    add(*mesh, Type::POSITION, draco::DT_FLOAT32, false, [](glm::vec3 p) { return p; });
    add(*mesh, Type::TEX_COORD, draco::DT_FLOAT32, false, [](glm::vec3 p) { return glm::vec2(p); });
    const std::vector<std::byte> good = encode(*mesh, draco::MESH_EDGEBREAKER_ENCODING, 11, 0);
    int refused = 0;
    for (size_t at = 11; at + 4 <= good.size(); ++at) {
        std::vector<std::byte> data = good;
        const uint32_t lie = 0x6FFFFFFF;
        std::memcpy(data.data() + at, &lie, sizeof(lie));
        CompressedFile file;
        file.attribute("POSITION", 0, GltfMaker::kFloat, "VEC3");
        file.attribute("TEXCOORD_0", 1, GltfMaker::kFloat, "VEC2");
        file.finish(data);
        const std::string error = error_of(to_bytes(file.maker.text()));
        if (error.find("turns texture coordinates 1879048191 times, but has 96 corners") != std::string::npos) ++refused;
    }
    EXPECT_GT(refused, 0);
}

TEST(GltfDraco, attributes_beyond_the_budget_are_refused_before_memory_is_taken) {
    CompressedFile file = plain_file(draco::MESH_SEQUENTIAL_ENCODING);
    const std::vector<std::byte> text = to_bytes(file.maker.text());
    std::string refusals;
    for (uint64_t budget = 0; budget < 1u << 16; budget += 256)
        refusals += error_of(text, {.budget_base_bytes = budget, .budget_factor = 8}) + "\n";
    EXPECT_CONTAINS(refusals, "its attributes would take");
    EXPECT_CONTAINS(refusals, "its triangles would take");
}

TEST(GltfDraco, wrong_ids_types_and_data_are_refused_by_name) {
    CompressedFile file = plain_file(draco::MESH_SEQUENTIAL_ENCODING);
    json& primitive = file.maker.doc["meshes"][0]["primitives"][0];
    json& extension = primitive["extensions"]["KHR_draco_mesh_compression"];
    extension["attributes"]["POSITION"] = 9;
    EXPECT_CONTAINS(file.maker.error(), "the compressed data have no attribute 9");
    extension["attributes"] = {{"POSITION", 0}, {"TEXCOORD_0", 0}};
    primitive["attributes"]["TEXCOORD_0"] = file.accessor(GltfMaker::kFloat, "VEC2", kPoints);
    EXPECT_CONTAINS(file.maker.error(), "attribute 0 has 3 components, but its accessor has 2");
    extension["attributes"] = {{"POSITION", 0}};
    extension["bufferView"] = file.maker.view(std::vector<float>{1, 2, 3});
    EXPECT_CONTAINS(file.maker.error(), "its Draco data are damaged");
    extension["bufferView"] = 77;
    EXPECT_CONTAINS(file.maker.error(), "bufferView");
}

// Damaged copies: each loads or is refused with an Error; anything else ends the test program.
TEST(GltfDraco, random_damage_never_does_more_than_fail) {
    std::mt19937 random(11);
    const auto below = [&](size_t n) { return static_cast<size_t>(random() % n); };
    const std::unique_ptr<draco::Mesh> mesh = grid();
    add(*mesh, Type::POSITION, draco::DT_FLOAT32, false, [](glm::vec3 p) { return p; });
    add(*mesh, Type::TEX_COORD, draco::DT_UINT16, true, uv_at);
    int refused = 0;
    constexpr int kRuns = 600;
    for (int run = 0; run < kRuns; ++run) {
        std::vector<std::byte> data = encode(*mesh, kMethods[run % 2], run % 4 < 2 ? 11 : 0);
        for (size_t flips = 1 + below(3); flips > 0; --flips) data[below(data.size())] = static_cast<std::byte>(below(256));
        if (below(10) == 0) data.resize(below(data.size()));
        CompressedFile file;
        file.attribute("POSITION", 0, GltfMaker::kFloat, "VEC3");
        file.attribute("TEXCOORD_0", 1, GltfMaker::kUShort, "VEC2", true);
        file.finish(data);
        const std::string error = error_of(to_bytes(file.maker.text()), {.budget_base_bytes = 16u << 20});
        refused += error.empty() ? 0 : 1;
        ASSERT_FALSE(contains(error, "internal error")) << error;
    }
    EXPECT_GT(refused, kRuns / 10);
    EXPECT_LT(refused, kRuns);
}

}  // namespace parhelion::test
