#include "renderers/reconstruction.h"

#include <algorithm>

#include "base/error.h"

namespace parhelion {

namespace {

constexpr uint32_t kMostSteps = 8;

// Halton 1964: digits of `index` behind the point.
float radical_inverse(uint32_t index, uint32_t base) {
    float value = 0.0f, digit = 1.0f;
    for (; index != 0; index /= base) {
        digit /= static_cast<float>(base);
        value += digit * static_cast<float>(index % base);
    }
    return value;
}

}  // namespace

Reconstruction::Reconstruction(const gpu::DevicePtr& device, gpu::Extent rendered, gpu::Extent picture, const ReconstructionOptions& options)
    : rendered_(rendered),
      options_(options),
      histories_{passes::make_reconstruction_history(device, rendered, picture), passes::make_reconstruction_history(device, rendered, picture)},
      normals_(device, "reconstruction/normals", sizeof(uint32_t) * rendered.width * rendered.height),
      sampler_(device, {.wrap_u = gpu::Wrap::Clamp, .wrap_v = gpu::Wrap::Clamp}) {
    if (options.history < 1 || static_cast<float>(options.history) > shared::kMostFrames || options.fast_history < 1 || options.steps > kMostSteps || !(options.kernel > 0))
        throw Error(ErrorCode::Usage, "a setting is out of range", "reconstruction.*", "`parhelion settings` lists the ranges");
}

// As many places as make an even pattern in each pixel of the picture.
glm::vec2 Reconstruction::jitter_px(uint32_t frame_index) const {
    if (!options_.antialias) return glm::vec2(0.0f);
    const gpu::Extent picture = histories_[0].picture.extent();
    const uint64_t pixels = uint64_t{picture.width} * picture.height, rendered = uint64_t{rendered_.width} * rendered_.height;
    const uint32_t places = static_cast<uint32_t>((16 * pixels + rendered - 1) / rendered), place = 1 + frame_index % places;
    return {radical_inverse(place, 2) - 0.5f, radical_inverse(place, 3) - 0.5f};
}

void Reconstruction::record(Frame& frame, const passes::ReconstructionInput& input, uint32_t frame_index) {
    const passes::ReconstructionPass pass{.frame = frame,
                                          .input = input,
                                          .before = histories_[1 - now_],
                                          .now = histories_[now_],
                                          .normals = normals_,
                                          .options = options_,
                                          .settings = {.jitter = input.jitter_px,
                                                       .jitter_before = jitter_before_px_,
                                                       .exposure_scale = input.exposure / exposure_before_,
                                                       .frame_index = frame_index,
                                                       .has_history = has_history_ && !input.cut ? 1u : 0u,
                                                       .history = options_.history,
                                                       .fast_history = options_.fast_history,
                                                       .firefly = options_.firefly,
                                                       .antilag = options_.antilag,
                                                       .clamp_width = options_.clamp_width,
                                                       .virtual_motion = options_.virtual_motion}};
    const gpu::Buffer verdicts = passes::judge_changes(pass);
    passes::accumulate_light(pass, verdicts);
    passes::settle_history(pass);
    const gpu::Buffer* colors = &passes::filter_light(pass, 0);
    for (uint32_t step = 1; step < options_.steps; ++step) colors = &passes::filter_light(pass, step);
    passes::antialias(pass, *colors, verdicts, sampler_);
    now_ = 1 - now_;
    has_history_ = true;
    jitter_before_px_ = input.jitter_px;
    exposure_before_ = input.exposure;
}

}  // namespace parhelion
