// What `bench realtime` says of tracing: the replay traces the very rays that the frame has just traced.
#include "session/bench_realtime.h"
#include "support/realtime_player.h"

#include <nlohmann/json.hpp>

namespace parhelion::testing::realtime_replay_test {
namespace {

class RealtimeReplay : public GpuTest {
protected:
    void SetUp() override {
        GpuTest::SetUp();
        if (!IsSkipped() && !LightCache::supported(device()->caps())) GTEST_SKIP() << "no 64-bit atomics on buffers";
    }
};

// What a kernel traced, and the replay of it.
struct Traced {
    passes::WavefrontTraced what;
    gpu::Buffer control, entries, hits, replayed;
    uint32_t list() const { return what == passes::WavefrontTraced::Rays ? shared::kListRays : shared::kListShadows; }
    uint32_t count() const { return control.mapped_as<shared::WavefrontControl>().front().count[list()]; }
};

TEST_F(RealtimeReplay, it_meets_what_the_frame_met_and_has_all_its_rays) {
    Stage& stage = builtin_stage("builtin:cornell");
    const Shot shot{.way = gpu::TraceWay::Compute, .view = {.width = 24, .height = 24, .filter = PixelFilter::Point}};
    Player player(stage, shot, {.slots = 24 * 16});
    std::vector<Traced> all;
    player.realtime.after_trace = [&](const passes::WavefrontPass& pass, passes::WavefrontTraced what) {
        const uint64_t most = passes::most_rays(pass.state.shape, what);
        const gpu::Buffer dump(device(), "test/dump", most * sizeof(shared::DumpedRay)), hits(device(), "test/hits", most * sizeof(uint32_t));
        passes::dump_rays(pass, what, dump);
        passes::replay_rays(pass, what, dump, hits);
        const bool rays = what == passes::WavefrontTraced::Rays;
        all.push_back({.what = what,
                       .control = pass.frame.read_back(pass.state.control),
                       .entries = pass.frame.read_back(rays ? pass.state.lists : pass.state.shadow_list),
                       .hits = pass.frame.read_back(pass.state.hits),
                       .replayed = pass.frame.read_back(hits)});
    };
    player.next();
    const RayCounts counted = player.view.read_rays(stage.frame);
    RayCounts replayed;
    uint32_t differ = 0, free = 0;
    for (const Traced& traced : all) {
        const auto entries = traced.entries.mapped_as<uint32_t>(), seen = traced.replayed.mapped_as<uint32_t>();
        const bool rays = traced.what == passes::WavefrontTraced::Rays;
        (rays ? replayed.path : replayed.shadow) += traced.count();
        for (uint32_t i = 0; i < traced.count(); ++i)
            if (rays) differ += seen[i] != traced.hits.mapped_as<shared::WavefrontHit>()[entries[i]].primitive;
            else free += seen[i];
    }
    EXPECT_EQ(differ, 0u) << "of " << replayed.path;
    EXPECT_EQ(replayed.path, counted.path);
    EXPECT_EQ(replayed.shadow, counted.shadow);
    EXPECT_TRUE(free > 0 && free < replayed.shadow) << free;
}

TEST_F(RealtimeReplay, the_bench_says_what_share_of_a_frame_traces_and_what_its_rays_take_bare) {
    if (device()->caps().timestamp_period_ns <= 0) GTEST_SKIP() << "no timestamps";
    const RealtimeBenchOptions options{.scenes = {"builtin:cornell"}, .size = {32, 32}, .way = gpu::TraceWay::Compute, .warmup = 2, .frames = 4};
    const RealtimeBenchRow row = run_realtime_bench("builtin:cornell", options, device());
    EXPECT_GT(row.ms("wavefront/extend"), 0.0);
    EXPECT_EQ(row.ms("wavefront/replay"), 0.0) << "frames that are measured are not replayed";
    EXPECT_GT(row.bare_ms, 0.0);
    EXPECT_GT(row.trace_share(), 0.0);
    EXPECT_LT(row.trace_share(), 1.0);
    EXPECT_DOUBLE_EQ(row.over_bare(), row.frame_ms / row.bare_ms);
    EXPECT_NE(realtime_bench_table({row}, options).find("to bare"), std::string::npos);
    const auto json = realtime_bench_json({row}, options, device()->caps());
    EXPECT_DOUBLE_EQ(json["rows"][0]["trace_share"].get<double>(), row.trace_share());
    EXPECT_DOUBLE_EQ(json["rows"][0]["bare_ms"].get<double>(), row.bare_ms);
    EXPECT_DOUBLE_EQ(json["rows"][0]["over_bare"].get<double>(), row.over_bare());
}

TEST_F(RealtimeReplay, the_bench_does_not_draw_on_a_device_that_has_no_times_of_that) {
    const std::vector<std::string> words{"realtime", "--set", "gbuffer.mode=raster"};
    const OptionValues values = parse_options(Command::Bench, words, [](const char*) { return static_cast<const char*>(nullptr); });
    gpu::DeviceCaps caps;
    caps.type = gpu::DeviceType::Discrete;
    EXPECT_EQ(read_realtime_bench_options(values, caps).settings.gbuffer_mode, GBufferMode::Raster);
    caps.type = gpu::DeviceType::Cpu;
    EXPECT_THROW(read_realtime_bench_options(values, caps), Error);
}

}  // namespace
}  // namespace parhelion::testing::realtime_replay_test
