#include "passes/reference/reference.h"
#include "shared/scene.h"

namespace parhelion::passes {

namespace {

struct PathTracePush {
    uint64_t view, block, rays;
    shared::Slice slice;
};
struct PathTraceDumpingPush {
    uint64_t view, block, rays, dump;
    shared::Slice slice;
};

// Only scenes that need the layered materials pay for them.
std::string variant(const SceneGpu& scene, std::string_view rest) {
    return ((scene.features() & shared::kSceneLayers) != 0 ? "+LAYERS" : "") + std::string(rest);
}

}  // namespace

void path_trace(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const Film& film, const shared::Slice& slice, bool ray_cones) {
    frame.trace("reference/path_trace", way, variant(scene, ray_cones ? "+RAY_CONES" : ""))
        .scene(scene.binding())
        .read("view", film.view)
        .read_write("block", film.block)
        .read_write("rays", film.rays)
        .push(PathTracePush{.slice = slice})
        .over(film.width, slice.row_count);
}

void path_trace_dumping(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const Film& film, const shared::Slice& slice, const gpu::Buffer& dump) {
    frame.trace("reference/path_trace", way, variant(scene, "+DUMP_RAYS"))
        .scene(scene.binding())
        .read("view", film.view)
        .read_write("block", film.block)
        .read_write("rays", film.rays)
        .write("dump", dump)
        .push(PathTraceDumpingPush{.slice = slice})
        .over(film.width, slice.row_count);
}

}  // namespace parhelion::passes
