#include "scene/gltf_read.h"

#include <algorithm>
#include <cmath>

#include "scene/gltf_document.h"
#include "scene/gltf_materials.h"
#include "scene/gltf_meshes.h"
#include "scene/gltf_nodes.h"

namespace parhelion {

namespace {

// One run of the reader: everything is read in the order in which an edit can take it.
class GltfReader {
public:
    GltfReader(GltfDocument& document, const GltfOptions& options) : document_(document), options_(options) {}

    SceneEdit read() {
        nodes_ = collect_nodes(document_);
        add_meshes();
        add_nodes();
        if (nodes_.empty()) document_.warn("the scene is empty");
        return std::move(edit_);
    }

private:
    JsonRef node_json(const GltfNode& node) const { return document_.root().at("nodes")[node.index]; }

    // Only what a node of the scene shows is read.
    void add_meshes() {
        std::set<uint32_t> meshes;
        for (const GltfNode& node : nodes_)
            if (const auto mesh = node_json(node).find("mesh")) meshes.insert(mesh->as_index_of("meshes"));
        std::set<uint32_t> materials;
        bool needs_default = false;
        for (const uint32_t mesh : meshes)
            for (const std::optional<uint32_t> material : materials_of(document_.root().at("meshes")[mesh]))
                if (material)
                    materials.insert(*material);
                else
                    needs_default = true;
        const MaterialHandles handles = add_materials(document_, edit_, materials, needs_default);
        uint64_t flat = 0;
        for (const uint32_t index : meshes) {
            Mesh mesh = read_mesh(document_, document_.root().at("meshes")[index], handles, {.median_order = options_.median_order});
            for (const Primitive& primitive : mesh.primitives) flat += count_flat_triangles(primitive);
            if (!mesh.primitives.empty()) meshes_[index] = edit_.add(std::move(mesh));
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
        std::vector<glm::dmat4> world;
        document_.files().charge(nodes_.size() * 2 * (sizeof(Node) + sizeof(Instance)), document_.root().where());
        for (const GltfNode& node : nodes_) {
            const JsonRef json = node_json(node);
            Node value{.name = json.string("name"), .local = read_transform(document_, json)};
            world.push_back(glm::dmat4(matrix_of(value.local)));
            if (node.parent != GltfNode::kNoParent) {
                value.parent = handles[node.parent];
                world.back() = world[node.parent] * world.back();
            }
            check_reach(json, world.back());
            handles.push_back(edit_.add(std::move(value)));
            add_contents(json, handles.back());
        }
    }

    // Products of finite transforms may still leave the range of float.
    static void check_reach(const JsonRef& json, const glm::dmat4& world) {
        for (int column = 0; column < 4; ++column)
            for (int row = 0; row < 4; ++row)
                if (!(std::abs(world[column][row]) <= kLargestCoordinate))
                    json.fail("its place in the world is beyond all measure", "look at the scales of its parents");
    }

    void add_contents(const JsonRef& json, Handle<Node> node) {
        const std::string node_name = json.string("name");
        if (const auto mesh = json.find("mesh")) {
            const auto found = meshes_.find(mesh->as_index_of("meshes"));
            if (found != meshes_.end()) edit_.add(Instance{.mesh = found->second, .place = {.node = node}});
            if (json.find("skin")) document_.warn("skins are not evaluated: skinned meshes keep their rest pose");
        }
        if (const auto camera_ref = json.find("camera")) {
            Camera camera = read_camera(document_, document_.entry("cameras", *camera_ref));
            charge_name(*camera_ref, camera.name);
            if (camera.name.empty()) camera.name = node_name;
            camera.place.node = node;
            edit_.add(std::move(camera));
        }
        if (const auto extension = json.extension("KHR_lights_punctual")) add_light(extension->at("light"), node, node_name);
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
        edit_.add(std::move(light));
    }

    GltfDocument& document_;
    GltfOptions options_;
    SceneEdit edit_;
    std::vector<GltfNode> nodes_;
    std::map<uint32_t, Handle<Mesh>> meshes_;
};

}  // namespace

SceneEdit read_gltf(SceneFiles& files, std::span<const std::byte> file, const std::string& name, const GltfOptions& options) {
    GltfDocument document(files, file, name);
    GltfReader reader(document, options);
    SceneEdit edit = reader.read();

    const JsonRef root = document.root();
    SceneSource source{.name = name,
                       .generator = root.at("asset").string("generator"),
                       .copyright = root.at("asset").string("copyright"),
                       .extensions_used = document.extensions_used(),
                       .extensions_required = document.extensions_required(),
                       .extensions_not_drawn = document.extensions_not_drawn()};
    source.warnings = document.take_warnings();
    source.file_bytes = files.bytes_read();
    edit.set_source(std::move(source));
    return edit;
}

}  // namespace parhelion
