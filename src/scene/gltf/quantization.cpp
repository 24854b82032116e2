#include "scene/gltf/quantization.h"

#include "base/error.h"
#include "scene/gltf/accessors.h"

namespace parhelion {

namespace {

enum class Allowed { Core, Quantized, Never };

// KHR_mesh_quantization, "Extending Mesh Attributes".
Allowed allowed(std::string_view attribute, const AccessorShape& shape) {
    if (shape.type == ComponentType::Float) return Allowed::Core;
    if (shape.type == ComponentType::UnsignedInt) return Allowed::Never;
    const bool is_unsigned = shape.type == ComponentType::UnsignedByte || shape.type == ComponentType::UnsignedShort;
    if (attribute == "POSITION") return Allowed::Quantized;
    if (attribute == "NORMAL" || attribute == "TANGENT") return !is_unsigned && shape.normalized ? Allowed::Quantized : Allowed::Never;
    const bool core = is_unsigned && shape.normalized;
    if (attribute.starts_with("TEXCOORD")) return core ? Allowed::Core : Allowed::Quantized;
    return core ? Allowed::Core : Allowed::Never;
}

std::string_view name_of(ComponentType type) {
    switch (type) {
        case ComponentType::Byte:
            return "BYTE";
        case ComponentType::UnsignedByte:
            return "UNSIGNED_BYTE";
        case ComponentType::Short:
            return "SHORT";
        case ComponentType::UnsignedShort:
            return "UNSIGNED_SHORT";
        case ComponentType::UnsignedInt:
            return "UNSIGNED_INT";
        case ComponentType::Float:
            break;
    }
    return "FLOAT";
}

// glTF 2.0, 3.6.2.4: each element of a vertex attribute starts at a multiple of four bytes of its view.
void warn_of_alignment(GltfDocument& document, const JsonRef& use, const AccessorShape& shape) {
    const JsonRef accessor = document.entry("accessors", use);
    const std::optional<JsonRef> view = accessor.find("bufferView");
    if (!view) return;
    const uint64_t stride = document.entry("bufferViews", *view).uint("byteStride", shape.element_bytes(), 1u << 16);
    if (stride % 4 != 0 || accessor.uint("byteOffset", 0, 1ull << 53) % 4 != 0)
        document.warn(accessor, "its elements are not aligned to four bytes, as those of vertex attributes are");
}

}  // namespace

void warn_of_layout(GltfDocument& document, const JsonRef& use, std::string_view attribute) {
    const AccessorShape shape = accessor_shape(document, use);
    warn_of_alignment(document, use, shape);
    const Allowed rule = allowed(attribute, shape);
    if (rule == Allowed::Core || (rule == Allowed::Quantized && document.uses("KHR_mesh_quantization"))) return;
    const std::string type = fmt::format("{}{}", shape.normalized ? "normalised " : "", name_of(shape.type));
    document.warn(use, rule == Allowed::Quantized ? fmt::format("{} needs KHR_mesh_quantization, which the file does not declare", type)
                                                  : fmt::format("{} is no type that glTF allows here", type));
}

}  // namespace parhelion
