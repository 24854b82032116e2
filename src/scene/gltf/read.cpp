#include "scene/gltf/read.h"

#include <algorithm>
#include <cmath>

#include "scene/gltf/animation.h"
#include "scene/gltf/document.h"
#include "scene/gltf/instancing.h"
#include "scene/gltf/materials.h"
#include "scene/gltf/meshes.h"
#include "scene/gltf/nodes.h"
#include "scene/gltf/skins.h"
#include "scene/gltf/variants.h"

namespace parhelion {

namespace {

// One run of the reader: everything is read in the order in which an edit can take it.
class GltfReader {
public:
    GltfReader(GltfDocument& document, const GltfOptions& options, size_t variant_count, std::optional<uint32_t> variant)
        : document_(document),
          keep_encoded_(options.keep_encoded),
          mesh_options_{.median_order = options.median_order, .variant_count = variant_count, .variant = variant} {}

    SceneEdit read() {
        nodes_ = collect_nodes(document_);
        add_joint_nodes(document_, nodes_);
        add_meshes();
        add_nodes();
        add_skins();
        for (size_t n = 0; n < nodes_.size(); ++n)
            if (nodes_[n].drawn) add_contents(node_json(nodes_[n]), handles_.at(nodes_[n].index), worlds_[n]);
        add_animations(document_, edit_, {animated_nodes(), lights_, cameras_});
        if (nodes_.empty()) document_.warn("the scene is empty");
        return std::move(edit_);
    }

private:
    JsonRef node_json(const GltfNode& node) const { return document_.root().at("nodes")[node.index]; }

    // Only what a node of the scene shows is read.
    void add_meshes() {
        std::set<uint32_t> meshes;
        for (const GltfNode& node : nodes_)
            if (const auto mesh = node_json(node).find("mesh"); mesh && node.drawn) meshes.insert(mesh->as_index_of("meshes"));
        std::set<uint32_t> materials;
        bool needs_default = false;
        for (const uint32_t mesh : meshes)
            for (const std::optional<uint32_t> material : materials_of(document_.root().at("meshes")[mesh]))
                if (material)
                    materials.insert(*material);
                else
                    needs_default = true;
        const MaterialHandles handles = add_materials(document_, edit_, materials, needs_default, keep_encoded_);
        uint64_t flat = 0;
        for (const uint32_t index : meshes) {
            Mesh mesh = read_mesh(document_, document_.root().at("meshes")[index], handles, mesh_options_);
            if (mesh.primitives.empty()) continue;
            for (const Primitive& primitive : mesh.primitives) flat += count_flat_triangles(primitive);
            deformation_[index] = {joints_needed(mesh), static_cast<uint32_t>(mesh.primitives[0].targets.size())};
            meshes_[index] = edit_.add(std::move(mesh));
        }
        if (flat != 0) document_.warn(fmt::format("triangles without area, which are never seen: {}", flat));
    }

    static uint64_t count_flat_triangles(const Primitive& primitive) {
        const auto is_flat = [&](const glm::uvec3& t) {
            const glm::dvec3 a(primitive.positions[t.x]), b(primitive.positions[t.y]), c(primitive.positions[t.z]);
            return glm::cross(b - a, c - a) == glm::dvec3(0.0);
        };
        return static_cast<uint64_t>(std::count_if(primitive.triangles.begin(), primitive.triangles.end(), is_flat));
    }

    void add_nodes() {
        std::vector<Handle<Node>> handles;
        // In the edit, then in the scene; of an instance, only where there is one.
        constexpr uint64_t kBytesPerNode = 2 * sizeof(Node) + sizeof(glm::dmat4);
        const auto meshes = std::ranges::count_if(nodes_, [&](const GltfNode& node) { return node.drawn && node_json(node).find("mesh"); });
        document_.files().charge(nodes_.size() * kBytesPerNode + static_cast<uint64_t>(meshes) * 2 * sizeof(Instance), document_.root().where());
        for (const GltfNode& node : nodes_) {
            const JsonRef json = node_json(node);
            Node value{.name = json.string("name"), .local = read_transform(document_, json)};
            if (const auto visibility = json.extension("KHR_node_visibility")) value.visible = visibility->boolean("visible", true);
            worlds_.push_back(glm::dmat4(matrix_of(value.local)));
            if (node.parent != GltfNode::kNoParent) {
                value.parent = handles[node.parent];
                worlds_.back() = worlds_[node.parent] * worlds_.back();
            }
            check_reach(json, worlds_.back());
            handles.push_back(edit_.add(std::move(value)));
            handles_[node.index] = handles.back();
        }
    }

    void add_skins() {
        for (const GltfNode& node : nodes_) {
            const std::optional<JsonRef> ref = node_json(node).find("skin");
            if (!ref || !node.drawn) continue;
            const uint32_t index = ref->as_index_of("skins");
            if (skins_.contains(index)) continue;
            Skin skin = read_skin(document_, document_.entry("skins", *ref), handles_);
            joint_counts_[index] = skin.joints.size();
            skins_[index] = edit_.add(std::move(skin));
        }
    }

    // The skin and the weights of morph targets that a node gives its mesh.
    void read_deformation(const JsonRef& json, uint32_t mesh, Instance& instance) {
        const Deformation& needs = deformation_.at(mesh);
        instance.weights = read_weights(document_, json, needs.targets);
        const std::optional<JsonRef> ref = json.find("skin");
        if (!ref && needs.joints != 0) document_.warn(json, "its mesh has joints, but the node has no skin");
        if (!ref) return;
        if (needs.joints == 0) {
            document_.warn(json, "has a skin, but its mesh has no joints");
            return;
        }
        const uint32_t skin = ref->as_index_of("skins");
        if (needs.joints > joint_counts_.at(skin))
            ref->fail(fmt::format("its mesh names joint {}, but the skin has {}", needs.joints - 1, joint_counts_.at(skin)));
        instance.skin = skins_.at(skin);
    }

    std::map<uint32_t, AnimatedNode> animated_nodes() const {
        std::map<uint32_t, AnimatedNode> out;
        for (const GltfNode& node : nodes_) {
            const std::optional<JsonRef> mesh = node.drawn ? node_json(node).find("mesh") : std::nullopt;
            const auto found = mesh ? deformation_.find(mesh->as_index_of("meshes")) : deformation_.end();
            out[node.index] = {handles_.at(node.index), found != deformation_.end() ? found->second.targets : 0};
        }
        return out;
    }

    // Products of finite transforms may still leave the range of float.
    static void check_reach(const JsonRef& json, const glm::dmat4& world) {
        for (int column = 0; column < 4; ++column)
            for (int row = 0; row < 4; ++row)
                if (!(std::abs(world[column][row]) <= kLargestCoordinate))
                    json.fail("its place in the world is beyond all measure", "look at the scales of its parents");
    }

    void add_contents(const JsonRef& json, Handle<Node> node, const glm::dmat4& world) {
        const std::string node_name = json.string("name");
        if (const auto mesh = json.find("mesh")) {
            const uint32_t index = mesh->as_index_of("meshes");
            if (const auto found = meshes_.find(index); found != meshes_.end()) {
                Instance instance{.mesh = found->second, .place = {.node = node}};
                read_deformation(json, index, instance);
                add_instances(json, std::move(instance), world);
            }
        } else if (json.find("skin")) {
            document_.warn(json, "has a skin, but no mesh");
        }
        if (const auto camera_ref = json.find("camera")) {
            Camera camera = read_camera(document_, document_.entry("cameras", *camera_ref));
            charge_name(*camera_ref, camera.name);
            if (camera.name.empty()) camera.name = node_name;
            camera.place.node = node;
            cameras_[camera_ref->as_index_of("cameras")].push_back(edit_.add(std::move(camera)));
        }
        if (const auto extension = json.extension("KHR_lights_punctual")) add_light(extension->at("light"), node, node_name);
    }

    // One, or as many as EXT_mesh_gpu_instancing says.
    void add_instances(const JsonRef& json, const Instance& instance, const glm::dmat4& world) {
        const std::optional<JsonRef> instancing = json.extension("EXT_mesh_gpu_instancing");
        if (!instancing) {
            edit_.add(instance);
            return;
        }
        const std::vector<glm::mat4> places = read_instance_places(document_, *instancing);
        document_.files().charge(places.size() * (2 * sizeof(Instance) + instance.weights.size() * sizeof(float)), instancing->where());
        for (const glm::mat4& place : places) {
            check_reach(json, world * glm::dmat4(place));
            Instance one = instance;
            one.place.node_from_object = place;
            edit_.add(std::move(one));
        }
    }

    // Every node that names the same camera or light gets one of its own, with its name.
    void charge_name(const JsonRef& use, const std::string& name) { document_.files().charge(sizeof(Camera) + name.size(), use.where()); }

    void add_light(const JsonRef& ref, Handle<Node> node, const std::string& node_name) {
        const std::optional<JsonRef> table = document_.root().extension("KHR_lights_punctual");
        if (!table) ref.fail("names a light, but the file has none", "extensions.KHR_lights_punctual.lights");
        const JsonRef lights = table->at("lights");
        const uint64_t index = ref.as_uint(0xFFFFFFFFull);
        if (index >= lights.size()) ref.fail(fmt::format("names light {}, but the file has {}", index, lights.size()));
        Light light = read_light(document_, lights[index]);
        charge_name(ref, light.name);
        if (light.name.empty()) light.name = node_name;
        light.place.node = node;
        lights_[static_cast<uint32_t>(index)].push_back(edit_.add(std::move(light)));
    }

    GltfDocument& document_;
    bool keep_encoded_;
    MeshOptions mesh_options_;
    SceneEdit edit_;
    // What a mesh asks of its nodes.
    struct Deformation {
        uint32_t joints, targets;  // joints that its skin must have at least; 0: no skin
    };
    std::vector<GltfNode> nodes_;
    std::vector<glm::dmat4> worlds_;  // by place in nodes_: world_from_node at rest
    // By number in the file.
    std::map<uint32_t, Handle<Node>> handles_;
    std::map<uint32_t, Handle<Mesh>> meshes_;
    std::map<uint32_t, Deformation> deformation_;
    std::map<uint32_t, Handle<Skin>> skins_;
    std::map<uint32_t, size_t> joint_counts_;
    std::map<uint32_t, std::vector<Handle<Light>>> lights_;
    std::map<uint32_t, std::vector<Handle<Camera>>> cameras_;
};

}  // namespace

SceneEdit read_gltf(SceneFiles& files, std::span<const std::byte> file, const std::string& name, const GltfOptions& options) {
    GltfDocument document(files, file, name);
    const std::vector<std::string> variants = variant_names(document);
    GltfReader reader(document, options, variants.size(), find_variant(variants, options.variant, name));
    SceneEdit edit = reader.read();

    const JsonRef root = document.root();
    SceneSource source{.name = name,
                       .generator = root.at("asset").string("generator"),
                       .copyright = root.at("asset").string("copyright"),
                       .extensions_used = document.extensions_used(),
                       .extensions_required = document.extensions_required(),
                       .extensions_not_drawn = document.extensions_not_drawn()};
    source.warnings = document.take_warnings();
    source.variants = variants;
    source.file_bytes = files.bytes_read();
    edit.set_source(std::move(source));
    return edit;
}

}  // namespace parhelion
