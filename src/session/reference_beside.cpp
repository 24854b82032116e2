#include "session/reference_beside.h"

#include "image/compare.h"
#include "renderers/reference.h"

namespace parhelion {

namespace {

image::ImageF planes_of(std::span<const glm::vec4> texels, uint32_t width, uint32_t height) {
    image::ImageF out = image::make_image(width, height, {"R", "G", "B"});
    for (int channel = 0; channel < 3; ++channel) {
        const auto plane = out.plane(static_cast<size_t>(channel));
        for (size_t i = 0; i < plane.size(); ++i) plane[i] = texels[i][channel];
    }
    return out;
}

Difference compare_pictures(const std::vector<glm::vec4>& shown, const std::vector<glm::vec4>& reference, uint32_t width, uint32_t height, Difference counts) {
    const image::Comparison result = image::compare_images(planes_of(shown, width, height), planes_of(reference, width, height));
    counts.mean_ratio = result.mean_ratio.luminance;
    counts.relmse = result.relmse;
    counts.flip = result.flip.mean;
    return counts;
}

}  // namespace

ReferenceBeside::ReferenceBeside(const gpu::DevicePtr& device, const ViewDesc& view, uint64_t max_samples)
    : view_(std::make_unique<View>(device, view)),
      drawer_(make_view_drawer(device, {.kind = RendererKind::Reference, .size = {view.width, view.height}, .max_samples = max_samples}, {})),
      max_samples_(max_samples) {}

void ReferenceBeside::set_camera(const shared::Camera& camera) {
    view_->set_camera(camera);
    clear();
}

void ReferenceBeside::clear() {
    view_->clear_film();
    drawer_->restart();
    ++generation_;
    reading_.reset();
    difference_.reset();
}

void ReferenceBeside::record(Frame& frame, const SceneGpu& scene, gpu::TraceWay way) { drawer_->record(frame, scene, way, *view_); }

bool ReferenceBeside::wants_comparison(uint64_t samples) const {
    constexpr std::chrono::seconds kOften(1);
    const uint64_t reference = rows().samples;
    const bool is_new = !difference_ || difference_->samples != samples || difference_->reference_samples != reference;
    return is_new && reference > 0 && !is_comparing() && std::chrono::steady_clock::now() - compared_at_ >= kOften;
}

void ReferenceBeside::read(Frame& frame, const gpu::Image& shown, const gpu::Image& reference, uint64_t samples) {
    reading_ = {.shown = frame.read_back(shown), .reference = frame.read_back(reference), .counts = {.samples = samples, .reference_samples = rows().samples}};
}

void ReferenceBeside::compare() {
    if (comparing_.valid() && comparing_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
        const Difference result = comparing_.get();
        if (compared_generation_ == generation_) difference_ = result;
        compared_at_ = std::chrono::steady_clock::now();
    }
    if (!reading_) return;
    const auto texels = [](const gpu::Buffer& buffer) {
        const auto mapped = buffer.mapped_as<glm::vec4>();
        return std::vector<glm::vec4>(mapped.begin(), mapped.end());
    };
    comparing_ = std::async(std::launch::async, compare_pictures, texels(reading_->shown), texels(reading_->reference), view_->desc().width, view_->desc().height, reading_->counts);
    compared_generation_ = generation_;
    reading_.reset();
}

}  // namespace parhelion
