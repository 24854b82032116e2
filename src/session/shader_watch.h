#pragma once
// Shaders that are worked on while a scene is on the screen: a folder's pack is read again when it changes, and built anew on demand.
#include <chrono>
#include <filesystem>
#include <future>
#include <memory>
#include <string>

#include "base/platform.h"
#include "gpu/program.h"

namespace parhelion {

class ShaderWatch {
public:
    // `folder`: of `shaders.pack` (PARHELION_SHADER_DIR); empty: nothing is watched. `build_line` makes it anew (PARHELION_SHADER_BUILD).
    ShaderWatch(std::filesystem::path folder, std::string build_line);

    // Begins a build beside the caller. Throws a usage Error where there is nothing to build.
    void build();
    bool is_building() const { return building_.valid(); }
    // Once a frame: the pack, if it is another one than before; else null. Throws Error, once, for a build that failed (with its first line that
    // speaks of an error) and for a pack that cannot be read.
    std::shared_ptr<const gpu::ShaderPack> poll();

private:
    std::filesystem::path file_;
    std::string build_line_;
    std::future<platform::CommandResult> building_;
    std::filesystem::file_time_type seen_{};
    std::chrono::steady_clock::time_point looked_at_{};
};

}  // namespace parhelion
