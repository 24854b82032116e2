#include "scene/gltf/accessors.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

#include "base/error.h"

namespace parhelion {

namespace {

ComponentType read_component_type(const JsonRef& json) {
    const uint64_t number = json.as_uint(0xFFFF);
    if (number < 5120 || number > 5126 || number == 5124)
        json.fail(fmt::format("{} is no component type", number), "5120, 5121, 5122, 5123, 5125 or 5126");
    return static_cast<ComponentType>(number);
}

struct Accessor : AccessorShape {
    JsonRef json;
    const std::byte* data = nullptr;  // none: zeros
    uint64_t stride = 0;
};

uint32_t component_count(const JsonRef& type) {
    const std::string_view name = type.as_string();
    if (name == "SCALAR") return 1;
    if (name == "VEC2") return 2;
    if (name == "VEC3") return 3;
    if (name == "VEC4") return 4;
    if (name == "MAT4") return 16;
    type.fail(fmt::format("'{}' cannot be used here", escape_name(name, 20)), "SCALAR, VEC2, VEC3, VEC4 or MAT4");
}

// Bytes of `count` elements of `element_size` at `offset` of a view; checked in 64 bits (count < 2^32, stride <= 252).
const std::byte* locate(const JsonRef& json, const GltfDocument::View& view, uint64_t offset, uint64_t count, uint64_t element_size,
                        uint64_t stride) {
    const uint64_t span = count == 0 ? 0 : (count - 1) * stride + element_size;
    if (offset > view.bytes.size() || span > view.bytes.size() - offset)
        json.fail(
            fmt::format("{} elements need {} bytes at offset {}, but the buffer view has {}", count, span, offset, view.bytes.size()));
    return view.bytes.data() + offset;
}

AccessorShape read_shape(const JsonRef& json) {
    const AccessorShape shape{.count = json.at("count").as_uint(std::numeric_limits<uint32_t>::max()),
                              .type = read_component_type(json.at("componentType")),
                              .components = component_count(json.at("type")),
                              .normalized = json.boolean("normalized", false)};
    if (shape.normalized && (shape.type == ComponentType::Float || shape.type == ComponentType::UnsignedInt))
        json.fail("only 8 and 16 bit integers can be normalised");
    return shape;
}

// glTF 2.0, 3.6.2.4. Other readers may stumble; here data are copied byte by byte.
void warn_of_alignment(GltfDocument& document, const Accessor& a, uint64_t offset, uint64_t view_offset) {
    const uint32_t size = size_of(a.type);
    if (offset % size != 0 || (offset + view_offset) % size != 0 || a.stride % size != 0)
        document.warn(a.json, fmt::format("its components of {} bytes are not aligned", size));
}

Accessor open_accessor(GltfDocument& document, const JsonRef& use) {
    const JsonRef json = document.entry("accessors", use);
    Accessor a{read_shape(json), json};
    const uint64_t element_size = a.element_bytes();
    if (const std::vector<std::byte>* decoded = document.decoded(use.as_index_of("accessors"))) {
        a.data = decoded->data();
        a.stride = element_size;
    } else if (const std::optional<JsonRef> view_ref = json.find("bufferView")) {
        const GltfDocument::View view = document.view(*view_ref);
        const uint64_t offset = json.uint("byteOffset", 0, 1ull << 53);
        a.stride = view.stride != 0 ? view.stride : element_size;
        if (a.stride < element_size) json.fail(fmt::format("its elements of {} bytes overlap at a stride of {}", element_size, a.stride));
        a.data = locate(json, view, offset, a.count, element_size, a.stride);
        warn_of_alignment(document, a, offset, document.entry("bufferViews", *view_ref).uint("byteOffset", 0, 1ull << 53));
    }
    return a;
}

// Element by element conversion into `out`, `components` values apart.
template <class T>
void convert(const std::byte* data, uint64_t stride, uint64_t count, uint32_t components, bool normalized, float* out) {
    const float scale = normalized ? 1.0f / static_cast<float>(std::numeric_limits<T>::max()) : 1.0f;
    for (uint64_t i = 0; i < count; ++i)
        for (uint32_t c = 0; c < components; ++c) {
            T value;
            std::memcpy(&value, data + i * stride + c * sizeof(T), sizeof(T));
            const float result = static_cast<float>(value) * scale;
            *out++ = normalized ? std::max(result, -1.0f) : result;  // the most negative integer is -1 too (glTF 2.0, 3.11)
        }
}

struct Sparse {
    std::vector<uint32_t> indices;
    const std::byte* values = nullptr;
};

std::vector<uint32_t> read_integers(const std::byte* data, ComponentType type, uint64_t stride, uint64_t count) {
    std::vector<uint32_t> out(count);
    with_component(type, [&](auto tag) {
        using T = decltype(tag);
        for (uint64_t i = 0; i < count; ++i) {
            T value;
            std::memcpy(&value, data + i * stride, sizeof(T));
            out[i] = static_cast<uint32_t>(value);
        }
    });
    return out;
}

bool unsigned_type(ComponentType type) {
    return type == ComponentType::UnsignedByte || type == ComponentType::UnsignedShort || type == ComponentType::UnsignedInt;
}

Sparse read_sparse(GltfDocument& document, const Accessor& a, const JsonRef& json) {
    const uint64_t count = json.at("count").as_uint(a.count);
    const JsonRef indices = json.at("indices"), values = json.at("values");
    const ComponentType type = read_component_type(indices.at("componentType"));
    if (!unsigned_type(type)) indices.at("componentType").fail("sparse indices are unsigned integers");
    const uint64_t element_size = a.element_bytes();
    const GltfDocument::View index_view = document.view(indices.at("bufferView")), value_view = document.view(values.at("bufferView"));
    const std::byte* data = locate(indices, index_view, indices.uint("byteOffset", 0, 1ull << 53), count, size_of(type), size_of(type));
    Sparse sparse;
    sparse.values = locate(values, value_view, values.uint("byteOffset", 0, 1ull << 53), count, element_size, element_size);
    document.files().charge(count * sizeof(uint32_t), indices.where());
    sparse.indices = read_integers(data, type, size_of(type), count);
    for (uint64_t i = 0; i < count; ++i) {
        if (sparse.indices[i] >= a.count)
            indices.fail(fmt::format("index {} is {}; the accessor has {} elements", i, sparse.indices[i], a.count));
        if (i > 0 && sparse.indices[i] <= sparse.indices[i - 1]) indices.fail(fmt::format("index {} is not larger than the one before", i));
    }
    return sparse;
}

// All values as floats into out[count * components], which holds zeros.
void read_floats(GltfDocument& document, const Accessor& a, float* out) {
    if (a.type == ComponentType::UnsignedInt) a.json.fail("32-bit integers can only be indices");
    with_component(a.type, [&](auto tag) {
        using T = decltype(tag);
        if (a.data != nullptr) convert<T>(a.data, a.stride, a.count, a.components, a.normalized, out);
        if (const std::optional<JsonRef> json = a.json.find("sparse")) {
            const Sparse sparse = read_sparse(document, a, *json);
            const uint64_t element_size = sizeof(T) * a.components;
            for (uint64_t i = 0; i < sparse.indices.size(); ++i)
                convert<T>(sparse.values + i * element_size, element_size, 1, a.components, a.normalized,
                           out + uint64_t(sparse.indices[i]) * a.components);
        }
    });
    for (uint64_t i = 0; i < a.count * a.components; ++i)
        if (!std::isfinite(out[i]))
            a.json.fail(fmt::format("element {} is not a finite number", i / a.components), "the file is damaged: export it again");
}

}  // namespace

AccessorShape accessor_shape(GltfDocument& document, const JsonRef& use) { return read_shape(document.entry("accessors", use)); }

template <glm::length_t N>
std::vector<glm::vec<N, float>> read_vectors(GltfDocument& document, const JsonRef& use) {
    const Accessor a = open_accessor(document, use);
    if (a.components != static_cast<uint32_t>(N))
        use.fail(fmt::format("has {} components in {}, expected VEC{}", a.components, a.json.path(), N));
    document.files().charge(a.count * sizeof(glm::vec<N, float>), a.json.where());
    std::vector<glm::vec<N, float>> out(a.count, glm::vec<N, float>(0.0f));
    if (!out.empty()) read_floats(document, a, &out[0][0]);
    return out;
}
template std::vector<glm::vec2> read_vectors<2>(GltfDocument&, const JsonRef&);
template std::vector<glm::vec3> read_vectors<3>(GltfDocument&, const JsonRef&);
template std::vector<glm::vec4> read_vectors<4>(GltfDocument&, const JsonRef&);

std::vector<glm::vec4> read_colors(GltfDocument& document, const JsonRef& use) {
    const Accessor a = open_accessor(document, use);
    if (a.components != 3 && a.components != 4)
        use.fail(fmt::format("has {} components in {}, expected VEC3 or VEC4", a.components, a.json.path()));
    document.files().charge(2 * a.count * sizeof(glm::vec4), a.json.where());
    std::vector<float> floats(a.count * a.components);
    read_floats(document, a, floats.data());
    std::vector<glm::vec4> out(a.count, glm::vec4(1.0f));
    for (uint64_t i = 0; i < a.count; ++i)
        for (uint32_t c = 0; c < a.components; ++c)
            out[i][static_cast<glm::length_t>(c)] = glm::clamp(floats[i * a.components + c], 0.0f, 1.0f);
    return out;
}

std::vector<glm::mat4> read_matrices(GltfDocument& document, const JsonRef& use) {
    const Accessor a = open_accessor(document, use);
    if (a.components != 16 || a.type != ComponentType::Float) use.fail(fmt::format("{} is not a MAT4 of floats", a.json.path()));
    document.files().charge(a.count * sizeof(glm::mat4), a.json.where());
    std::vector<glm::mat4> out(a.count, glm::mat4(0.0f));
    if (!out.empty()) read_floats(document, a, &out[0][0][0]);
    return out;
}

std::vector<uint16_t> read_joint_numbers(GltfDocument& document, const JsonRef& use) {
    const Accessor a = open_accessor(document, use);
    if (a.components != 4 || a.normalized || (a.type != ComponentType::UnsignedByte && a.type != ComponentType::UnsignedShort))
        use.fail(fmt::format("{} is not a VEC4 of unsigned bytes or shorts", a.json.path()));
    document.files().charge(a.count * 4 * (sizeof(float) + sizeof(uint16_t)), a.json.where());
    std::vector<float> floats(a.count * 4);
    read_floats(document, a, floats.data());  // every number below 2^16 is exact
    return {floats.begin(), floats.end()};
}

std::vector<float> read_numbers(GltfDocument& document, const JsonRef& use, uint32_t components, NumberKind kind) {
    const Accessor a = open_accessor(document, use);
    if (a.components != components) use.fail(fmt::format("has {} components in {}, expected {}", a.components, a.json.path(), components));
    if (a.type != ComponentType::Float && (kind == NumberKind::Float || (kind == NumberKind::FloatOrNormalized && !a.normalized)))
        use.fail(fmt::format("{} does not have {}", a.json.path(),
                             kind == NumberKind::Float ? "floats" : "floats or normalised integers"));
    document.files().charge(a.count * components * sizeof(float), a.json.where());
    std::vector<float> out(a.count * components);
    read_floats(document, a, out.data());
    return out;
}

std::vector<uint32_t> read_indices(GltfDocument& document, const JsonRef& use, uint64_t vertex_count) {
    const Accessor a = open_accessor(document, use);
    if (a.components != 1 || !unsigned_type(a.type) || a.normalized)
        use.fail(fmt::format("{} is not a SCALAR of unsigned integers", a.json.path()));
    document.files().charge(a.count * sizeof(uint32_t), a.json.where());
    std::vector<uint32_t> out(a.count);
    if (a.data != nullptr) out = read_integers(a.data, a.type, a.stride, a.count);
    if (const std::optional<JsonRef> json = a.json.find("sparse")) {
        const Sparse sparse = read_sparse(document, a, *json);
        const std::vector<uint32_t> values = read_integers(sparse.values, a.type, size_of(a.type), sparse.indices.size());
        for (size_t i = 0; i < values.size(); ++i) out[sparse.indices[i]] = values[i];
    }
    const uint64_t restart = (1ull << (8 * size_of(a.type))) - 1;
    for (uint64_t i = 0; i < out.size(); ++i) {
        if (out[i] == restart) use.fail(fmt::format("index {} is {}, the primitive restart value, which glTF forbids", i, out[i]));
        if (out[i] >= vertex_count) use.fail(fmt::format("index {} is {}, but there are {} vertices", i, out[i], vertex_count));
    }
    return out;
}

}  // namespace parhelion
