#pragma once
// Which frames of a sequence are there already (`render --frames ... --resume`): every frame that is written says what it is a picture of.
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "scene/scene.h"
#include "session/render_options.h"

namespace parhelion {

// Of all that the frames of a sequence depend on, their numbers apart: version of the program, options, scene and what moves it.
// `settings_hash`: hash_render() of its frame 0, where `scene` stands. `denoiser`: version of the library that takes out noise; empty: none.
// No part of it, as of a checkpoint's identity: the device, its driver and the way to trace; where files lie; which frames are asked for.
uint64_t hash_sequence(const RenderOptions& options, const Scene& scene, uint64_t settings_hash, std::string_view denoiser);

// The value of kFrameAttribute. `preroll`: the realtime renderer drew so many frames before the first one, instead of all from frame 0
// on; none: it did, or frames do not depend on those before them.
std::string frame_hash(uint64_t sequence, uint64_t frame, std::optional<uint64_t> preroll);

// The kFrameAttribute that a picture carries, read whole to its end; empty: there is no such file, it is damaged, or of another size or origin.
std::string read_frame_hash(const std::filesystem::path& file, Size2 size);

}  // namespace parhelion
