// Rays that leave a surface never meet it again, at any size: `./dev soak` looks at a million.
#include "support/spawn_rays.h"

namespace parhelion::testing {
namespace {

class Spawn : public GpuTest {};

TEST_F(Spawn, rays_by_error_bounds_never_meet_their_own_triangle_and_those_by_integers_do) {
    SpawnScene scene(1);
    for (const gpu::TraceWay way : kWays) {
        if (!device()->caps().supports(way)) continue;
        SpawnCounts counts;
        scene.count(way, 4, counts);
        const SpawnCounts::Decade all = counts.total();
        EXPECT_EQ(all.rays, 10000u);
        EXPECT_EQ(all.met[0], 0u) << gpu::trace_way_name(way);
        EXPECT_GT(all.met[1], 0u) << gpu::trace_way_name(way) << ": if the document's method fails nowhere, this test tests nothing";
        if (all.met[0] != 0) counts.print(gpu::trace_way_name(way).data());
    }
}

}  // namespace
}  // namespace parhelion::testing
