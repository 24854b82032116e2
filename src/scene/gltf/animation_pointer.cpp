#include "scene/gltf/animation_pointer.h"

#include <charconv>

namespace parhelion {

namespace {

struct PointerRow {
    std::string_view before, after;  // of the number of the object
    AnimatedPath path;
};

constexpr PointerRow kPointers[] = {
    {"/nodes/", "/translation", AnimatedPath::Translation},
    {"/nodes/", "/rotation", AnimatedPath::Rotation},
    {"/nodes/", "/scale", AnimatedPath::Scale},
    {"/nodes/", "/weights", AnimatedPath::Weights},
    {"/nodes/", "/extensions/KHR_node_visibility/visible", AnimatedPath::Visible},
    {"/extensions/KHR_lights_punctual/lights/", "/color", AnimatedPath::Color},
    {"/extensions/KHR_lights_punctual/lights/", "/intensity", AnimatedPath::Intensity},
    {"/extensions/KHR_lights_punctual/lights/", "/spot/innerConeAngle", AnimatedPath::InnerCone},
    {"/extensions/KHR_lights_punctual/lights/", "/spot/outerConeAngle", AnimatedPath::OuterCone},
    {"/cameras/", "/perspective/yfov", AnimatedPath::Yfov},
    {"/cameras/", "/orthographic/xmag", AnimatedPath::Xmag},
    {"/cameras/", "/orthographic/ymag", AnimatedPath::Ymag},
};

// The object's number; none: the row is of other pointers.
std::optional<uint32_t> match_pointer(std::string_view pointer, const PointerRow& row) {
    if (!pointer.starts_with(row.before) || !pointer.ends_with(row.after) || pointer.size() <= row.before.size() + row.after.size()) return std::nullopt;
    const std::string_view digits = pointer.substr(row.before.size(), pointer.size() - row.before.size() - row.after.size());
    uint32_t number = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    if (error != std::errc{} || end != digits.data() + digits.size()) return std::nullopt;
    return number;
}

size_t object_count(const JsonRef& root, AnimatedPath path) {
    switch (object_of(path)) {
        case AnimatedObject::Node:
            return root.array_size("nodes");
        case AnimatedObject::Camera:
            return root.array_size("cameras");
        case AnimatedObject::Light:
            break;
    }
    const std::optional<JsonRef> table = root.extension("KHR_lights_punctual");
    return table ? table->array_size("lights") : 0;
}

}  // namespace

std::optional<AnimatedProperty> read_animation_pointer(GltfDocument& document, const JsonRef& target) {
    const std::optional<JsonRef> extension = target.extension("KHR_animation_pointer");
    if (!extension) {
        document.warn(target, "animates a pointer, but names none");
        return std::nullopt;
    }
    const JsonRef pointer = extension->at("pointer");
    for (const PointerRow& row : kPointers) {
        const std::optional<uint32_t> object = match_pointer(pointer.as_string(), row);
        if (!object) continue;
        if (*object >= object_count(document.root(), row.path)) pointer.fail(fmt::format("'{}' points to nothing in the file", escape_name(pointer.as_string(), 80)));
        return AnimatedProperty{row.path, *object};
    }
    document.leave_out("KHR_animation_pointer");
    document.warn("of what KHR_animation_pointer animates, all but nodes, their visibility, lights and cameras stands still");
    return std::nullopt;
}

}  // namespace parhelion
