#pragma once
// Accessors: typed arrays of a glTF file, of every component type, interleaved, normalised, sparse or without data (zeros).
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "scene/gltf/document.h"

namespace parhelion {

enum class ComponentType { Byte = 5120, UnsignedByte = 5121, Short = 5122, UnsignedShort = 5123, UnsignedInt = 5125, Float = 5126 };

// Calls f with a value of the C++ type.
template <class F>
decltype(auto) with_component(ComponentType type, F&& f) {
    switch (type) {
        case ComponentType::Byte:
            return f(int8_t{});
        case ComponentType::UnsignedByte:
            return f(uint8_t{});
        case ComponentType::Short:
            return f(int16_t{});
        case ComponentType::UnsignedShort:
            return f(uint16_t{});
        case ComponentType::UnsignedInt:
            return f(uint32_t{});
        case ComponentType::Float:
            break;
    }
    return f(float{});
}

inline uint32_t size_of(ComponentType type) {
    return with_component(type, [](auto value) { return static_cast<uint32_t>(sizeof(value)); });
}

// What an accessor says that it holds, read without its data. SCALAR to VEC4.
struct AccessorShape {
    uint64_t count;
    ComponentType type;
    uint32_t components;
    bool normalized;
    uint64_t element_bytes() const { return uint64_t(size_of(type)) * components; }
};
AccessorShape accessor_shape(GltfDocument& document, const JsonRef& use);

// A length (or a sum of weights) that is 1 but for the rounding of float: such values stay as they are, so that reading what was
// written changes no bit.
inline bool is_unit(double length) { return length > 1.0 - 5e-7 && length < 1.0 + 5e-7; }

// `use` is the number that names the accessor, where it is used ("meshes[0].primitives[0].attributes.POSITION"). The type must be
// VECn (SCALAR for n = 1). Integers come as they are, or mapped to [0, 1] or [-1, 1] if normalised. Every value is finite.
template <glm::length_t N>
std::vector<glm::vec<N, float>> read_vectors(GltfDocument& document, const JsonRef& use);
extern template std::vector<glm::vec2> read_vectors<2>(GltfDocument&, const JsonRef&);
extern template std::vector<glm::vec3> read_vectors<3>(GltfDocument&, const JsonRef&);
extern template std::vector<glm::vec4> read_vectors<4>(GltfDocument&, const JsonRef&);

// Colours: VEC3 (alpha 1) or VEC4.
std::vector<glm::vec4> read_colors(GltfDocument& document, const JsonRef& use);

// MAT4 of floats, as 4x4 matrices of any kind.
std::vector<glm::mat4> read_matrices(GltfDocument& document, const JsonRef& use);

// JOINTS_n: VEC4 of unsigned bytes or shorts, four numbers a vertex.
std::vector<uint16_t> read_joint_numbers(GltfDocument& document, const JsonRef& use);

// The numbers of all elements, of `components` each, one after the other.
enum class NumberKind { Float, FloatOrNormalized, Any };
std::vector<float> read_numbers(GltfDocument& document, const JsonRef& use, uint32_t components, NumberKind kind);

// A SCALAR of an unsigned type; no index is `vertex_count` or more.
std::vector<uint32_t> read_indices(GltfDocument& document, const JsonRef& use, uint64_t vertex_count);

}  // namespace parhelion
