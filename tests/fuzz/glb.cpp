// A .glb: JSON, then the binary chunk. Most mutations change one of the two and put a right container around them, so that they get past
// its checks; the others change any byte.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <vector>

#include "fuzz_scene.h"

extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t max_size);

namespace {

constexpr size_t kHeader = 12, kChunkHeader = 8;
constexpr uint32_t kMagic = 0x46546C67u, kJson = 0x4E4F534Au, kBinary = 0x004E4942u;

uint32_t read_u32(const uint8_t* at) { return uint32_t(at[0]) | uint32_t(at[1]) << 8 | uint32_t(at[2]) << 16 | uint32_t(at[3]) << 24; }

void append(std::vector<uint8_t>& out, uint32_t value) {
    for (int shift = 0; shift < 32; shift += 8) out.push_back(static_cast<uint8_t>(value >> shift));
}

void append_chunk(std::vector<uint8_t>& out, uint32_t type, std::vector<uint8_t> bytes, uint8_t padding) {
    bytes.resize((bytes.size() + 3) / 4 * 4, padding);
    append(out, static_cast<uint32_t>(bytes.size()));
    append(out, type);
    out.insert(out.end(), bytes.begin(), bytes.end());
}

struct Chunks {
    std::vector<uint8_t> json, binary;
};

// As much as can be told of the two chunks, whatever the lengths say.
Chunks split(const uint8_t* data, size_t size) {
    Chunks out;
    if (size < kHeader + kChunkHeader) return out;
    const uint8_t* end = data + size;
    const uint8_t* json = data + kHeader + kChunkHeader;
    const size_t json_size = std::min<size_t>(read_u32(data + kHeader), static_cast<size_t>(end - json));
    out.json.assign(json, json + json_size);
    const uint8_t* rest = json + json_size;
    if (static_cast<size_t>(end - rest) > kChunkHeader) out.binary.assign(rest + kChunkHeader, end);
    return out;
}

std::vector<uint8_t> join(const Chunks& chunks) {
    std::vector<uint8_t> body;
    append_chunk(body, kJson, chunks.json, ' ');
    append_chunk(body, kBinary, chunks.binary, 0);
    std::vector<uint8_t> out;
    append(out, kMagic);
    append(out, 2);
    append(out, static_cast<uint32_t>(kHeader + body.size()));
    out.insert(out.end(), body.begin(), body.end());
    return out;
}

void mutate(std::vector<uint8_t>& bytes, size_t max_size) {
    const size_t size = bytes.size();
    bytes.resize(std::max(size, max_size));
    bytes.resize(LLVMFuzzerMutate(bytes.data(), size, bytes.size()));
}

}  // namespace

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size, unsigned seed) {
    if (seed % 8 == 0) return LLVMFuzzerMutate(data, size, max_size);
    Chunks chunks = split(data, size);
    mutate(seed % 2 == 0 ? chunks.binary : chunks.json, max_size / 2);
    const std::vector<uint8_t> out = join(chunks);
    const size_t used = std::min(out.size(), max_size);
    std::memcpy(data, out.data(), used);
    return used;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    parhelion::fuzz::load(std::as_bytes(std::span(data, size)));
    return 0;
}
