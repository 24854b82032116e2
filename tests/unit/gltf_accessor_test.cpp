// Accessors: every component type, layout and lie.
#include <gtest/gtest.h>

#include <limits>

#include "gltf_make.h"

namespace parhelion::test::gltf_accessor_test {

namespace {

// A triangle whose TEXCOORD_0 is the accessor under test.
std::vector<glm::vec2> load_uvs(GltfMaker& maker, int accessor) {
    maker.add_triangle()["attributes"]["TEXCOORD_0"] = accessor;
    return only_primitive(maker.load()).uv0;
}

std::string uv_error(GltfMaker& maker, int accessor) {
    maker.add_triangle()["attributes"]["TEXCOORD_0"] = accessor;
    return maker.error();
}

template <class T>
void expect_converted(int component_type, const std::vector<T>& values, bool normalized, const std::vector<float>& expected) {
    GltfMaker maker;
    const int accessor = maker.accessor(values, component_type, "VEC2");
    maker.doc["accessors"][accessor]["normalized"] = normalized;
    const std::vector<glm::vec2> uvs = load_uvs(maker, accessor);
    for (size_t i = 0; i < expected.size(); ++i) EXPECT_FLOAT_EQ(uvs[i / 2][static_cast<int>(i % 2)], expected[i]) << "value " << i;
}

json sparse(int count, int indices_view, int index_type, int values_view) {
    return {{"count", count},
            {"indices", {{"bufferView", indices_view}, {"componentType", index_type}}},
            {"values", {{"bufferView", values_view}}}};
}

}  // namespace

TEST(GltfAccessor, normalised_integers_map_to_the_unit_ranges_and_others_stay) {
    expect_converted<uint8_t>(GltfMaker::kUByte, {0, 255, 51, 1, 2, 3}, true, {0.0f, 1.0f, 0.2f});
    expect_converted<uint16_t>(GltfMaker::kUShort, {0, 65535, 13107, 1, 2, 3}, true, {0.0f, 1.0f, 0.2f});
    expect_converted<int8_t>(GltfMaker::kByte, {127, -127, -128, 0, 64, 3}, true, {1.0f, -1.0f, -1.0f, 0.0f, 64.0f / 127.0f});
    expect_converted<int16_t>(GltfMaker::kShort, {32767, -32767, -32768, 0, 2, 3}, true, {1.0f, -1.0f, -1.0f, 0.0f});
    expect_converted<uint8_t>(GltfMaker::kUByte, {0, 255, 51, 1, 2, 3}, false, {0, 255, 51, 1, 2, 3});
    expect_converted<int16_t>(GltfMaker::kShort, {-32768, 7, 2, 3, 4, 5}, false, {-32768, 7, 2, 3, 4, 5});
    expect_converted<float>(GltfMaker::kFloat, {0.5f, -3.25f, 1e30f, 0, 0, 0}, false, {0.5f, -3.25f, 1e30f});
}

TEST(GltfAccessor, interleaved_data_is_read_with_its_stride_and_offset) {
    GltfMaker maker;
    // Position and UV alternate: 12 + 8 bytes.
    const std::vector<float> data{0, 0, 0, 0.1f, 0.2f, 1, 0, 0, 0.3f, 0.4f, 0, 1, 0, 0.5f, 0.6f};
    const int view = maker.view(data);
    maker.doc["bufferViews"][view]["byteStride"] = 20;
    const int positions = maker.push("accessors", {{"bufferView", view}, {"componentType", 5126}, {"type", "VEC3"}, {"count", 3}});
    const int uvs =
        maker.push("accessors", {{"bufferView", view}, {"byteOffset", 12}, {"componentType", 5126}, {"type", "VEC2"}, {"count", 3}});
    maker.add_primitive({{"attributes", {{"POSITION", positions}, {"TEXCOORD_0", uvs}}}});
    const Scene scene = maker.load();
    const Primitive& primitive = only_primitive(scene);
    EXPECT_EQ(primitive.positions[2], glm::vec3(0, 1, 0));
    EXPECT_EQ(primitive.uv0[1], glm::vec2(0.3f, 0.4f));
    EXPECT_EQ(primitive.uv0[2], glm::vec2(0.5f, 0.6f));
}

TEST(GltfAccessor, sparse_values_replace_data_or_zeros) {
    for (const bool has_base : {true, false}) {
        GltfMaker maker;
        const int accessor = maker.floats({9, 9, 8, 8, 7, 7}, "VEC2");
        if (!has_base) maker.doc["accessors"][accessor].erase("bufferView");
        const int indices = maker.view<uint8_t>({0, 2}), values = maker.view<float>({1, 2, 3, 4});
        maker.doc["accessors"][accessor]["sparse"] = sparse(2, indices, GltfMaker::kUByte, values);
        const std::vector<glm::vec2> uvs = load_uvs(maker, accessor);
        EXPECT_EQ(uvs[0], glm::vec2(1, 2));
        EXPECT_EQ(uvs[1], has_base ? glm::vec2(8, 8) : glm::vec2(0, 0));
        EXPECT_EQ(uvs[2], glm::vec2(3, 4));
    }
}

TEST(GltfAccessor, sparse_indices_out_of_range_or_order_are_refused) {
    for (const auto& [list, part] : {std::pair{std::vector<uint8_t>{0, 3}, "index 1 is 3; the accessor has 3 elements"},
                                     std::pair{std::vector<uint8_t>{2, 2}, "index 1 is not larger than the one before"}}) {
        GltfMaker maker;
        const int accessor = maker.floats({9, 9, 8, 8, 7, 7}, "VEC2");
        maker.doc["accessors"][accessor]["sparse"] = sparse(2, maker.view(list), GltfMaker::kUByte, maker.view<float>({1, 2, 3, 4}));
        const std::string error = uv_error(maker, accessor);
        EXPECT_CONTAINS(error, part);
        EXPECT_CONTAINS(error, "test.gltf: accessors[0].sparse.indices");
    }
    GltfMaker maker;
    const int accessor = maker.floats({9, 9, 8, 8, 7, 7}, "VEC2");
    maker.doc["accessors"][accessor]["sparse"] = sparse(4, maker.view<uint8_t>({0, 1, 2, 3}), GltfMaker::kUByte, maker.view<float>({1, 2}));
    EXPECT_CONTAINS(uv_error(maker, accessor), "accessors[0].sparse.count: is 4, expected a whole number from 0 to 3");
}

TEST(GltfAccessor, data_outside_of_its_view_is_refused_whatever_the_numbers) {
    struct Lie {
        const char* key;
        json value;
        const char* part;
    };
    const Lie lies[] = {{"count", 4, "4 elements need 32 bytes at offset 0, but the buffer view has 24"},
                        {"count", 4294967295u, "34359738360 bytes"},
                        {"count", 4294967296u, "expected a whole number"},
                        {"count", -1, "expected a whole number"},
                        {"count", 1.5, "expected a whole number"},
                        {"count", 1e300, "expected a whole number"},
                        {"byteOffset", 4, "at offset 4"},
                        {"byteOffset", 9007199254740992u, "at offset 9007199254740992"},
                        {"byteOffset", 18446744073709551615u, "expected a whole number"},
                        {"componentType", 5124, "5124 is no component type"},
                        {"componentType", 0, "0 is no component type"},
                        {"componentType", 5125, "32-bit integers can only be indices"},
                        {"type", "SCALAR", "expected VEC2"},
                        {"type", "MAT3", "'MAT3' cannot be used here"},
                        {"type", 7, "is 7, expected a string"},
                        {"normalized", true, "only 8 and 16 bit integers"},
                        {"bufferView", 77, "names bufferViews[77], but the file has only 5"}};
    for (const Lie& lie : lies) {
        GltfMaker maker;
        const int accessor = maker.floats({9, 9, 8, 8, 7, 7}, "VEC2");
        maker.doc["accessors"][accessor][lie.key] = lie.value;
        const std::string error = uv_error(maker, accessor);
        EXPECT_CONTAINS(error, lie.part);
        EXPECT_TRUE(contains(error, "accessors[0]") || contains(error, "TEXCOORD_0")) << error;
    }
}

TEST(GltfAccessor, views_outside_of_their_buffer_are_refused) {
    struct Lie {
        const char* key;
        json value;
        const char* part;
    };
    const Lie lies[] = {{"byteLength", 9007199254740992u, "lie outside its buffer"},
                        {"byteOffset", 1000, "bytes 1000 to 1024 lie outside its buffer of"},
                        {"byteOffset", 9007199254740992u, "lie outside its buffer"},
                        {"byteStride", 2, "is 2, expected 4 to 252"},
                        {"byteStride", 256, "expected a whole number from 0 to 252"},
                        {"byteStride", 4, "overlap at a stride of 4"},
                        {"byteStride", 252, "need 512 bytes"},
                        {"buffer", 1, "names buffers[1], but the file has only 1"}};
    for (const Lie& lie : lies) {
        GltfMaker maker;
        const int accessor = maker.floats({9, 9, 8, 8, 7, 7}, "VEC2");
        maker.doc["bufferViews"][0][lie.key] = lie.value;
        EXPECT_CONTAINS(uv_error(maker, accessor), lie.part);
    }
}

TEST(GltfAccessor, a_count_without_data_cannot_take_all_memory) {
    GltfMaker maker;
    const int accessor = maker.push("accessors", {{"componentType", 5126}, {"type", "VEC3"}, {"count", 4000000000u}});
    maker.add_primitive({{"attributes", {{"POSITION", accessor}}}});
    const std::string error = maker.error();
    EXPECT_CONTAINS(error, "the budget for this scene");
    EXPECT_CONTAINS(error, "accessors[0]");
}

TEST(GltfAccessor, numbers_that_are_not_finite_are_refused) {
    for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        GltfMaker maker;
        const int accessor = maker.floats({0, 0, 1, bad, 0, 0}, "VEC2");
        EXPECT_CONTAINS(uv_error(maker, accessor), "accessors[0]: element 1 is not a finite number");
    }
}

TEST(GltfAccessor, a_buffer_that_is_shorter_than_it_says_is_refused) {
    GltfMaker maker;
    maker.add_triangle();
    maker.doc["buffers"] = json::array({{{"byteLength", 100}, {"uri", "data:;base64,AAAA"}}});
    EXPECT_CONTAINS(maker.error(), "buffers[0]: is 100 bytes long, but its data has only 3");
    maker.doc["buffers"][0]["uri"] = "data:;base64,AA*A";
    EXPECT_CONTAINS(maker.error(), "buffers[0].uri: the base64 data of its URI has a wrong character at 2");
    maker.doc["buffers"][0].erase("uri");
    EXPECT_CONTAINS(maker.error(), "buffers[0]: has no uri, and the file has no binary chunk");
}

}  // namespace parhelion::test::gltf_accessor_test
