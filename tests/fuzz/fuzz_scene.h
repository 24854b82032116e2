#pragma once
// What the glTF targets share: a file in memory goes the way of load_scene(), and its scene that of `parhelion info` and
// `parhelion export`, or it is an Error. Anything else is a bug.
#include <cstddef>
#include <span>

#include "base/error.h"
#include "base/log.h"
#include "scene/gltf/read.h"
#include "scene/gltf/write.h"
#include "scene/info.h"
#include "scene/pose.h"
#include "scene/scene.h"

namespace parhelion::fuzz {

// Small, so that one input takes milliseconds and a broken promise about memory is seen as one.
inline constexpr SceneFileLimits kLimits{.budget_base_bytes = 1ull << 20, .budget_factor = 64};

inline Scene read(std::span<const std::byte> file, const GltfOptions& options) {
    SceneFiles files({}, kLimits);
    Scene scene;
    scene.apply(read_gltf(files, file, "fuzz", options));
    return scene;
}

// At rest, then at two moments of its animations: the second replaces what the first has posed.
inline void pose(std::span<const std::byte> file) {
    SceneFiles files({}, kLimits);
    LoadedScene loaded;
    loaded.scene.apply(read_gltf(files, file, "fuzz", {}));
    for (const double seconds : {0.0, 0.3}) {
        loaded.scene.apply(pose_at(loaded.scene, seconds, {}, [&](uint64_t bytes) { files.charge(bytes, "fuzz"); }));
        loaded.scene.begin_frame();
    }
    format_info(describe(loaded));
}

// The first variant, written and read again.
inline void exchange(std::span<const std::byte> file) {
    const Scene plain = read(file, {.median_order = false, .keep_encoded = true});
    if (const std::vector<std::string>& variants = plain.source().variants; !variants.empty()) read(file, {.variant = variants.front()});
    read(write_glb(plain), {.median_order = false});
}

inline void load(std::span<const std::byte> file) {
    set_log_level(LogLevel::Off);
    try {
        pose(file);
        exchange(file);
    } catch (const Error&) {
        // The answer to a broken file.
    }
}

}  // namespace parhelion::fuzz
