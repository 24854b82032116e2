#pragma once
// A 64-bit non-cryptographic hash for cache keys, settings and change detection: FNV-1a over bytes with a final avalanche
// (the mixer is that of SplitMix64, Steele et al. 2014). Stable across runs and machines of equal endianness.
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <type_traits>

namespace parhelion {

class Hasher {
public:
    Hasher& bytes(const void* data, size_t size) {
        const auto* p = static_cast<const unsigned char*>(data);
        for (size_t i = 0; i < size; ++i) state_ = (state_ ^ p[i]) * 0x100000001b3ull;
        return *this;
    }
    Hasher& text(std::string_view value) { return add(static_cast<uint64_t>(value.size())).bytes(value.data(), value.size()); }
    template <class T>
        requires std::is_arithmetic_v<T> || std::is_enum_v<T>
    Hasher& add(T value) {
        return bytes(&value, sizeof(value));
    }
    uint64_t value() const {
        uint64_t z = state_;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
        return z ^ (z >> 31);
    }

private:
    uint64_t state_ = 0xcbf29ce484222325ull;
};

inline uint64_t hash_bytes(const void* data, size_t size) { return Hasher{}.bytes(data, size).value(); }
inline uint64_t hash_text(std::string_view text) { return Hasher{}.text(text).value(); }

}  // namespace parhelion
