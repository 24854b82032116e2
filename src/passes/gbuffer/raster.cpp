#include "passes/gbuffer/raster.h"

#include <algorithm>
#include <array>

#include "base/error.h"
#include "shared/hit.h"
#include "shared/raster.h"

namespace parhelion::passes {

namespace {

constexpr uint32_t kLevelsAtOnce = 6;  // that gbuffer/depth_pyramid makes of one
constexpr uint32_t kTile = 1u << kLevelsAtOnce;

struct CullPush {
    uint64_t view, drawn, pyramid, bits, counts;
    uint32_t row_count, second_pass, has_pyramid;
};
struct DrawListPush {
    uint64_t drawn, bits, draws, counts;
    uint32_t row_count, second_pass, begin[3];
};
struct PyramidPush {
    uint64_t pyramid, counts;
    uint32_t width, height, from;
};
struct VisiblePush {
    uint64_t view, drawn, counts;
    uint32_t frame_index;
};

uint64_t level_words(gpu::Extent extent, uint32_t level) {
    const auto side = [&](uint32_t s) { return (uint64_t(s) + (1u << level) - 1) >> level; };
    return side(extent.width) * side(extent.height);
}

// Levels come six at a time, those above the last full one too.
uint32_t level_count(gpu::Extent extent) {
    uint32_t levels = kLevelsAtOnce;
    while (level_words(extent, levels) > 1) levels += kLevelsAtOnce;
    return levels;
}

// One frame's passes, in order.
struct Recording {
    Frame& frame;
    const SceneGpu& scene;
    const gpu::Buffer& view;
    const gpu::Image& identity;
    RasterHistory& history;
    uint32_t frame_index;
    const DrawnGeometries& drawn;
    bool cleared = false;

    uint32_t rows() const { return drawn.begin[shared::kRasterKindCount]; }

    void make_room() {
        const gpu::DevicePtr& device = frame.device();
        const gpu::Extent extent = identity.extent();
        const auto room = [&](gpu::Buffer& buffer, const char* name, uint64_t bytes) {
            if (!buffer || buffer.bytes() != bytes) buffer = gpu::Buffer(device, name, bytes);
        };
        if (!history.depth || history.depth.extent() != extent) {
            history.depth = gpu::Image(device, "gbuffer/raster_depth", {.format = gpu::Format::Depth32Float, .extent = extent});
            history.pyramid = gpu::Buffer(device, "gbuffer/depth_pyramid", depth_pyramid_bytes(extent));
            history.reset();
        }
        room(history.bits, "gbuffer/drawn_bits", std::max<uint64_t>(2ull * rows() / 8, 4));
        room(history.draws, "gbuffer/draws", std::max<uint64_t>(2ull * rows(), 1) * sizeof(gpu::Draw));
        room(history.counts, "gbuffer/draw_counts", sizeof(shared::RasterCounts));
    }

    void make_list(bool second) {
        frame.compute("gbuffer/cull")
            .scene(scene.binding())
            .read("view", view)
            .read("drawn", drawn.table)
            .read("pyramid", history.pyramid)
            .read_write("bits", history.bits)
            .read_write("counts", history.counts)
            .push(CullPush{.row_count = rows(), .second_pass = second, .has_pyramid = history.has_pyramid})
            .over(rows());
        frame.compute("gbuffer/draw_list")
            .scene(scene.binding())
            .read("drawn", drawn.table)
            .read("bits", history.bits)
            .write("draws", history.draws)
            .write("counts", history.counts)
            .push(DrawListPush{.row_count = rows(), .second_pass = second, .begin = {drawn.begin[0], drawn.begin[1], drawn.begin[2]}})
            .over(rows());
    }

    Pass visible(uint32_t kind) {
        const gpu::RasterState state{.cull = kind == shared::kRasterOneSided ? gpu::Cull::Back : gpu::Cull::None, .depth_test = gpu::DepthTest::Nearer};
        const auto nothing = gpu::ClearColor::uints(shared::kHitMiss, 0, 0, 0);
        Pass pass = frame.raster("gbuffer/visible", state, kind == shared::kRasterAsked ? "+ASKED" : "");
        pass.scene(scene.binding())
            .read("view", view)
            .read("drawn", drawn.table)
            .read("counts", history.counts)
            .color("identity", identity, cleared ? std::nullopt : std::optional(nothing))
            .depth(history.depth, cleared ? std::nullopt : std::optional(0.0f))
            .push(VisiblePush{.frame_index = frame_index});
        cleared = true;
        return pass;
    }

    void draw(bool second) {
        for (uint32_t kind = 0; kind < shared::kRasterKindCount; ++kind) {
            if (drawn.count[kind] == 0) continue;
            const uint64_t first = (second ? rows() : 0) + drawn.begin[kind], count = (second ? shared::kRasterKindCount : 0) + kind;
            visible(kind).draw_indirect(history.draws, first * sizeof(gpu::Draw), history.counts, count * sizeof(uint32_t), drawn.count[kind]);
        }
    }

    void make_pyramid() {
        const gpu::Extent extent = identity.extent();
        const gpu::Sampler texels(frame.device(), {.wrap_u = gpu::Wrap::Clamp, .wrap_v = gpu::Wrap::Clamp, .mag = gpu::Filter::Nearest, .min = gpu::Filter::Nearest, .mip = gpu::Filter::Nearest});
        for (uint32_t from = 0; from < level_count(extent); from += kLevelsAtOnce) {
            const auto groups = [&](uint32_t side) { return (((side + (1u << from) - 1) >> from) + kTile - 1) / kTile; };
            Pass pass = frame.compute("gbuffer/depth_pyramid", from == 0 ? "" : "+FROM_LEVEL");
            if (from == 0) pass.sample("depth", history.depth, texels).write("pyramid", history.pyramid);
            else pass.read_write("pyramid", history.pyramid);
            pass.read("counts", history.counts).push(PyramidPush{.width = extent.width, .height = extent.height, .from = from}).over(16 * groups(extent.width), 16 * groups(extent.height));
        }
        history.has_pyramid = true;
    }
};

}  // namespace

uint64_t depth_pyramid_bytes(gpu::Extent extent) {
    uint64_t words = 1;
    for (uint32_t level = 1; level <= level_count(extent); ++level) words += level_words(extent, level);
    return words * sizeof(float);
}

void raster_identity(Frame& frame, const SceneGpu& scene, const Film& film, const gpu::Image& identity, RasterHistory& history, uint32_t frame_index,
                     const RasterOptions& options) {
    Recording r{frame, scene, film.view, identity, history, frame_index, scene.drawn()};
    r.make_room();
    if (!options.occlusion) history.reset();
    if (r.rows() == 0) return r.visible(shared::kRasterTwoSided).draw({});
    frame.fill(history.counts, 0);
    if (!frame.device()->caps().draw_indirect_count) frame.fill(history.draws, 0);  // what lies behind a list must be empty
    r.make_list(false);
    r.draw(false);
    if (!options.occlusion) return;
    r.make_pyramid();
    r.make_list(true);
    r.draw(true);
}

}  // namespace parhelion::passes
