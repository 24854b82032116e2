#include "renderers/replay.h"

#include <algorithm>
#include <functional>

#include "base/error.h"
#include "renderers/reference.h"

namespace parhelion {

namespace {

double median_ms(Frame& frame, std::string_view pass, uint32_t repeats, const std::function<void()>& record) {
    std::vector<double> times;
    for (uint32_t i = 0; i <= repeats; ++i) {
        record();
        frame.run();
        for (const PassInfo& info : frame.passes())
            if (info.name == pass && i > 0) times.push_back(info.gpu_ms);
    }
    std::sort(times.begin(), times.end());
    return times.at(times.size() / 2);
}

void check_timers(const gpu::DevicePtr& device) {
    if (device->caps().timestamp_period_ns <= 0) throw Error(ErrorCode::MissingFeature, "the device has no timestamps", escape_name(device->caps().name));
}

// Adds the times of the frame that has run.
void add_times(WavefrontTraceShares& shares, const Frame& frame) {
    for (const PassInfo& pass : frame.passes()) {
        if (pass.name == "wavefront/extend") shares.extend.pass_ms += pass.gpu_ms;
        else if (pass.name.starts_with("wavefront/connect")) shares.connect.pass_ms += pass.gpu_ms;
        else if (pass.name == "wavefront/replay_rays") (pass.variant.ends_with("+SHADOWS") ? shares.connect : shares.extend).replay_ms += pass.gpu_ms;
    }
}

}  // namespace

TraceShare measure_trace_share(const gpu::DevicePtr& device, SceneGpu& scene, gpu::TraceWay way, View& view, uint32_t repeats) {
    check_timers(device);
    Frame frame(device);
    const passes::Film& film = view.film();
    const shared::Slice slice{.first_row = 0, .row_count = film.height, .first_sample = 0, .sample_count = 1};
    view.clear_film();
    const gpu::Buffer dump(device, "replay/dump", uint64_t(film.width) * film.height * shared::kMaxDumpedRays * sizeof(shared::DumpedRay));
    const gpu::Buffer hits(device, "replay/hits", uint64_t(film.width) * film.height * sizeof(uint32_t));
    scene.finish(frame);
    view.prepare(frame);
    frame.fill(dump, 0);
    passes::path_trace_dumping(frame, scene, way, film, slice, dump);
    frame.run();
    const RayCounts counts = view.read_rays(frame);
    TraceShare result{.rays = counts.path + counts.shadow};
    result.pass_ms = median_ms(frame, "reference/path_trace", repeats, [&] { passes::path_trace(frame, scene, way, film, slice, trace_options(view.desc())); });
    result.replay_ms = median_ms(frame, "reference/replay_rays", repeats, [&] { passes::replay_rays(frame, scene, way, dump, hits, film.width, film.height); });
    view.clear_film();
    return result;
}

WavefrontTraceShares measure_wavefront_trace_shares(const gpu::DevicePtr& device, SceneGpu& scene, gpu::TraceWay way, View& view, const WavefrontOptions& options,
                                                    uint32_t samples, uint32_t repeats) {
    check_timers(device);
    constexpr uint32_t kMostRounds = 24;  // so that every pass of a frame has timers
    Frame frame(device);
    scene.finish(frame);
    Wavefront wavefront(device, options);
    gpu::Buffer dump, hits;
    wavefront.after_trace = [&](const passes::WavefrontPass& pass, passes::WavefrontTraced what) {
        const uint64_t most = passes::most_rays(pass.state.shape, passes::WavefrontTraced::ShadowRays);
        if (!dump) {
            dump = gpu::Buffer(device, "replay/dump", most * sizeof(shared::DumpedRay));
            hits = gpu::Buffer(device, "replay/hits", most * sizeof(uint32_t));
        }
        passes::dump_rays(pass, what, dump);
        passes::replay_rays(pass, what, dump, hits);
    };
    WavefrontTraceShares sums;
    for (uint32_t i = 0; i <= repeats; ++i) {
        view.clear_film();
        wavefront.start({.first_row = 0, .row_count = view.film().height, .first_sample = 0, .sample_count = samples});
        for (bool finished = false; !finished;) {
            wavefront.rounds_per_frame = std::min(wavefront.rounds_per_frame, kMostRounds);
            wavefront.record(frame, scene, way, view);
            frame.run();
            if (i > 0) add_times(sums, frame);
            finished = wavefront.advance(frame.gpu_ms() / 1000);
        }
    }
    const RayCounts counts = view.read_rays(frame);
    view.clear_film();
    sums.extend.rays = counts.path;
    sums.connect.rays = counts.shadow;
    for (TraceShare* share : {&sums.extend, &sums.connect}) {
        share->pass_ms /= repeats;
        share->replay_ms /= repeats;
    }
    return sums;
}

}  // namespace parhelion
