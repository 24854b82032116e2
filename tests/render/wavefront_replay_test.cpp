// The trace share of the wavefront: the replay traces the very rays that its kernels have just traced.
#include "renderers/replay.h"
#include "session/scene_setup.h"
#include "support/render_fixture.h"

namespace parhelion::testing::wavefront_replay_test {
namespace {

// What a tracing kernel left, and what the replay of its rays did.
struct Traced {
    passes::WavefrontTraced what;
    uint32_t list = 0;
    gpu::Buffer control, entries, hits, vertices, replayed;
};

class WavefrontReplay : public GpuTest {
protected:
    static ViewDesc desc(Stage& stage) {
        ViewDesc view{.width = 24, .height = 16, .max_bounces = 4};
        view.camera = shader_camera(view_of((*stage.scene.cameras().begin()).value, 1.5f), 1.5f);
        return view;
    }

    // The first rounds of a slice.
    static std::vector<Traced> trace(Stage& stage, gpu::TraceWay way, const WavefrontOptions& options) {
        View view(shared_device(), desc(stage));
        stage.scene_gpu.finish(stage.frame);
        Wavefront wavefront(shared_device(), options);
        std::vector<Traced> all;
        wavefront.after_trace = [&](const passes::WavefrontPass& pass, passes::WavefrontTraced what) {
            const uint64_t most = passes::most_rays(pass.state.shape, what);
            const gpu::Buffer dump(shared_device(), "test/dump", most * sizeof(shared::DumpedRay)), hits(shared_device(), "test/hits", most * sizeof(uint32_t));
            passes::dump_rays(pass, what, dump);
            passes::replay_rays(pass, what, dump, hits);
            const bool rays = what == passes::WavefrontTraced::Rays;
            all.push_back({.what = what,
                           .list = rays ? shared::kListRays : shared::kListShadows,
                           .control = pass.frame.read_back(pass.state.control),
                           .entries = pass.frame.read_back(rays ? pass.state.lists : pass.state.shadow_list),
                           .hits = pass.frame.read_back(pass.state.hits),
                           .vertices = pass.frame.read_back(pass.state.vertices),
                           .replayed = pass.frame.read_back(hits)});
        };
        wavefront.rounds_per_frame = 3;
        wavefront.start({.first_row = 0, .row_count = view.film().height, .first_sample = 0, .sample_count = 2});
        wavefront.record(stage.frame, stage.scene_gpu, way, view);
        stage.frame.run();
        return all;
    }

    static uint32_t count(const Traced& traced) { return traced.control.mapped_as<shared::WavefrontControl>().front().count[traced.list]; }

    static void expect_same_hits(const Traced& traced) {
        const auto entries = traced.entries.mapped_as<uint32_t>(), replayed = traced.replayed.mapped_as<uint32_t>();
        const auto hits = traced.hits.mapped_as<shared::WavefrontHit>();
        uint32_t differ = 0;
        for (uint32_t i = 0; i < count(traced); ++i) differ += replayed[i] != hits[entries[i]].primitive;
        EXPECT_EQ(differ, 0u) << "of " << count(traced);
    }

    // Light that was asked for is never nothing: what is left of it says whether the ray was free.
    // Returns how many were.
    static uint32_t expect_same_visibility(const Traced& traced) {
        const auto entries = traced.entries.mapped_as<uint32_t>(), replayed = traced.replayed.mapped_as<uint32_t>();
        const auto vertices = traced.vertices.mapped_as<shared::WavefrontVertex>();
        uint32_t differ = 0, free = 0;
        for (uint32_t i = 0; i < count(traced); ++i) {
            differ += (replayed[i] != 0) != (vertices[entries[i]].sampled != glm::vec3(0.0f));
            free += replayed[i];
        }
        EXPECT_EQ(differ, 0u) << "of " << count(traced);
        return free;
    }
};

}  // namespace

TEST_F(WavefrontReplay, it_meets_what_the_kernels_met) {
    Stage& stage = builtin_stage("builtin:cornell");
    for (const gpu::TraceWay way : kWays) {
        if (!device()->caps().supports(way)) continue;
        for (const bool once : {false, true}) {
            const WavefrontOptions options{.slots = 300,
                                           .connect = once ? ConnectWhen::Once : ConnectWhen::EachBounce,
                                           .dispatch = once ? WavefrontDispatch::Full : WavefrontDispatch::Indirect,
                                           .classes = !once};
            const std::vector<Traced> all = trace(stage, way, options);
            ASSERT_GE(all.size(), 6u);
            uint32_t rays = 0, shadow_rays = 0, free = 0;
            for (const Traced& traced : all) {
                SCOPED_TRACE(fmt::format("{} {} {}", trace_way_name(way), once, traced.list));
                rays += count(traced);
                if (traced.what == passes::WavefrontTraced::Rays) expect_same_hits(traced);
                else free += expect_same_visibility(traced), shadow_rays += count(traced);
            }
            EXPECT_GT(rays, shadow_rays + 600);  // with the camera's, two samples of 300 pixels at least
            EXPECT_TRUE(free > 0 && free < shadow_rays) << free << " of " << shadow_rays;
        }
    }
}

TEST_F(WavefrontReplay, its_shares_are_of_all_rays_of_the_slice) {
    if (device()->caps().timestamp_period_ns <= 0) GTEST_SKIP() << "no timestamps";
    Stage& stage = builtin_stage("builtin:cornell");
    View view(device(), desc(stage));
    const WavefrontTraceShares shares = measure_wavefront_trace_shares(device(), stage.scene_gpu, gpu::TraceWay::Compute, view, {.slots = 100}, 2, 1);
    EXPECT_GE(shares.extend.rays, 24u * 16 * 2);
    EXPECT_GT(shares.connect.rays, 0u);
    for (const TraceShare& share : {shares.extend, shares.connect}) {
        EXPECT_GT(share.pass_ms, 0.0);
        EXPECT_GT(share.replay_ms, 0.0);
        EXPECT_DOUBLE_EQ(share.share(), share.replay_ms / share.pass_ms);
    }
}

}  // namespace parhelion::testing::wavefront_replay_test
