#include "passes/reference/reference.h"

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

}  // namespace

void path_trace(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const Film& film, const shared::Slice& slice, bool ray_cones) {
    frame.trace("reference/path_trace", way, ray_cones ? "+RAY_CONES" : "")
        .scene(scene.binding())
        .read("view", film.view)
        .read_write("block", film.block)
        .read_write("rays", film.rays)
        .push(PathTracePush{.slice = slice})
        .over(film.width, slice.row_count);
}

void path_trace_dumping(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const Film& film, const shared::Slice& slice, const gpu::Buffer& dump) {
    frame.trace("reference/path_trace", way, "+DUMP_RAYS")
        .scene(scene.binding())
        .read("view", film.view)
        .read_write("block", film.block)
        .read_write("rays", film.rays)
        .write("dump", dump)
        .push(PathTraceDumpingPush{.slice = slice})
        .over(film.width, slice.row_count);
}

}  // namespace parhelion::passes
