// Rays that leave a surface never meet it again, at any size: `./dev soak` looks at a million.
#include "support/spawn_rays.h"

namespace parhelion::testing::spawn_test {
namespace {

class Spawn : public GpuTest {};

TEST_F(Spawn, rays_by_error_bounds_never_meet_their_own_triangle_and_start_near_it) {
    SpawnScene scene(1);
    for (const gpu::TraceWay way : kWays) {
        if (!device()->caps().supports(way)) continue;
        SpawnCounts counts;
        scene.count(way, 4, counts);
        const SpawnCounts::Decade all = counts.total();
        EXPECT_EQ(all.rays, 10000u);
        EXPECT_EQ(all.met[0], 0u) << gpu::trace_way_name(way) << '\n' << counts.met;
        EXPECT_LT(all.leaks[0], all.rays / 500) << gpu::trace_way_name(way);
        // The document's method starts rays of small things far away: its least step is 15 micrometres.
        EXPECT_GT(all.leaks[1], all.rays / 10) << gpu::trace_way_name(way);
    }
}

}  // namespace
}  // namespace parhelion::testing::spawn_test
