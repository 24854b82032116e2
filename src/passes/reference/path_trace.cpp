#include "passes/reference/reference.h"
#include "base/error.h"
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

void check_shading(const PathTraceOptions& options, bool pipeline) {
    if (!options.shade_in_hit) return;
    constexpr const char* setting = "reference.shade_in";
    if (!pipeline)
        throw Error(ErrorCode::Usage, "only the ray tracing pipeline can shade in closest-hit shaders", setting, "add --trace pipeline, or use reference.shade_in=raygen");
    if (options.ray_cones)
        throw Error(ErrorCode::Usage, "closest-hit shaders read textures at full resolution only", setting, "use texture.lod=full, or reference.shade_in=raygen");
}

void path_trace(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const Film& film, const shared::Slice& slice, const PathTraceOptions& options) {
    check_shading(options, way == gpu::TraceWay::Pipeline);
    frame.trace("reference/path_trace", way, variant(scene, options.shade_in_hit ? "+SHADE_IN_HIT" : options.ray_cones ? "+RAY_CONES" : ""))
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
