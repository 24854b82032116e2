// The shader pack that is embedded in the library, or the one of PARHELION_SHADER_DIR.
#include <cstdlib>
#include <filesystem>

#include <zstd.h>

#include "base/error.h"
#include "base/file.h"
#include "gpu/program.h"

namespace parhelion::embedded {
extern const size_t shaders_size;
extern const unsigned char shaders[];
}  // namespace parhelion::embedded

namespace parhelion::gpu {

namespace {

std::vector<std::byte> unpack(std::span<const unsigned char> packed) {
    std::vector<std::byte> bytes(ZSTD_getFrameContentSize(packed.data(), packed.size()));
    const size_t size = ZSTD_decompress(bytes.data(), bytes.size(), packed.data(), packed.size());
    PARHELION_CHECK(size == bytes.size(), "the embedded shaders cannot be unpacked");
    return bytes;
}

}  // namespace

const ShaderPack& ShaderPack::builtin() {
    static const ShaderPack pack = [] {
        const char* folder = std::getenv("PARHELION_SHADER_DIR");
        if (!folder || !*folder) return ShaderPack(unpack({embedded::shaders, embedded::shaders_size}));
        constexpr uint64_t kMaxBytes = 256ull << 20;
        return ShaderPack(read_file(std::filesystem::path(folder) / "shaders.pack", kMaxBytes));
    }();
    return pack;
}

}  // namespace parhelion::gpu
