#include "passes/reference/reference.h"

namespace parhelion::passes {

namespace {

struct FirstHitPush {
    uint64_t view, hits;
    uint32_t first_row, row_count;
};

}  // namespace

void first_hit(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const Film& film, uint32_t first_row, uint32_t row_count) {
    frame.trace("reference/first_hit", way)
        .scene(scene.binding())
        .read("view", film.view)
        .write("hits", film.first_hits)
        .push(FirstHitPush{.first_row = first_row, .row_count = row_count})
        .over(film.width, row_count);
}

}  // namespace parhelion::passes
