#pragma once
// What the glTF targets share: a file in memory becomes a scene, or an Error. Anything else is a bug.
#include <cstddef>
#include <span>

#include "base/error.h"
#include "scene/gltf_read.h"
#include "scene/info.h"
#include "scene/scene.h"

namespace parhelion::fuzz {

// Small, so that one input takes milliseconds and a broken promise about memory is seen as one.
inline constexpr SceneFileLimits kLimits{.budget_base_bytes = 1ull << 20, .budget_factor = 64};

inline void load(std::span<const std::byte> file) {
    SceneFiles files({}, kLimits);
    try {
        Scene scene;
        scene.apply(read_gltf(files, file, "fuzz", {}));
    } catch (const Error&) {
        // The answer to a broken file.
    }
}

}  // namespace parhelion::fuzz
