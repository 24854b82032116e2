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

}  // namespace

TraceShare measure_trace_share(const gpu::DevicePtr& device, SceneGpu& scene, gpu::TraceWay way, View& view, uint32_t repeats) {
    if (device->caps().timestamp_period_ns <= 0) throw Error(ErrorCode::MissingFeature, "the device has no timestamps", device->caps().name);
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

}  // namespace parhelion
