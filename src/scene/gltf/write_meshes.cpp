// Meshes (3.7.2): attributes as they lie in memory, indices as small as they may be, morph targets, joints and weights.
#include <unordered_set>

#include "scene/gltf/write_parts.h"

namespace parhelion::gltf {

namespace {

// Positions have bounds (3.7.2.1), those of morph targets too.
template <class V>
void add_attribute(Writer& writer, Json& attributes, const std::string& name, const std::vector<V>& values) {
    if (values.empty()) return;
    Elements elements = vectors(values, V::length() == 2 ? "VEC2" : V::length() == 3 ? "VEC3" : "VEC4");
    elements.with_bounds = name == "POSITION";
    attributes[name] = writer.buffer.add_accessor(elements);
}

// 65535 would restart the primitive (3.7.2.1) and cannot be an index of 16 bits.
uint32_t write_indices(Writer& writer, const Primitive& primitive) {
    Elements elements = vectors(primitive.triangles, "SCALAR", Target::Indices);
    elements.component = Component::UnsignedInt;
    elements.count = 3 * primitive.triangles.size();
    if (primitive.positions.size() <= 65535) {
        std::vector<uint16_t> small;
        small.reserve(elements.count);
        for (const glm::uvec3& t : primitive.triangles)
            for (int corner = 0; corner < 3; ++corner) small.push_back(static_cast<uint16_t>(t[corner]));
        elements.bytes = writer.buffer.keep(small);
        elements.component = Component::UnsignedShort;
    }
    return writer.buffer.add_accessor(elements);
}

// Influences in sets of four (3.7.3.3); what is missing of the last set weighs nothing.
void write_influences(Writer& writer, const Primitive& p, Json& attributes) {
    for (uint32_t set = 0; set * 4 < p.influence_count; ++set) {
        std::vector<uint16_t> joints;
        std::vector<float> weights;
        joints.reserve(4 * p.positions.size()), weights.reserve(4 * p.positions.size());
        for (size_t v = 0; v < p.positions.size(); ++v)
            for (uint32_t i = set * 4; i < set * 4 + 4; ++i) {
                const bool there = i < p.influence_count;
                const float weight = there ? p.joint_weights[v * p.influence_count + i] : 0.0f;
                weights.push_back(weight);
                joints.push_back(there ? p.joints[v * p.influence_count + i] : uint16_t{0});
            }
        attributes[fmt::format("JOINTS_{}", set)] = writer.buffer.add_accessor({.bytes = writer.buffer.keep(joints),
                                                                                .component = Component::UnsignedShort,
                                                                                .type = "VEC4",
                                                                                .count = p.positions.size(),
                                                                                .target = Target::Vertices});
        attributes[fmt::format("WEIGHTS_{}", set)] = writer.buffer.add_accessor(
            {.bytes = writer.buffer.keep(weights), .type = "VEC4", .count = p.positions.size(), .target = Target::Vertices});
    }
}

Json write_targets(Writer& writer, const Primitive& primitive) {
    Json targets = Json::array();
    for (const MorphTarget& target : primitive.targets) {
        Json attributes = Json::object();
        add_attribute(writer, attributes, "POSITION", target.positions);
        add_attribute(writer, attributes, "NORMAL", target.normals);
        add_attribute(writer, attributes, "TANGENT", target.tangents);
        if (attributes.empty()) {  // a target must name something (5.24.5): offsets of zero
            const std::vector<glm::vec3> zeros(primitive.positions.size(), glm::vec3(0.0f));
            Elements elements = vectors(zeros, "VEC3");
            elements.bytes = writer.buffer.keep(zeros);
            elements.with_bounds = true;
            attributes["POSITION"] = writer.buffer.add_accessor(elements);
        }
        targets.push_back(std::move(attributes));
    }
    return targets;
}

// KHR_materials_variants: which variants show which material, in the order in which variants name them.
void write_variants(Writer& writer, const Primitive& primitive, Json& out) {
    Json mappings = Json::array();
    for (uint32_t variant = 0; variant < primitive.variant_materials.size(); ++variant) {
        const uint32_t material = writer.materials.of(primitive.variant_materials[variant]);
        if (material == kNotWritten) continue;
        bool found = false;
        for (Json& mapping : mappings)
            if (mapping["material"] == material) {
                mapping["variants"].push_back(variant);
                found = true;
            }
        if (!found) mappings.push_back({{"material", material}, {"variants", {variant}}});
    }
    if (!mappings.empty()) writer.extend(out, "KHR_materials_variants", {{"mappings", std::move(mappings)}});
}

Json write_primitive(Writer& writer, const Primitive& primitive) {
    Json attributes = Json::object();
    add_attribute(writer, attributes, "POSITION", primitive.positions);
    add_attribute(writer, attributes, "NORMAL", primitive.normals);
    if (!primitive.normals.empty()) add_attribute(writer, attributes, "TANGENT", primitive.tangents);  // nothing without normals (3.7.2.1)
    add_attribute(writer, attributes, "TEXCOORD_0", primitive.uv0);
    add_attribute(writer, attributes, "TEXCOORD_1", primitive.uv1);
    add_attribute(writer, attributes, "COLOR_0", primitive.colors);
    write_influences(writer, primitive, attributes);
    Json out{{"attributes", std::move(attributes)}, {"indices", write_indices(writer, primitive)}, {"material", writer.materials.of(primitive.material)}};
    if (!primitive.targets.empty()) out["targets"] = write_targets(writer, primitive);
    write_variants(writer, primitive, out);
    return out;
}

}  // namespace

void write_meshes(Writer& writer) {
    std::unordered_set<Handle<Mesh>> at_rest, posed;
    for (const auto& [handle, instance] : writer.scene.instances()) {
        at_rest.insert(instance.mesh);
        if (instance.posed) posed.insert(instance.posed);
    }
    for (const auto& [handle, mesh] : writer.scene.meshes()) {
        if (posed.contains(handle) && !at_rest.contains(handle)) continue;
        Json primitives = Json::array();
        for (const Primitive& primitive : mesh.primitives)
            if (!primitive.triangles.empty()) primitives.push_back(write_primitive(writer, primitive));
        if (primitives.size() != mesh.primitives.size())
            writer.warn(fmt::format("mesh '{}' has parts without a triangle, which glTF does not have", escape_name(mesh.name)));
        if (primitives.empty()) continue;
        Json json = named(mesh.name);
        json["primitives"] = std::move(primitives);
        if (!mesh.weights.empty()) json["weights"] = numbers(mesh.weights.data(), mesh.weights.size());
        if (!mesh.target_names.empty()) json["extras"]["targetNames"] = mesh.target_names;  // where readers look for them (3.7.2.2)
        writer.meshes.set(handle, writer.push("meshes", std::move(json)));
    }
}

}  // namespace parhelion::gltf
