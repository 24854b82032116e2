#pragma once
// Small glTF files made in memory: JSON to change at will and one buffer, embedded as a data: URI or as the chunk of a GLB.
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "scene/gltf/read.h"
#include "scene/scene.h"

namespace parhelion::test {

using nlohmann::json;

std::string base64(std::span<const std::byte> bytes);

class GltfMaker {
public:
    static constexpr int kByte = 5120, kUByte = 5121, kShort = 5122, kUShort = 5123, kUInt = 5125, kFloat = 5126;

    GltfMaker();  // an asset, one scene, no nodes

    template <class T>
    int view(const std::vector<T>& values) {
        return view_bytes(std::as_bytes(std::span(values)));
    }
    int view_bytes(std::span<const std::byte> bytes);
    // An accessor over a view of its own.
    template <class T>
    int accessor(const std::vector<T>& values, int component_type, const std::string& type) {
        const size_t components = type == "SCALAR" ? 1 : type == "MAT4" ? 16 : static_cast<size_t>(type[3] - '0');
        return push(
            "accessors",
            {{"bufferView", view(values)}, {"componentType", component_type}, {"type", type}, {"count", values.size() / components}});
    }
    int floats(const std::vector<float>& values, const std::string& type) { return accessor(values, kFloat, type); }
    int push(const std::string& table, json value);

    // A mesh of one primitive on a root node; returns the primitive.
    json& add_primitive(json primitive);
    // The triangle (0,0,0) (1,0,0) (0,1,0) with normals +z and UVs equal to x, 1 - y.
    json& add_triangle();
    int add_node(json node);  // to the scene

    std::string text() const;  // .gltf with a data: URI
    std::vector<std::byte> glb() const;

    Scene load(const GltfOptions& options = {.median_order = false}) const;
    std::string error() const;  // the line of the Error that loading throws, "" if it throws none

    json doc;

private:
    std::vector<std::byte> buffer_;
};

Scene load_bytes(std::span<const std::byte> bytes, const SceneFileLimits& limits = {},
                 const GltfOptions& options = {.median_order = false});
std::string error_of(std::span<const std::byte> bytes, const SceneFileLimits& limits = {});
std::vector<std::byte> to_bytes(const std::string& text);

// Of scenes with one of a thing.
const Primitive& only_primitive(const Scene& scene);
const Material& only_material(const Scene& scene);

inline bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace parhelion::test

#define EXPECT_CONTAINS(text, part) EXPECT_TRUE(::parhelion::test::contains(text, part)) << "in: " << (text)
