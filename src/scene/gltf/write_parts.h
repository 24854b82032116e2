#pragma once
// Internal to the glTF writer: what its parts share. Each part fills tables of the root and the numbers by which others name them.
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "scene/gltf/write.h"
#include "scene/gltf/write_buffer.h"

namespace parhelion::gltf {

constexpr uint32_t kNotWritten = 0xFFFFFFFFu;

// The number that an object has in the file.
template <class T>
class Numbers {
public:
    void set(Handle<T> handle, uint32_t number) {
        if (handle.index >= numbers_.size()) numbers_.resize(size_t(handle.index) + 1, kNotWritten);
        numbers_[handle.index] = number;
    }
    uint32_t of(Handle<T> handle) const { return handle && handle.index < numbers_.size() ? numbers_[handle.index] : kNotWritten; }

private:
    std::vector<uint32_t> numbers_;
};

struct SideFile {
    std::string name;
    std::span<const std::byte> bytes;
};

struct Writer {
    const Scene& scene;
    std::string stem;  // of the .gltf, for the names of its images; empty: images go into the buffer
    Json root = Json::object();
    GltfBuffer buffer = {};
    std::vector<SideFile> side_files = {};
    std::set<std::string> used = {}, required = {};
    std::vector<std::string> warnings = {};
    Numbers<Image> images = {};
    Numbers<Texture> textures = {};
    Numbers<Material> materials = {};
    Numbers<Mesh> meshes = {};
    Numbers<Node> nodes = {};
    Numbers<Skin> skins = {};
    Numbers<Light> lights = {};
    Numbers<Camera> cameras = {};
    std::map<uint32_t, std::vector<uint32_t>> instance_nodes = {};  // by index of a Node's handle: the nodes in the file that carry its instances
    std::vector<Handle<Skin>> skin_order = {};

    // Adds to an array of the root and returns the number there. Tables that would be empty do not exist: glTF forbids them.
    uint32_t push(const char* table, Json value) {
        Json& list = root[table];
        list.push_back(std::move(value));
        return static_cast<uint32_t>(list.size() - 1);
    }
    // An extension object of `owner`, which counts as used from now on.
    Json& extend(Json& owner, const std::string& name, Json value) {
        used.insert(name);
        return owner["extensions"][name] = std::move(value);
    }
    void warn(std::string text);
};

inline Json named(const std::string& name) {
    Json out = Json::object();
    if (!name.empty()) out["name"] = name;
    return out;
}

template <class V>
Elements vectors(const std::vector<V>& values, std::string_view type, Target target = Target::Vertices) {
    return {.bytes = std::as_bytes(std::span(values)), .type = type, .count = values.size(), .target = target};
}

// Each needs those before it.
void write_images(Writer& writer);
void write_textures(Writer& writer);
void write_materials(Writer& writer);
void write_meshes(Writer& writer);
void write_nodes(Writer& writer);  // with lights, cameras and the scene
void write_skins(Writer& writer);
void write_animations(Writer& writer);

std::string percent_encode(std::string_view name);

}  // namespace parhelion::gltf
