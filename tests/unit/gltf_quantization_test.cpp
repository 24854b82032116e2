// KHR_mesh_quantization, and what is said of attributes that are stored against the rules.
#include <gtest/gtest.h>

#include "gltf_make.h"

namespace parhelion::test::gltf_quantization_test {

namespace {

struct Stored {
    std::vector<float> values;  // of the first element
    std::vector<std::string> warnings;
};

// A triangle whose attribute `name` is stored as T, four bytes apart or more, all elements alike.
template <class T>
Stored store(const std::string& name, const std::vector<T>& element, int component_type, bool normalized, bool declared = true) {
    GltfMaker maker;
    json& primitive = maker.add_triangle();
    const size_t stride = (element.size() * sizeof(T) + 3) / 4 * 4;
    std::vector<std::byte> bytes(3 * stride);
    // Positions must differ for the triangle to be one: the corners are moved along x and y.
    for (size_t i = 0; i < 3; ++i)
        for (size_t c = 0; c < element.size(); ++c) {
            const T value = static_cast<T>(element[c] + (name == "POSITION" && i == c + 1 ? 1 : 0));
            std::memcpy(bytes.data() + i * stride + c * sizeof(T), &value, sizeof(T));
        }
    const int view = maker.view_bytes(bytes);
    maker.doc["bufferViews"][view]["byteStride"] = stride;
    const int accessor = maker.push(
        "accessors",
        {{"bufferView", view}, {"componentType", component_type}, {"type", "VEC" + std::to_string(element.size())}, {"count", 3}});
    maker.doc["accessors"][accessor]["normalized"] = normalized;
    primitive["attributes"][name] = accessor;
    if (declared) maker.doc["extensionsUsed"] = {"KHR_mesh_quantization"};
    const Scene scene = maker.load();
    const Primitive& p = only_primitive(scene);
    const auto list = [](auto v) {
        std::vector<float> out;
        for (int i = 0; i < v.length(); ++i) out.push_back(v[i]);
        return out;
    };
    // The largest numbers wrap around in the test's own arithmetic, and the triangle may have no area then.
    std::vector<std::string> warnings = scene.source().warnings;
    std::erase_if(warnings, [](const std::string& text) { return text.starts_with("triangles without area"); });
    return {name == "POSITION"     ? list(p.positions.at(0))
            : name == "NORMAL"     ? list(p.normals.at(0))
            : name == "TANGENT"    ? list(p.tangents.at(0))
            : name == "TEXCOORD_0" ? list(p.uv0.at(0))
                                   : list(p.colors.at(0)),
            warnings};
}

void expect_near(const std::vector<float>& a, const std::vector<float>& b) {
    ASSERT_EQ(a.size(), b.size());
    for (size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-6f) << "component " << i;
}

template <class T>
void expect_stored(const std::string& name, const std::vector<T>& element, int type, bool normalized, const std::vector<float>& expected) {
    const Stored stored = store(name, element, type, normalized);
    expect_near(stored.values, expected);
    EXPECT_TRUE(stored.warnings.empty()) << name << " " << type << ": " << stored.warnings[0];
    const Stored undeclared = store(name, element, type, normalized, false);
    expect_near(undeclared.values, expected);
    ASSERT_EQ(undeclared.warnings.size(), 1u) << name << " " << type;
    EXPECT_CONTAINS(undeclared.warnings[0], "needs KHR_mesh_quantization");
}

}  // namespace

TEST(GltfQuantization, every_type_of_the_extension_is_read_and_wants_to_be_declared) {
    using M = GltfMaker;
    expect_stored<int8_t>("POSITION", {-5, 7, 100}, M::kByte, false, {-5, 7, 100});
    expect_stored<int8_t>("POSITION", {-127, 0, 63}, M::kByte, true, {-1, 0, 63 / 127.0f});
    expect_stored<uint8_t>("POSITION", {5, 7, 200}, M::kUByte, false, {5, 7, 200});
    expect_stored<uint8_t>("POSITION", {0, 51, 254}, M::kUByte, true, {0, 0.2f, 254 / 255.0f});
    expect_stored<int16_t>("POSITION", {-500, 7, 30000}, M::kShort, false, {-500, 7, 30000});
    expect_stored<int16_t>("POSITION", {-32768, 0, 16383}, M::kShort, true, {-1, 0, 16383 / 32767.0f});
    expect_stored<uint16_t>("POSITION", {500, 7, 60000}, M::kUShort, false, {500, 7, 60000});
    expect_stored<uint16_t>("POSITION", {0, 13107, 65534}, M::kUShort, true, {0, 0.2f, 65534 / 65535.0f});
    expect_stored<int8_t>("NORMAL", {0, 0, -127}, M::kByte, true, {0, 0, -1});
    expect_stored<int16_t>("NORMAL", {0, -32767, 0}, M::kShort, true, {0, -1, 0});
    expect_stored<int8_t>("TANGENT", {127, 0, 0, -127}, M::kByte, true, {1, 0, 0, -1});
    expect_stored<int16_t>("TANGENT", {0, 32767, 0, 32767}, M::kShort, true, {0, 1, 0, 1});
    expect_stored<int8_t>("TEXCOORD_0", {-3, 4}, M::kByte, false, {-3, 4});
    expect_stored<int8_t>("TEXCOORD_0", {-127, 127}, M::kByte, true, {-1, 1});
    expect_stored<uint8_t>("TEXCOORD_0", {3, 200}, M::kUByte, false, {3, 200});
    expect_stored<int16_t>("TEXCOORD_0", {-300, 400}, M::kShort, false, {-300, 400});
    expect_stored<int16_t>("TEXCOORD_0", {-32767, 32767}, M::kShort, true, {-1, 1});
    expect_stored<uint16_t>("TEXCOORD_0", {300, 60000}, M::kUShort, false, {300, 60000});
}

TEST(GltfQuantization, types_of_the_core_need_no_extension) {
    using M = GltfMaker;
    EXPECT_TRUE(store<uint8_t>("TEXCOORD_0", {255, 0}, M::kUByte, true, false).warnings.empty());
    EXPECT_TRUE(store<uint16_t>("TEXCOORD_0", {65535, 0}, M::kUShort, true, false).warnings.empty());
    EXPECT_TRUE(store<uint8_t>("COLOR_0", {255, 0, 51}, M::kUByte, true, false).warnings.empty());
    EXPECT_TRUE(store<uint16_t>("COLOR_0", {65535, 0, 0, 13107}, M::kUShort, true, false).warnings.empty());
    EXPECT_TRUE(store<float>("COLOR_0", {1, 0, 0.5f}, M::kFloat, false, false).warnings.empty());
}

TEST(GltfQuantization, types_against_all_rules_are_read_with_a_warning) {
    using M = GltfMaker;
    const Stored normal = store<int16_t>("NORMAL", {0, 3, 4}, M::kShort, false);
    expect_near(normal.values, {0, 0.6f, 0.8f});
    ASSERT_EQ(normal.warnings.size(), 1u);
    EXPECT_CONTAINS(normal.warnings[0], "attributes.NORMAL: SHORT is no type that glTF allows here");
    EXPECT_CONTAINS(store<uint8_t>("COLOR_0", {255, 0, 1}, M::kUByte, false).warnings.at(0), "UNSIGNED_BYTE is no type");
    EXPECT_CONTAINS(store<int8_t>("COLOR_0", {127, 0, 1}, M::kByte, true).warnings.at(0), "normalised BYTE is no type");
}

TEST(GltfQuantization, elements_out_of_line_are_read_with_a_warning) {
    GltfMaker maker;
    // Three bytes an element, without gaps.
    const int colors = maker.accessor<uint8_t>({255, 0, 0, 0, 255, 0, 0, 0, 255}, GltfMaker::kUByte, "VEC3");
    maker.doc["accessors"][colors]["normalized"] = true;
    maker.add_triangle()["attributes"]["COLOR_0"] = colors;
    const Scene scene = maker.load();
    EXPECT_EQ(only_primitive(scene).colors[2], glm::vec4(0, 0, 1, 1));
    ASSERT_EQ(scene.source().warnings.size(), 1u);
    EXPECT_CONTAINS(scene.source().warnings[0], "accessors[0]: its elements are not aligned to four bytes");
    // An offset that splits the components of an index.
    GltfMaker odd;
    const int view = odd.view<uint8_t>({9, 0, 0, 1, 0, 2, 0});
    const int indices = odd.push(
        "accessors", {{"bufferView", view}, {"byteOffset", 1}, {"componentType", GltfMaker::kUShort}, {"type", "SCALAR"}, {"count", 3}});
    odd.add_triangle()["indices"] = indices;
    const Scene other = odd.load();
    EXPECT_EQ(only_primitive(other).triangles[0], glm::uvec3(0, 1, 2));
    EXPECT_CONTAINS(other.source().warnings.at(0), "its components of 2 bytes are not aligned");
}

}  // namespace parhelion::test::gltf_quantization_test
