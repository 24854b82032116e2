// What holds of every frame of the realtime renderer, whatever it draws: the same bits for the same command, no barrier too few, the same
// picture in every way to trace.
#include "base/error.h"
#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "support/process.h"
#include "support/realtime_player.h"

namespace parhelion::testing::realtime_machine_test {
namespace {

// Each kind of frame: traced and by raster, with the cache and without, with tiles and without, with each kind of reservoirs.
struct Kind {
    const char* name;
    GBufferMode gbuffer = GBufferMode::Trace;
    bool tiles = true, cache = true;
    RealtimeReuse reuse = RealtimeReuse::None;
    ReservoirSets sets = ReservoirSets::Unified;
};
constexpr Kind kTraced{"traced"}, kWithoutCache{"without cache", GBufferMode::Trace, true, false}, kRaster{"raster", GBufferMode::Raster};
constexpr Kind kReservoirs{"reservoirs", GBufferMode::Trace, true, true, RealtimeReuse::Full}, kUnbiased{"unbiased reservoirs", GBufferMode::Trace, true, false, RealtimeReuse::Unbiased};
constexpr Kind kKinds[] = {kTraced, kRaster, kWithoutCache, {"without tiles", GBufferMode::Raster, false, true}, kReservoirs, {"split reservoirs", GBufferMode::Trace, true, true, RealtimeReuse::Full, ReservoirSets::Split}, kUnbiased};

class RealtimeMachine : public GpuTest {
protected:
    bool has(const Kind& kind) const { return (!kind.cache || LightCache::supported(device()->caps())) && (kind.gbuffer != GBufferMode::Raster || device()->caps().raster); }
    static RealtimeOptions options(const Kind& kind) {
        return {.reuse = kind.reuse,
                .reuse_options = {.sets = kind.sets, .adapt_confidence = false},  // what few lights call for leaves the last frame out
                .gbuffer = kind.gbuffer,
                .tiles = kind.tiles,
                .cache = kind.cache,
                .cache_options = {.cells = 1u << 12}};
    }
    static Shot shot(gpu::TraceWay way, uint32_t size, uint32_t frames) {
        return {.way = way, .view = {.width = size, .height = size, .max_bounces = 4, .filter = PixelFilter::Point, .aovs = {"path.*"}}, .sample_count = frames};
    }
};

// Scenes of plain materials have one kernel of light, others two. Of a small cache, which is full and lets some of the cells wait.
TEST_F(RealtimeMachine, the_same_frames_have_the_same_bits_with_and_without_full_barriers) {
    for (const char* scene : {"builtin:cornell", "builtin:glass"})
        for (const Kind& kind : kKinds) {
            if (!has(kind) || (kind.name != kTraced.name && scene != std::string("builtin:cornell"))) continue;
            SCOPED_TRACE(fmt::format("{}, {}", scene, kind.name));
            std::vector<image::FilmSums> films;
            for (const bool full : {false, true}) {
                Stage stage(make_builtin(scene).scene, {.hardware = false, .raster = true}, {.full_barriers = full});
                films.push_back(stage.play(shot(gpu::TraceWay::Compute, 24, 4), options(kind)));
                EXPECT_TRUE(stage.frame.complaints().empty());
            }
            EXPECT_GT(mean_rgb(image::resolve_film(films[0])), 0.0);
            EXPECT_EQ(differing_words(films[0], films[1]), 0u);
        }
}

// The cache's update goes on beside the frame's first vertices, which do not ask it. In scenes of layered materials it has more steps.
TEST_F(RealtimeMachine, nobody_asks_the_cache_before_its_update_has_ended) {
    if (!has(kTraced)) GTEST_SKIP() << "no world cache";
    for (const char* scene : {"builtin:cornell", "builtin:glass"}) {
        SCOPED_TRACE(scene);
        Stage stage(make_builtin(scene).scene, {.hardware = false});
        Player(stage, shot(gpu::TraceWay::Compute, 16, 1), options(kTraced)).skip(1);
        const std::vector<PassInfo>& passes = stage.frame.passes();
        const auto ends = std::ranges::find(passes, "cache/blend", &PassInfo::name);
        const auto asks = [](const PassInfo& pass) { return !pass.name.starts_with("cache/") && std::ranges::find(pass.reads, "cache/cells") != pass.reads.end(); };
        const auto first = std::ranges::find_if(passes, asks);
        ASSERT_TRUE(ends != passes.end() && first != passes.end());
        EXPECT_LT(ends, first);
        EXPECT_TRUE(ends->group == 0 || ends->group != first->group) << "they run beside each other";
    }
}

// Recorded, not run: the first frame of a view and the one that follows, so that what one leaves to the next is in it. Paths of scenes with
// layered materials have many rounds, which are alike: of their barriers those of the first rounds and those after the last are left out.
TEST_F(RealtimeMachine, each_barrier_left_out_draws_a_complaint) {
    const gpu::DevicePtr quiet = gpu::Device::open({});
    const auto try_all = [&](const char* scene, const Kind& kind, uint32_t first, uint32_t last) {
        SCOPED_TRACE(fmt::format("{}, {}", scene, kind.name));
        Stage stage(make_builtin(scene).scene, {.hardware = false, .raster = true}, {}, quiet);
        stage.scene_gpu.finish(stage.frame);
        Shot small = shot(gpu::TraceWay::Compute, 16, 1);
        small.view.max_bounces = 1;
        const auto record = [&](int skipped) {
            Frame frame(quiet, {.skip_barrier = skipped}, joint_shader_pack());
            View view = stage.make_view(small);
            Realtime realtime(quiet, view, options(kind));
            for (int i = 0; i < 2; ++i) realtime.record(frame, stage.scene_gpu, small.way, view, true);
            gpu::CommandList commands(quiet);
            frame.retire(frame.record(commands));
            return std::pair(frame.barrier_count(), frame.complaints().size());
        };
        const auto [barriers, complaints] = record(-1);
        EXPECT_EQ(complaints, 0u);
        EXPECT_GE(barriers, 20u);
        for (uint32_t skipped = 0; skipped < barriers; ++skipped)
            if (skipped < first || skipped + last >= barriers) {
                EXPECT_GT(record(static_cast<int>(skipped)).second, 0u) << "barrier " << skipped << " of " << barriers;
            }
    };
    const Kind& all = has(kRaster) ? kRaster : kWithoutCache;
    try_all("builtin:cornell", all, ~0u, 0);
    if (has(kReservoirs)) try_all("builtin:cornell", kReservoirs, ~0u, 0);
    try_all("builtin:cornell", kUnbiased, ~0u, 0);
    try_all("builtin:glass", kWithoutCache, 16, 8);
    if (has(kTraced)) try_all("builtin:glass", kTraced, 32, 8);
}

// Frame 1 by pixels, the mean of what follows by itself: every way has the same random numbers, so means differ by next to nothing, and
// equality of expectations needs no repetition.
TEST_F(RealtimeMachine, every_way_to_trace_draws_the_same_frames) {
    for (const char* scene : {"builtin:cornell", "builtin:glass"})
        for (const Kind& kind : {kTraced, kWithoutCache, kReservoirs, kUnbiased}) {
            if (!has(kind) || ((kind.cache || kind.reuse != RealtimeReuse::None) && scene != std::string("builtin:cornell"))) continue;
            SCOPED_TRACE(fmt::format("{}, {}", scene, kind.name));
            Stage& stage = builtin_stage(scene);
            const auto draw = [&](gpu::TraceWay way, uint32_t first, uint32_t frames) {
                Shot own = shot(way, 32, frames);
                own.first_sample = first;
                return image::resolve_film(stage.play(own, options(kind)));
            };
            const image::ImageF first = draw(gpu::TraceWay::Compute, 0, 1), later = draw(gpu::TraceWay::Compute, 1, 7);
            for (const gpu::TraceWay way : {gpu::TraceWay::Query, gpu::TraceWay::Pipeline}) {
                if (!device()->caps().supports(way)) continue;
                EXPECT_GE(share_equal(draw(way, 0, 1), first), device()->caps().type == gpu::DeviceType::Cpu ? 0.99 : 0.97) << gpu::trace_way_name(way);
                EXPECT_NEAR(mean_rgb(draw(way, 1, 7)) / mean_rgb(later), 1.0, 1e-3) << gpu::trace_way_name(way);
            }
        }
}

// A ball that crosses the picture: the frame shows it where it is, whatever finds it. Outlines may differ (gbuffer/raster.glsl).
TEST_F(RealtimeMachine, raster_shows_what_moves_where_rays_find_it) {
    if (!device()->caps().raster) GTEST_SKIP() << "the device cannot draw";
    SceneEdit edit;
    const Handle<Material> white = edit.add(builtin::lambert("white", glm::vec3(0.7f)));
    const Handle<Node> pending = builtin::place_object(edit, "ball", make_sphere(0.5f, 12, true), white);
    edit.set_environment(Environment{.scale = glm::vec3(1.0f)});
    builtin::add_camera(edit, "front", {0.0f, 0.1f, 3.0f}, glm::vec3(0.0f), 0.9f);
    Scene scene;
    const Handle<Node> ball = scene.apply(std::move(edit)).resolve(pending);
    std::vector<image::ImageF> pictures[2];
    for (const bool raster : {false, true}) {
        Stage stage(scene, {.hardware = false, .raster = true});
        Player player(stage, shot(gpu::TraceWay::Compute, 32, 1), {.gbuffer = raster ? GBufferMode::Raster : GBufferMode::Trace, .cache = false});
        for (int frame = 0; frame < 4; ++frame) {
            SceneEdit step;
            step.set_transform(ball, {.translation = {0.5f * float(frame) - 0.8f, 0.0f, 0.0f}});
            pictures[raster].push_back(player.next(std::move(step)));
        }
    }
    for (size_t frame = 0; frame < 4; ++frame) EXPECT_GE(share_equal(pictures[1][frame], pictures[0][frame]), 0.99) << frame;
}

// As CliRender.the_number_of_threads_changes_no_bit.
TEST_F(RealtimeMachine, the_number_of_threads_changes_no_bit) {
    const std::vector<std::vector<std::string>> kinds{{"realtime.reuse=none"}, {"realtime.reuse=full", "realtime.adapt_confidence=off"}, {"realtime.reuse=unbiased", "realtime.cache=off"}};
    for (const std::vector<std::string>& kind : kinds) {
        SCOPED_TRACE(kind[0]);
        TemporaryFolder folder;
        std::vector<std::string> command{"render", "builtin:cornell", "--renderer", "realtime", "--size", "40x24", "--frames", "4", "--trace", "compute", "--exposure", "3", "--out", "a.exr"};
        for (const std::string& setting : kind) command.insert(command.end(), {"--set", setting});
        std::string of_one_thread;
        for (const char* threads : {"0", "2", "7"}) {
            const ProcessResult result = run_parhelion(command, {.environment = {{"LP_NUM_THREADS", threads}}, .folder = folder.path()});
            ASSERT_EQ(result.exit_code, 0) << result.err;
            const std::string bytes = read_bytes(folder.path() / "a.exr");
            EXPECT_GT(bytes.size(), 1000u);
            if (of_one_thread.empty()) of_one_thread = bytes;
            EXPECT_TRUE(bytes == of_one_thread) << threads << " threads";
        }
    }
}

}  // namespace
}  // namespace parhelion::testing::realtime_machine_test
