#include "session/frame_hash.h"

#include "base/error.h"
#include "base/file.h"
#include "base/hash.h"
#include "image/decode.h"
#include "session/film_state.h"
#include "session/scene_setup.h"
#include "session/version.h"

namespace parhelion {

namespace {

constexpr uint64_t kMostBytes = uint64_t{4} << 30;     // of a frame's file
constexpr uint64_t kMostPixelBytes = uint64_t{4} << 8;  // of a decoded pixel: 256 channels, more than there are layers

void add_camera_path(Hasher& hasher, const std::filesystem::path& file) {
    if (!file.empty()) hasher.text(read_text_file(file, kMostBytes));
}

void add_output(Hasher& hasher, const RenderOptions& options) {
    hasher.add(options.output.exr_float).add(options.output.tonemap);
    for (const std::string& layer : options.aovs) hasher.text(layer);
    hasher.add(options.keep_noisy).add(options.reconstruction_layers);
}

}  // namespace

uint64_t hash_sequence(const RenderOptions& options, const Scene& scene, uint64_t settings_hash, std::string_view denoiser) {
    Hasher hasher;
    hasher.text(version()).add(settings_hash).add(hash_motion(scene));
    hasher.add(options.renderer).add(options.denoise).text(denoiser);
    hasher.add(options.samples.end);
    // What frame 0 does not show of the scene's clock and the camera.
    hasher.add(options.load.time).add(options.play.value().fps).add(options.shutter_seconds).text(options.load.animation).text(options.load.animate);
    hasher.text(options.camera).add(options.fov_degrees.value_or(0));
    add_camera_path(hasher, options.camera_path);
    hasher.add(options.exposure_ev.has_value()).add(options.exposure_ev.value_or(0));
    add_output(hasher, options);
    return hasher.value();
}

std::string frame_hash(uint64_t sequence, uint64_t frame, std::optional<uint64_t> preroll) {
    Hasher hasher;
    hasher.add(sequence).add(frame);
    if (preroll) hasher.add(*preroll);
    return fmt::format("{:016x}", hasher.value());
}

std::string read_frame_hash(const std::filesystem::path& file, Size2 size) {
    std::error_code ignored;
    if (!std::filesystem::exists(file, ignored)) return {};
    const uint64_t pixels = uint64_t{size.width} * size.height;
    const image::DecodeLimits limits{.max_width = size.width, .max_height = size.height, .max_pixels = pixels, .max_bytes = pixels * kMostPixelBytes};
    try {
        const image::Decoded decoded = image::decode_image(read_file(file, kMostBytes), limits, file.string());
        const image::Attributes& attributes = std::visit([](const auto& picture) -> const image::Attributes& { return picture.attributes; }, decoded);
        const auto found = attributes.find(kFrameAttribute);
        return found == attributes.end() ? std::string() : found->second;
    } catch (const Error&) {
        return {};
    }
}

}  // namespace parhelion
