// A million rays that leave triangles of every size, in each way to trace: where the compared spawn offsets fail, as numbers.
#include "support/spawn_rays.h"

namespace parhelion::testing::spawn_test {
namespace {

class SpawnMillion : public GpuTest {};

TEST_F(SpawnMillion, rays_by_error_bounds_never_meet_their_own_triangle) {
    std::map<gpu::TraceWay, SpawnCounts> counts;
    for (uint32_t seed = 0; seed < 100; ++seed) {
        SpawnScene scene(seed);
        for (const gpu::TraceWay way : kWays)
            if (device()->caps().supports(way)) scene.count(way, 4, counts[way]);
    }
    for (const auto& [way, sums] : counts) {
        sums.print(std::string(gpu::trace_way_name(way)).c_str());
        EXPECT_EQ(sums.total().rays, 1000000u);
        EXPECT_EQ(sums.total().met[0], 0u) << gpu::trace_way_name(way);
        EXPECT_GT(sums.total().met[1], 0u) << gpu::trace_way_name(way) << ": if the document's method fails nowhere, this tests nothing";
    }
}

}  // namespace
}  // namespace parhelion::testing::spawn_test
