// A frame of an interactive session: the scene goes on, renderers draw, something is shown.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/error.h"
#include "base/log.h"
#include "renderers/reference.h"
#include "session/interactive.h"
#include "session/metering.h"
#include "session/scene_setup.h"

namespace parhelion {

namespace {

constexpr double kSecondsOfUnknownCpu = 0.6;  // a sample of a picture that nobody has measured yet
constexpr uint32_t kCoarsest = 8;             // pixels of the picture along the side of one of a preview
constexpr uint32_t kPreviewSamples = 8;       // of it, if nothing moves, before the picture itself is begun
// Whole frames while something moves: they may take so long, and are a quarter of the window's size each way at the coarsest.
constexpr double kMovingSeconds = 0.1;
constexpr uint32_t kMostShrink = 4;
constexpr std::chrono::milliseconds kComesToRest(500);

// How values of a layer are shown: light is exposed, what lies in [0, 1] is not, directions are moved there.
enum class LayerKind { Light, Share, Direction };
LayerKind layer_kind(const std::string& name) {
    if (name == "normal") return LayerKind::Direction;
    return name == "albedo" || name == "roughness" ? LayerKind::Share : LayerKind::Light;
}

// Passes of one name together, in order of their first.
std::vector<PassTime> sum_passes(const Frame& frame) {
    std::vector<PassTime> times;
    for (const PassInfo& pass : frame.passes()) {
        auto found = std::find_if(times.begin(), times.end(), [&](const PassTime& time) { return time.name == pass.name; });
        if (found == times.end()) found = times.insert(times.end(), PassTime{pass.name});
        found->ms += pass.gpu_ms;
        ++found->count;
    }
    return times;
}

}  // namespace

void Interactive::play_scene() {
    if (!loaded_ || !scene_gpu_) return;
    Scene& scene = loaded_->scene;
    ChangeSet changes = scene.begin_frame();
    if (play) seconds += std::min(frame_seconds_, 0.1);
    if (play || std::exchange(time_set_, false)) {
        changes.append(scene.apply(state_at(*loaded_, options_.load, seconds)));
        place_camera();
    }
    scene_gpu_->sync(scene, changes);
}

gpu::Image Interactive::record() {
    take_loaded();
    play_scene();
    if (!to_save_.empty() && samples() > 0 && shrink_ == 1 && drawer_->rows().rows_ahead == 0) write_picture();
    if (denoiser_) denoise();
    if (scene_gpu_) progress_ = scene_gpu_->update(*frame_);
    if (progress_.drawable) draw();
    if (!picture_) {
        picture_ = gpu::Image(device_, "view/nothing", {.format = gpu::Format::Rgba8Unorm, .extent = {1, 1, 1}});
        constexpr std::array<uint8_t, 4> kGrey{24, 24, 24, 255};
        frame_->upload_image(picture_, std::as_bytes(std::span(kGrey)));
    }
    const gpu::Image canvas = frame_->image("view/canvas", {options_.size.width, options_.size.height}, gpu::Format::Rgba8Unorm);
    if (shows_intermediate(canvas)) return canvas;
    if (split && beside_picture_) passes::split(*frame_, picture_, beside_picture_, canvas, static_cast<uint32_t>(std::lround(double(*split) * options_.size.width)));
    else frame_->scale(picture_, canvas);
    return canvas;
}

// True: one of the frame's images has taken the picture's place.
bool Interactive::shows_intermediate(const gpu::Image& canvas) {
    std::vector<gpu::Image> written = frame_->written_images();
    std::erase_if(written, [](const gpu::Image& image) { return image.name().starts_with("view/") || image.extent().depth != 1; });
    if (!written.empty() && drew_picture_) {
        images_.clear();
        for (const gpu::Image& image : written) images_.push_back(image.name());
        const auto found = std::ranges::find(written, shown_image, &gpu::Image::name);
        looked_at_ = found == written.end() ? gpu::Image() : *found;
    }
    if (shown_image.empty() || !looked_at_) return false;
    passes::look(*frame_, looked_at_, canvas, image_gain);
    return true;
}

bool Interactive::moves() const { return play || std::chrono::steady_clock::now() - moved_at_ < kComesToRest; }

// Where nothing moves and frames are slow, the picture leaves the device to the reference until that has had as much of its time: which comes
// sooner, and the window reacts sooner, too.
bool Interactive::picture_waits() const {
    if (!beside_ || beside_->is_finished() || moves() || is_picking() || is_saving() || fresh_ || !shown_image.empty() || drawer_->has_preview()) return false;
    return ahead_ > 0 && pixel_seconds_ * view_->desc().width * view_->desc().height > kMovingSeconds;
}

// A film of another size where whole frames take too long while something moves, and of the window's where nothing does.
void Interactive::adapt_size() {
    uint32_t wanted = 1;
    const bool must_be_whole = !to_save_.empty() || is_picking();
    const bool moving = moves();
    if (moving && !must_be_whole && !drawer_->has_preview()) {
        const double whole = pixel_seconds_ * options_.size.width * options_.size.height;
        wanted = std::clamp(static_cast<uint32_t>(std::ceil(std::sqrt(whole / kMovingSeconds))), 1u, kMostShrink);
    }
    const bool nearly = moving && !must_be_whole && wanted + 1 == shrink_;  // what is a little too coarse does not change to and fro
    if (wanted == shrink_ || nearly) return;
    shrink_ = wanted;
    set_up_view();
}

void Interactive::draw() {
    if (meter_ && progress_.complete) {
        show.exposure_ev = meter_scene(device_, *frame_, *scene_gpu_, trace_.way, view_->desc());
        meter_ = false;
        log(LogLevel::Info, "exposure EV100 {:.2f}, metered from the scene", show.exposure_ev);
    }
    adapt_size();
    if (std::exchange(version_, scene_gpu_->version()) != scene_gpu_->version()) clear();
    else if (!accumulate && !drawer_->has_preview()) clear_film();
    if (to_pick_ && progress_.complete) look_into_pixel();
    if (preview_samples_ == 0) preview_factor_ = preview_factor();
    if (preview_factor_ > 1 && preview_samples_ < kPreviewSamples) return draw_preview();
    drawer_->set_exposure(static_cast<float>(image::exposure_scale_from_ev100(show.exposure_ev)));
    drew_picture_ = !picture_waits();
    if (drew_picture_) drawer_->record(*frame_, *scene_gpu_, trace_.way, *view_);
    if (std::exchange(probes_frame_, false)) probe_.emplace(*frame_, *view_, drawer_->reservoirs(), picked_->pixel);
    if (drew_picture_ || show != shown_with_) show_picture();
    draw_beside();
}

void Interactive::show_picture() {
    if (denoiser_) take_denoised();
    // A newer noisy picture does not take its place: the next one without noise does.
    if (denoised_) {
        if (fresh_ || show != shown_with_) show_denoised();
        fresh_ = false;
        return;
    }
    // Until every pixel has a sample the preview is shown.
    if (const FilmRows rows = drawer_->rows(); rows.samples > 0 && is_due(rows)) {
        hdr_ = resolve_film(*view_, rows, "post/resolve.hdr");
        tone(hdr_, "view/picture", picture_);
        shown_rows_ = rows;
        fresh_ = false;
    }
}

void Interactive::draw_beside() {
    if (!split) return close_beside();
    if (!beside_) {
        ViewDesc desc = view_->desc();
        desc.aovs = layer_.empty() ? std::vector<std::string>{} : std::vector{layer_};
        const bool antialiased = options_.denoise == DenoiseKind::Builtin && settings_.reconstruction.antialias;
        if (antialiased) desc.filter = PixelFilter::Box;
        beside_ = std::make_unique<ReferenceBeside>(device_, desc, options_.samples.end);
    }
    beside_->record(*frame_, *scene_gpu_, trace_.way);
    const FilmRows rows = beside_->rows();
    if (rows.samples == 0) return;
    const gpu::Image hdr = resolve_film(beside_->view(), rows, "view/beside.hdr");
    tone(hdr, "view/beside", beside_picture_);
    const bool same_size = hdr_ && hdr_.extent() == hdr.extent();
    if (same_size && !fresh_ && layer_.empty() && beside_->wants_comparison(shown_rows_.samples)) beside_->read(*frame_, hdr_, hdr, shown_rows_.samples);
}

void Interactive::close_beside() {
    std::erase_if(left_, [](const std::future<Difference>& comparison) { return comparison.wait_for(std::chrono::seconds(0)) == std::future_status::ready; });
    if (beside_)
        if (std::future<Difference> comparison = beside_->take_comparison(); comparison.valid()) left_.push_back(std::move(comparison));
    beside_.reset();
    beside_picture_ = {};
    ahead_ = 0;
}

// The film begins anew for it, so that the realtime renderer's layers are of one frame.
void Interactive::look_into_pixel() {
    const glm::uvec2 pixel = glm::min(*std::exchange(to_pick_, std::nullopt), glm::uvec2(view_->desc().width, view_->desc().height) - 1u);
    picked_ = probe_pixel(*frame_, *scene_gpu_, trace_.way, view_->desc(), pixel);
    if (options_.renderer != RendererKind::Realtime || options_.upscale != 1) return;
    if (!std::exchange(probes_layers_, true)) replace_view();
    else clear_film();
    probes_frame_ = true;
}

// A picture that only gets better is not shown every time that it does: a CPU has more to do with its time.
bool Interactive::is_due(const FilmRows& rows) const {
    constexpr std::chrono::milliseconds kOften(200);
    if (fresh_ || show != shown_with_ || has_whole_frames()) return true;
    return rows != shown_rows_ && (rows.samples >= options_.samples.end || std::chrono::steady_clock::now() - shown_at_ >= kOften);
}

// How much coarser a picture must be to be drawn while a person waits.
uint32_t Interactive::preview_factor() const {
    if (!drawer_->has_preview()) return 1;
    double seconds_per_sample = drawer_->seconds_per_sample();
    if (seconds_per_sample == 0 && device_->caps().type == gpu::DeviceType::Cpu) seconds_per_sample = kSecondsOfUnknownCpu;
    const double factor = std::ceil(std::sqrt(seconds_per_sample / kDrawSeconds));
    return std::clamp(static_cast<uint32_t>(factor), 1u, kCoarsest);
}

void Interactive::draw_preview() {
    ViewDesc desc = view_->desc();
    desc.width = std::max(1u, desc.width / preview_factor_);
    desc.height = std::max(1u, desc.height / preview_factor_);
    if (!preview_ || preview_->desc().width != desc.width || preview_->desc().height != desc.height) preview_ = std::make_unique<View>(device_, desc);
    else if (preview_samples_ == 0) preview_->set_camera(desc.camera);
    record_reference(*frame_, *scene_gpu_, trace_.way, *preview_, {0, desc.height, preview_samples_++, 1}, false);
    hdr_ = resolve_film(*preview_, {.samples = preview_samples_}, "post/resolve.hdr");
    tone(hdr_, "view/picture", picture_);
}

// The film's mean as something to look at: in nits, or of a layer whatever that is.
gpu::Image Interactive::resolve_film(const View& view, const FilmRows& rows, const char* name) {
    const passes::Film& film = view.film();
    passes::Shown shown{.samples = rows.samples, .rows_ahead = rows.rows_ahead, .samples_ahead = rows.samples_ahead};
    if (!layer_.empty()) {
        const auto& channels = view.channels();
        const auto of_layer = [&](const std::string& channel) { return channel == layer_ || channel.starts_with(layer_ + "."); };
        const auto first = std::find_if(channels.begin(), channels.end(), of_layer);
        if (first != channels.end()) shown.first_channel = static_cast<uint32_t>(first - channels.begin());
        if (first != channels.end()) shown.channel_count = static_cast<uint32_t>(std::count_if(channels.begin(), channels.end(), of_layer));
    }
    if (layer_kind(layer_) == LayerKind::Direction) shown.gain = shown.bias = 0.5f;
    return passes::resolve(*frame_, film.sums, film.block, film.width, film.height, shown, name);
}

// As the display has it.
void Interactive::tone(const gpu::Image& hdr, const char* name, gpu::Image& picture) {
    const bool light = layer_kind(layer_) == LayerKind::Light;
    picture = frame_->image(name, hdr.extent(), gpu::Format::Rgba8Unorm);
    passes::tonemap(*frame_, hdr, picture, light ? static_cast<float>(image::exposure_scale_from_ev100(show.exposure_ev)) : 1.0f,
                    light ? static_cast<passes::ToneCurve>(show.curve) : passes::ToneCurve::Linear);
    shown_with_ = show;
    shown_at_ = std::chrono::steady_clock::now();
}

void Interactive::finish() {
    frame_->run();
    const auto now = std::chrono::steady_clock::now();
    frame_seconds_ = std::chrono::duration<double>(now - std::exchange(last_finish_, now)).count();
    std::vector<PassTime> passes = sum_passes(*frame_);
    measure(passes);
    if (drew_picture_) passes_ = std::move(passes);
    if (beside_) beside_->compare();
    if (!probe_) return;
    std::ranges::move(probe_->sections(*scene_gpu_), std::back_inserter(picked_->sections));
    probe_.reset();
}

// What the device worked at the picture, and at the reference beside it; not what the display takes its time for.
void Interactive::measure(const std::vector<PassTime>& passes) {
    double busy = 0, beside = 0;
    for (const PassTime& pass : passes) {
        if (pass.name == "transfer/show") continue;
        (beside_ && pass.name.starts_with("reference/") ? beside : busy) += pass.ms / 1000;
    }
    if (beside_) {
        if (options_.renderer == RendererKind::Reference) busy = beside /= 2;  // both trace alike
        beside_->ran(beside);
        if (drew_picture_) ahead_ += busy;
        ahead_ = std::max(0.0, ahead_ - beside);
    }
    if (!drawer_) return;
    drawer_->ran(busy > 0 ? busy : frame_seconds_);
    if (drawer_->has_preview() || !view_ || !drew_picture_) return;
    const double pixel = busy / (double(view_->desc().width) * view_->desc().height);
    pixel_seconds_ = pixel_seconds_ == 0 ? pixel : 0.5 * (pixel_seconds_ + pixel);
}

}  // namespace parhelion
