// The shader pack that is embedded in the library, or the one of PARHELION_SHADER_DIR.
#include <cstdlib>
#include <filesystem>

#include "base/file.h"
#include "gpu/program.h"

namespace parhelion::embedded {
extern const size_t shaders_size;
extern const unsigned char shaders[];
}  // namespace parhelion::embedded

namespace parhelion::gpu {

const ShaderPack& ShaderPack::builtin() {
    static const ShaderPack pack = [] {
        const char* folder = std::getenv("PARHELION_SHADER_DIR");
        if (!folder || !*folder) return ShaderPack(std::as_bytes(std::span(embedded::shaders, embedded::shaders_size)));
        constexpr uint64_t kMaxBytes = 256ull << 20;
        return ShaderPack(read_file(std::filesystem::path(folder) / "shaders.pack", kMaxBytes));
    }();
    return pack;
}

}  // namespace parhelion::gpu
