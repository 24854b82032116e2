#pragma once
// KTX2 files made in memory, right or wrong on purpose.
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace parhelion::testing {

struct Ktx2Spec {
    uint32_t format = 37;  // VkFormat; R8G8B8A8_UNORM
    uint32_t width = 1, height = 1, depth = 0, layers = 0, faces = 1;
    uint32_t level_count = 1;               // of the header; 0 with one level: others are to be made
    uint32_t scheme = 0;                    // supercompression
    uint32_t model = 1;                     // colour model of the data format descriptor
    uint32_t flags = 0;                     // of the descriptor; 1: premultiplied alpha
    std::vector<std::pair<std::string, std::string>> keys = {{"KTXorientation", "rd"}};
    std::vector<std::vector<uint8_t>> levels;          // as stored, finest first
    std::vector<uint64_t> unpacked_bytes = {};         // by level; empty: as stored
};

inline std::vector<std::byte> make_ktx2(const Ktx2Spec& spec) {
    std::vector<uint8_t> out = {0xAB, 'K', 'T', 'X', ' ', '2', '0', 0xBB, '\r', '\n', 0x1A, '\n'};
    const auto put = [](std::vector<uint8_t>& to, uint64_t value, int bytes) {
        for (int i = 0; i < bytes; ++i) to.push_back(static_cast<uint8_t>(value >> (8 * i)));
    };
    std::vector<uint8_t> descriptor;
    for (const uint32_t word : {28u, 0u, 24u << 16 | 2u, spec.model | 1u << 8 | 1u << 16 | spec.flags << 24, 0u, 0u, 0u}) put(descriptor, word, 4);
    std::vector<uint8_t> keys;
    for (const auto& [key, value] : spec.keys) {
        put(keys, key.size() + value.size() + 2, 4);
        keys.insert(keys.end(), key.begin(), key.end());
        keys.push_back(0);
        keys.insert(keys.end(), value.begin(), value.end());
        keys.push_back(0);
        keys.resize((keys.size() + 3) / 4 * 4);
    }
    const uint64_t start = 80 + 24 * spec.levels.size(), keys_at = start + descriptor.size();
    for (const uint32_t word : {spec.format, 1u, spec.width, spec.height, spec.depth, spec.layers, spec.faces, spec.level_count, spec.scheme}) put(out, word, 4);
    for (const uint64_t word : {start, uint64_t{descriptor.size()}, keys.empty() ? 0 : keys_at, uint64_t{keys.size()}}) put(out, word, 4);
    put(out, 0, 8);
    put(out, 0, 8);
    // The smallest level comes first in the file.
    uint64_t at = (keys_at + keys.size() + 15) / 16 * 16;
    std::vector<uint64_t> offsets(spec.levels.size());
    for (size_t i = spec.levels.size(); i-- > 0;) {
        offsets[i] = at;
        at += (spec.levels[i].size() + 15) / 16 * 16;
    }
    for (size_t i = 0; i < spec.levels.size(); ++i) {
        put(out, offsets[i], 8);
        put(out, spec.levels[i].size(), 8);
        put(out, spec.unpacked_bytes.empty() ? spec.levels[i].size() : spec.unpacked_bytes[i], 8);
    }
    out.insert(out.end(), descriptor.begin(), descriptor.end());
    out.insert(out.end(), keys.begin(), keys.end());
    for (size_t i = spec.levels.size(); i-- > 0;) {
        out.resize(offsets[i]);
        out.insert(out.end(), spec.levels[i].begin(), spec.levels[i].end());
    }
    const auto* begin = reinterpret_cast<const std::byte*>(out.data());
    return {begin, begin + out.size()};
}

}  // namespace parhelion::testing
