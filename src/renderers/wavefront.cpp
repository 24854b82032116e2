#include "renderers/wavefront.h"

#include <algorithm>

#include "base/error.h"
#include "shared/scene.h"

namespace parhelion {

namespace {

// More passes than these have no timers (Frame), and a frame of many empty rounds at the end of a slice is wasted.
constexpr uint32_t kMaxIterations = 32;

uint64_t sum(const std::array<uint64_t, shared::kClassCount>& counts) {
    uint64_t total = 0;
    for (const uint64_t count : counts) total += count;
    return total;
}

bool splits_light(const View& view) {
    return std::ranges::any_of(view.channels(), [](const std::string& channel) { return channel.starts_with("path."); });
}

bool keeps_first_hits(const View& view) {
    constexpr std::string_view kOfFirstHits[] = {"albedo", "normal", "emission", "roughness"};
    return std::ranges::any_of(view.channels(), [&](const std::string& channel) { return std::ranges::any_of(kOfFirstHits, [&](auto name) { return channel.starts_with(name); }); });
}

}  // namespace

uint64_t WavefrontStats::rays_at(size_t bounce) const { return sum(rays.at(bounce)); }
uint64_t WavefrontStats::shadows_at(size_t bounce) const { return sum(shadows.at(bounce)); }

Wavefront::Wavefront(gpu::DevicePtr device, const WavefrontOptions& options) : device_(std::move(device)), options_(options) {
    const gpu::DeviceCaps& caps = device_->caps();
    if (!caps.subgroup_ballot)
        throw Error(ErrorCode::MissingFeature, "the wavefront needs subgroup ballots in compute shaders, which the device lacks", escape_name(caps.name), "use --renderer reference");
    if (options_.slots > kMaxWavefrontSlots)
        throw Error(ErrorCode::Usage, fmt::format("{} are more than {}", options_.slots, kMaxWavefrontSlots), "wavefront.slots");
    if (options_.slots == 0) options_.slots = passes::usual_slots(caps);
}

passes::WavefrontShape Wavefront::shape(const SceneGpu& scene, const View& view) const {
    const bool layers = (scene.features() & shared::kSceneLayers) != 0, cones = view.desc().texture_lod == TextureLod::Cone;
    const uint64_t paths = slice_paths(view);
    passes::WavefrontShape shape{.slots = static_cast<uint32_t>(std::min<uint64_t>(options_.slots, paths)),
                                 .classes = options_.classes,
                                 .indirect = options_.dispatch == WavefrontDispatch::Indirect,
                                 .extra = layers || cones,
                                 .split = splits_light(view),
                                 .firsts = keeps_first_hits(view),
                                 .paths = paths};
    if (options_.connect == ConnectWhen::EachBounce) return shape;
    const uint64_t one = passes::state_bytes(shape);
    shape.round_length = 2;
    const uint64_t more = passes::state_bytes(shape) - one;  // for another vertex
    const uint64_t path_length = uint64_t{view.desc().max_bounces} + 1;
    shape.round_length = static_cast<uint32_t>(std::clamp<uint64_t>(options_.memory_bytes / (more * shape.slots), 1, std::min<uint64_t>(path_length, kMaxIterations)));
    return shape;
}

uint64_t Wavefront::slice_paths(const View& view) const {
    const uint64_t row = view.film().width, pixels = row * view.film().height;
    const uint64_t one = passes::sample_bytes({.split = splits_light(view), .firsts = keeps_first_hits(view)});
    return std::clamp(options_.sample_bytes / one, row, pixels * shared::kSamplesPerBlock);
}

void Wavefront::allocate(const SceneGpu& scene, const View& view) {
    const passes::WavefrontShape wanted = shape(scene, view);
    if (!state_.control || state_.shape != wanted) state_ = passes::make_wavefront_state(device_, wanted);
}

void Wavefront::start(const shared::Slice& slice) {
    PARHELION_CHECK(!slice_, "a slice is begun before the last one is finished");
    slice_ = slice;
    begun_ = false;
}

void Wavefront::begin(const passes::WavefrontPass& pass) {
    const shared::WavefrontControl control{.slice = *slice_,
                                           .pixel_count = pixels_,
                                           .slot_count = pass.slots,
                                           .shadow_capacity = options_.shadow_capacity != 0 ? options_.shadow_capacity : pass.slots * state_.shape.round_length,
                                           .split = state_.shape.split};
    pass.frame.upload(state_.control, 0, std::as_bytes(std::span(&control, 1)));
    passes::begin_wavefront(pass);
    begun_ = true;
}

void Wavefront::record_round(passes::WavefrontPass pass) {
    const bool classes = state_.shape.classes;
    for (pass.round = 0; pass.round < state_.shape.round_length; ++pass.round) {
        const bool round_begins = pass.round == 0, round_ends = pass.round + 1 == state_.shape.round_length;
        passes::generate(pass);
        passes::prepare_wavefront(pass, shared::kSizeOfRays | shared::kEmptyClasses | (round_begins ? shared::kEmptyShadows : 0));
        passes::extend(pass);
        if (after_trace) after_trace(pass, passes::WavefrontTraced::Rays);
        if (classes) {
            passes::sort_hits(pass);
            passes::prepare_wavefront(pass, shared::kSizeOfClasses);
        }
        passes::shade(pass);
        passes::prepare_wavefront(pass, shared::kEmptyRays | shared::kSizeOfShadows | (round_ends ? shared::kCountShadows : 0));
    }
    passes::connect(pass);
    if (after_trace) after_trace(pass, passes::WavefrontTraced::ShadowRays);
    passes::finalize(pass);
}

void Wavefront::record(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, View& view) {
    PARHELION_CHECK(slice_, "no slice is begun");
    if (!begun_) {
        begin_slice(frame, scene, way, view, *slice_);
        allocate(scene, view);
        pixels_ = view.film().width * slice_->row_count;
        paths_ = uint64_t{pixels_} * slice_->sample_count;
        PARHELION_CHECK(paths_ <= state_.shape.paths, "a slice of {} paths, beyond {}", paths_, state_.shape.paths);
    }
    const passes::WavefrontPass pass{.frame = frame,
                                     .scene = scene,
                                     .way = way,
                                     .film = view.film(),
                                     .state = state_,
                                     .ray_cones = view.desc().texture_lod == TextureLod::Cone,
                                     .slots = slots_in_use()};
    if (!begun_) begin(pass);
    const uint32_t rounds = std::clamp(rounds_per_frame, 1u, std::max(1u, kMaxIterations / state_.shape.round_length));
    for (uint32_t i = 0; i < rounds; ++i) record_round(pass);
    control_copy_ = frame.read_back(state_.control);
}

// A guess, so that few empty iterations are recorded at the end of a slice: as fast as paths began until now, then a few for the last ones.
uint64_t Wavefront::iterations_left(const shared::WavefrontControl& control) const {
    constexpr uint64_t kLast = 4;
    uint64_t begun = 0;
    for (const uint32_t rays : control.rays[0]) begun += rays;
    if (begun >= paths_ || begun == 0) return kLast;
    return kLast + (paths_ - begun) * control.iterations / begun;
}

bool Wavefront::advance(double seconds, double target_seconds) {
    const shared::WavefrontControl& control = control_copy_.mapped_as<shared::WavefrontControl>().front();
    constexpr std::string_view kNames[] = {"rays", "shadow rays", "misses", "emitters", "plain surfaces", "coated surfaces", "transmissive surfaces"};
    for (uint32_t list = 0; list < shared::kListCount; ++list)
        if (control.overflow[list] != 0)
            throw Error(ErrorCode::Failed, fmt::format("the wavefront's list of {} was too short for {} entries", kNames[list], control.overflow[list]), "--renderer wavefront",
                        "this is a mistake in the program; --renderer reference draws the same picture");
    const double wanted = rounds_per_frame * target_seconds / std::max(seconds, 1e-6);
    const double left = double(iterations_left(control)) / state_.shape.round_length;
    rounds_per_frame = static_cast<uint32_t>(std::max(1.0, std::min({wanted, 4.0 * rounds_per_frame, left})));
    if (control.live != 0) return false;

    for (size_t bounce = 0; bounce < shared::kCountedBounces; ++bounce)
        for (size_t c = 0; c < shared::kClassCount; ++c) {
            stats_.rays[bounce][c] += control.rays[bounce][c];
            stats_.shadows[bounce][c] += control.shadows[bounce][c];
        }
    stats_.iterations += control.iterations;
    stats_.slot_iterations += uint64_t{control.iterations} * slots_in_use();
    stats_.slots = slots_in_use();
    stats_.round_length = state_.shape.round_length;
    stats_.state_bytes = passes::state_bytes(state_.shape);
    slice_.reset();
    return true;
}

void Wavefront::finish(Frame& frame, const View& view) { passes::deposit(frame, state_, view.film(), pixels_); }

}  // namespace parhelion
