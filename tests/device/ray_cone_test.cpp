// Levels of detail by ray cones against numbers worked out by hand.
#include <glm/glm.hpp>

#include "support/gpu_fixture.h"

namespace parhelion::testing::ray_cone_test {
namespace {

struct Query {
    float pixel_width = 0, pixel_spread = 1.0f / 512, t = 2, cosine = 1, area_uv = 1, area_ws = 1, side = 256, area_scale = 1, alpha = 0;
};

class RayCones : public GpuTest {
protected:
    std::vector<glm::vec2> ask(const std::vector<Query>& queries) {
        struct Push {
            uint64_t queries = 0, levels = 0;
            uint32_t count;
        };
        const gpu::Buffer input = upload<Query>("queries", queries), output(device(), "test/levels", queries.size() * sizeof(glm::vec2));
        Frame frame(device(), {}, test_shader_pack());
        const auto count = static_cast<uint32_t>(queries.size());
        frame.compute("device/ray_cone").read("queries", input).write("levels", output).push(Push{.count = count}).over(count);
        frame.run();
        return download<glm::vec2>(output);
    }
};

// A square metre with a texture of 256 x 256 texels: a texel is 1/256 m, a pixel at 2 m with a spread of 1/512 as well.
TEST_F(RayCones, a_texture_seen_one_to_one_is_level_zero_and_twice_as_far_one_more) {
    const auto levels = ask({{}, {.t = 4}, {.t = 8}, {.t = 1}, {.pixel_width = 1.0f / 256, .pixel_spread = 0, .t = 100}});
    EXPECT_NEAR(levels[0].x, 0.0f, 1e-4f);
    EXPECT_NEAR(levels[1].x, 1.0f, 1e-4f);
    EXPECT_NEAR(levels[2].x, 2.0f, 1e-4f);
    EXPECT_NEAR(levels[3].x, -1.0f, 1e-4f);  // magnified
    EXPECT_NEAR(levels[4].x, 0.0f, 1e-4f);   // orthographic: as wide everywhere
}

TEST_F(RayCones, slant_texels_repeats_and_size_of_the_triangle_count) {
    const auto levels = ask({{.cosine = 0.25f}, {.side = 1024}, {.area_scale = 16}, {.area_uv = 4}, {.area_ws = 4}, {.cosine = -0.5f}});
    EXPECT_NEAR(levels[0].x, 2.0f, 1e-4f);  // the footprint is four times as long
    EXPECT_NEAR(levels[1].x, 2.0f, 1e-4f);
    EXPECT_NEAR(levels[2].x, 2.0f, 1e-4f);  // repeated 4 x 4 times by the texture's transform
    EXPECT_NEAR(levels[3].x, 1.0f, 1e-4f);
    EXPECT_NEAR(levels[4].x, -1.0f, 1e-4f);
    EXPECT_NEAR(levels[5].x, 1.0f, 1e-4f);  // from behind
}

TEST_F(RayCones, a_lobe_widens_the_cone_by_its_roughness) {
    const auto spreads = ask({{.alpha = 0}, {.alpha = 0.1f}, {.alpha = 0.5f}, {.alpha = 1}});
    EXPECT_EQ(spreads[0].y, 0.0f);
    EXPECT_NEAR(spreads[1].y, 0.142134f, 1e-5f);  // 2 sqrt(0.005 / 0.99)
    EXPECT_NEAR(spreads[2].y, 0.816497f, 1e-5f);  // 2 sqrt(0.125 / 0.75)
    EXPECT_EQ(spreads[3].y, 1.0f);
}

}  // namespace
}  // namespace parhelion::testing::ray_cone_test
