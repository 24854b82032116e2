#include "passes/reference/reference.h"

namespace parhelion::passes {

namespace {

struct PathTracePush {
    uint64_t view, block;
    shared::Slice slice;
};

}  // namespace

void path_trace(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const Film& film, const shared::Slice& slice) {
    frame.trace("reference/path_trace", way)
        .scene(scene.binding())
        .read("view", film.view)
        .read_write("block", film.block)
        .push(PathTracePush{.slice = slice})
        .over(film.width, slice.row_count);
}

}  // namespace parhelion::passes
