#include "scene/gltf/write_buffer.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>

#include "base/hash.h"

namespace parhelion::gltf {

namespace {

constexpr std::array<std::byte, 4> kZeros{};

// Beginning and end tell most arrays apart; the rest is compared.
uint64_t hash_of(const Elements& e) {
    constexpr size_t kSample = 4096;
    Hasher hasher;
    hasher.add(e.count).add(e.component).add(e.target).add(e.with_bounds).text(e.type).add(e.bytes.size());
    hasher.bytes(e.bytes.data(), std::min(kSample, e.bytes.size()));
    if (e.bytes.size() > kSample) hasher.bytes(e.bytes.data() + e.bytes.size() - kSample, kSample);
    return hasher.value();
}

bool equal(const Elements& a, const Elements& b) {
    return a.count == b.count && a.component == b.component && a.type == b.type && a.target == b.target && a.with_bounds == b.with_bounds &&
           a.bytes.size() == b.bytes.size() && std::memcmp(a.bytes.data(), b.bytes.data(), a.bytes.size()) == 0;
}

void add_bounds(const Elements& e, Json& accessor) {
    const size_t width = e.bytes.size() / e.count / sizeof(float);
    std::vector<float> element(width), min(width), max(width);
    for (uint64_t i = 0; i < e.count; ++i) {
        std::memcpy(element.data(), e.bytes.data() + i * width * sizeof(float), width * sizeof(float));
        for (size_t c = 0; c < width; ++c) {
            min[c] = i == 0 ? element[c] : std::min(min[c], element[c]);
            max[c] = i == 0 ? element[c] : std::max(max[c], element[c]);
        }
    }
    accessor["min"] = numbers(min.data(), width);
    accessor["max"] = numbers(max.data(), width);
}

}  // namespace

Json number(float value) {
    char text[32];
    const std::to_chars_result end = std::to_chars(text, text + sizeof(text), value);
    double decimal = 0;
    std::from_chars(text, end.ptr, decimal);
    return static_cast<float>(decimal) == value ? decimal : static_cast<double>(value);
}

Json numbers(const float* values, size_t count) {
    Json out = Json::array();
    for (size_t i = 0; i < count; ++i) out.push_back(number(values[i]));
    return out;
}

uint32_t GltfBuffer::add_view(std::span<const std::byte> bytes, Target target) {
    Json view{{"buffer", 0}, {"byteOffset", size_}, {"byteLength", bytes.size()}};
    if (target != Target::None) view["target"] = static_cast<int>(target);
    views_.push_back(std::move(view));
    parts_.push_back(bytes);
    // Every view begins at a multiple of 4, of which the size of every component is a divisor (3.6.2.4).
    const size_t padding = (4 - bytes.size() % 4) % 4;
    if (padding != 0) parts_.push_back(std::span(kZeros).first(padding));
    size_ += bytes.size() + padding;
    return static_cast<uint32_t>(views_.size() - 1);
}

uint32_t GltfBuffer::add_accessor(const Elements& elements) {
    const uint64_t hash = hash_of(elements);
    for (auto [at, end] = known_.equal_range(hash); at != end; ++at)
        if (equal(at->second.elements, elements)) return at->second.accessor;
    Json accessor{{"bufferView", add_view(elements.bytes, elements.target)},
                  {"componentType", static_cast<int>(elements.component)},
                  {"count", elements.count},
                  {"type", elements.type}};
    if (elements.with_bounds) add_bounds(elements, accessor);
    accessors_.push_back(std::move(accessor));
    const uint32_t index = static_cast<uint32_t>(accessors_.size() - 1);
    known_.emplace(hash, Known{elements, index});
    return index;
}

}  // namespace parhelion::gltf
