#pragma once
// Internal to the glTF writer: the binary buffer as it grows. Its parts are spans, most of them of the scene's own memory; nothing is
// copied until it goes to the file.
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>
#include <nlohmann/json.hpp>

namespace parhelion::gltf {

using Json = nlohmann::ordered_json;

// The shortest decimal that is read as this float again, by way of a double too.
Json number(float value);
Json numbers(const float* values, size_t count);
template <glm::length_t N>
Json numbers(const glm::vec<N, float, glm::defaultp>& v) {
    return numbers(&v[0], static_cast<size_t>(N));
}

enum class Target { None = 0, Vertices = 34962, Indices = 34963 };  // 5.11.5, bufferView.target
enum class Component { UnsignedByte = 5121, UnsignedShort = 5123, UnsignedInt = 5125, Float = 5126 };

// A typed array (3.6.2). `type` is SCALAR, VEC2 ... MAT4.
struct Elements {
    std::span<const std::byte> bytes;
    Component component = Component::Float;
    std::string_view type;
    uint64_t count = 0;
    Target target = Target::None;
    bool with_bounds = false;  // min and max: positions (3.7.2.1) and times (3.11) must have them; floats only
};

class GltfBuffer {
public:
    // The bytes must outlive the buffer, keep() them if nobody else does. Equal arrays become one accessor.
    uint32_t add_accessor(const Elements& elements);
    uint32_t add_view(std::span<const std::byte> bytes, Target target);
    std::span<const std::byte> keep(std::vector<std::byte>&& bytes) { return kept_.emplace_back(std::move(bytes)); }
    template <class T>
    std::span<const std::byte> keep(const std::vector<T>& values) {
        const std::span<const std::byte> bytes = std::as_bytes(std::span(values));
        return keep(std::vector<std::byte>(bytes.begin(), bytes.end()));
    }

    const Json& accessors() const { return accessors_; }
    const Json& views() const { return views_; }
    uint64_t size() const { return size_; }  // a multiple of 4
    std::span<const std::span<const std::byte>> parts() const { return parts_; }

private:
    struct Known {
        Elements elements;
        uint32_t accessor;
    };
    Json accessors_ = Json::array(), views_ = Json::array();
    std::vector<std::span<const std::byte>> parts_;
    std::deque<std::vector<std::byte>> kept_;
    std::multimap<uint64_t, Known> known_;  // by a hash of what they hold
    uint64_t size_ = 0;
};

}  // namespace parhelion::gltf
