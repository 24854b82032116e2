#include "scene/gltf/instancing.h"

#include "base/error.h"
#include "scene/gltf/accessors.h"
#include "scene/types.h"

namespace parhelion {

namespace {

// The values of an attribute, none if it is not there; `count` is what the attributes before had.
template <glm::length_t N>
std::vector<glm::vec<N, float>> read_attribute(GltfDocument& document, const JsonRef& attributes, std::string_view name,
                                               std::optional<size_t>& count) {
    const std::optional<JsonRef> use = attributes.find(name);
    if (!use) return {};
    std::vector<glm::vec<N, float>> values = read_vectors<N>(document, *use);
    if (count && *count != values.size()) use->fail(fmt::format("has {} elements, but there are {} instances", values.size(), *count));
    count = values.size();
    return values;
}

}  // namespace

std::vector<glm::mat4> read_instance_places(GltfDocument& document, const JsonRef& extension) {
    const JsonRef attributes = extension.at("attributes");
    std::optional<size_t> count;
    const std::vector<glm::vec3> translations = read_attribute<3>(document, attributes, "TRANSLATION", count);
    const std::vector<glm::vec4> rotations = read_attribute<4>(document, attributes, "ROTATION", count);
    const std::vector<glm::vec3> scales = read_attribute<3>(document, attributes, "SCALE", count);
    if (!count) {
        document.warn(extension, "places no instance: it has no TRANSLATION, ROTATION or SCALE");
        return {};
    }
    document.files().charge(*count * sizeof(glm::mat4), extension.where());
    std::vector<glm::mat4> out;
    out.reserve(*count);
    size_t lengthless = 0;
    for (size_t i = 0; i < *count; ++i) {
        Transform place;
        if (!translations.empty()) place.translation = translations[i];
        if (!scales.empty()) place.scale = scales[i];
        if (!rotations.empty()) {
            const glm::dvec4 q(rotations[i]);  // x, y, z, w
            const double length = glm::length(q);
            if (length > 0.0)
                place.rotation = glm::quat(glm::dquat(q.w / length, q.x / length, q.y / length, q.z / length));
            else
                ++lengthless;
        }
        out.push_back(matrix_of(place));
    }
    if (lengthless != 0) document.warn(attributes, fmt::format("{} rotations have no length and turn nothing", lengthless));
    return out;
}

}  // namespace parhelion
