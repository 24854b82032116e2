#include "session/reconstruction_layers.h"

#include <algorithm>
#include <bit>

#include <nlohmann/json.hpp>

#include "base/error.h"
#include "shared/realtime.h"

namespace parhelion {

using Json = nlohmann::ordered_json;

namespace {

Json vector_json(const glm::vec3& v) { return {v.x, v.y, v.z}; }

// Rows of the matrix that brings (x, y, z, 1) to clip space (Vulkan's: x right, y down). Depth is that of the G-buffer, kDepthNear over metres; of
// an orthographic camera, whose clip w is 1, metres.
Json clip_from_world(const shared::Camera& camera) {
    const auto row = [&](const glm::vec3& v) { return Json{v.x, v.y, v.z, -glm::dot(v, camera.position_ws)}; };
    const Json distance = row(camera.forward_ws), one{0, 0, 0, 1}, near{0, 0, 0, shared::kDepthNear};
    const bool flat = camera.orthographic != 0;
    return {row(camera.right_ws / glm::dot(camera.right_ws, camera.right_ws)), row(-camera.up_ws / glm::dot(camera.up_ws, camera.up_ws)), flat ? distance : near, flat ? one : distance};
}

Json camera_json(const shared::Camera& camera) {
    return {{"position", vector_json(camera.position_ws)},
            {"right", vector_json(camera.right_ws)},
            {"up", vector_json(camera.up_ws)},
            {"forward", vector_json(camera.forward_ws)},
            {"orthographic", camera.orthographic != 0},
            {"lens_radius", camera.lens_radius},
            {"focus_distance", camera.focus_distance},
            {"clip_from_world", clip_from_world(camera)}};
}

}  // namespace

Json input_json(const InputReadback& input) {
    return {{"layout", kReconstructionLayout},
            {"size", {input.size.width, input.size.height}},
            {"exposure", input.exposure},
            {"jitter_px", {input.jitter_px.x, input.jitter_px.y}},
            {"cut", input.cut},
            {"camera", camera_json(input.camera)},
            {"camera_before", camera_json(input.camera_before)}};
}

void add_reconstruction_layers(const InputReadback& input, image::ImageF& picture) {
    PARHELION_CHECK(picture.width == input.size.width && picture.height == input.size.height, "layers of {}x{} pixels for a picture of {}x{}", input.size.width, input.size.height, picture.width,
                    picture.height);
    for (size_t k = 0; k < input_planes().size(); ++k) {
        const auto& [channel, form] = input_planes()[k];
        const std::span<const uint32_t> words = input.plane(k);
        if (form == InputForm::Number) std::ranges::transform(words, picture.add_channel(std::string(channel)).begin(), [](uint32_t word) { return std::bit_cast<float>(word); });
        else picture.exact.push_back({.channel = std::string(channel), .whole = form == InputForm::Whole, .words = {words.begin(), words.end()}});
    }
    picture.attributes[kReconstructionAttribute] = input_json(input).dump();
}

}  // namespace parhelion
