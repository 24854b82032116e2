#pragma once
// Buffer views under EXT_meshopt_compression and KHR_meshopt_compression, which differ in what may be inside: KHR adds a newer vertex
// codec and the COLOR filter.
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "scene/gltf/json.h"
#include "scene/scene_files.h"

namespace parhelion {

// The compression of a buffer view, under either name; none: its bytes are as they are.
std::optional<JsonRef> meshopt_compression_of(const JsonRef& view);

// What `compression` makes of its compressed `bytes`: as many as the view is long; charged to `files` before. Throws Error for
// parameters that the extension forbids, damaged data, and codec versions that the library at hand does not know.
std::vector<std::byte> decode_meshopt(SceneFiles& files, const JsonRef& view, const JsonRef& compression, std::span<const std::byte> bytes);

}  // namespace parhelion
