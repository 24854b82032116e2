// Pictures depend on samples alone: not on ranges, slices, barriers or what was drawn before.
#include <algorithm>
#include <bit>
#include <cmath>
#include <random>

#include "support/render_fixture.h"

namespace parhelion::testing::samples_test {
namespace {

class Samples : public GpuTest {
protected:
    static constexpr const char* kScene = "builtin:cornell";
    static Shot shot(uint32_t first, uint32_t count, uint32_t rows = 1u << 20, uint32_t samples = 64) {
        return {.view = {.width = 24, .height = 24, .max_bounces = 3, .aovs = {"normal", "variance", "depth", "ids", "motion"}}, .first_sample = first, .sample_count = count, .slice_rows = rows, .slice_samples = samples};
    }
};

TEST_F(Samples, parts_of_a_range_add_up_to_the_whole_bit_for_bit) {
    const image::FilmSums &a = builtin_film(kScene, shot(0, 64)), &b = builtin_film(kScene, shot(64, 64)), &whole = builtin_film(kScene, shot(0, 128));
    EXPECT_NE(a.limbs, b.limbs);
    const image::FilmPart parts[] = {{&b, "second"}, {&a, "first"}};
    EXPECT_EQ(image::merge_films(parts).limbs, whole.limbs);
    EXPECT_EQ(image::resolve_film(image::merge_films(parts)).exact, image::resolve_film(whole).exact);
}

// A device takes at least 65,535 work groups along one axis, no more: 2049 x 2048 pixels in a line of groups of 64 are too many.
TEST_F(Samples, a_block_of_more_than_four_million_pixels_is_added) {
    constexpr uint32_t kWidth = 2049, kHeight = 2048;
    const uint64_t plane = uint64_t{kWidth} * kHeight * sizeof(float);
    const passes::Film film{.block = gpu::Buffer(device(), "test/block", plane), .sums = gpu::Buffer(device(), "test/sums", 3 * plane), .width = kWidth, .height = kHeight, .channel_count = 1};
    Frame frame(device());
    frame.fill(film.sums, 0);
    frame.fill(film.block, std::bit_cast<uint32_t>(1.0f));
    passes::add_block(frame, film, {.first_row = 1, .row_count = kHeight - 1});
    frame.run();
    const std::vector<uint32_t> limbs = download<uint32_t>(film.sums);
    const size_t pixels = size_t{kWidth} * kHeight;
    for (const size_t first : {size_t{0}, 2 * pixels}) EXPECT_EQ(std::count(limbs.begin() + ptrdiff_t(first), limbs.begin() + ptrdiff_t(first + pixels), 0u), ptrdiff_t(pixels));
    for (size_t p = 0; p < pixels; ++p) ASSERT_EQ(limbs[pixels + p], p < kWidth ? 0u : 256u) << p;  // 1 is 2^40, 2^8 in the middle limb
}

// 16,384 blocks of 64 on the device, against integers. The second half is brighter by a hundredth, which a running mean in float no
// longer sees: a millionth of it is less than half a unit in the last place.
TEST_F(Samples, more_than_a_million_samples_add_up_exactly) {
    constexpr uint32_t kWidth = 8, kHeight = 2, kPixels = kWidth * kHeight, kBlocks = 16384, kBatch = 512;
    std::mt19937 random(11);
    std::vector<float> samples(size_t{kBlocks} * kPixels), blocks;  // all 64 samples of a block are alike
    for (size_t i = 0; i < samples.size(); ++i) samples[i] = (i < samples.size() / 2 ? 100.0f : 101.0f) + static_cast<float>(random() % 1024) / 4096.0f;
    for (const float sample : samples) blocks.push_back(64.0f * sample);
    const uint64_t plane = kPixels * sizeof(float);
    const gpu::Buffer bank(device(), "test/bank", kBatch * plane);
    const passes::Film film{.block = gpu::Buffer(device(), "test/block", plane), .sums = gpu::Buffer(device(), "test/sums", 3 * plane), .width = kWidth, .height = kHeight, .channel_count = 1};
    Frame frame(device());
    frame.fill(film.sums, 0);
    for (size_t first = 0; first < kBlocks; first += kBatch) {
        frame.upload(bank, 0, std::as_bytes(std::span(blocks).subspan(first * kPixels, kBatch * kPixels)));
        for (uint32_t i = 0; i < kBatch; ++i) {
            frame.copy(bank, i * plane, film.block, 0, plane);
            passes::add_block(frame, film, {.first_row = 0, .row_count = kHeight});
        }
        frame.run();
    }
    const std::vector<uint32_t> limbs = download<uint32_t>(film.sums);
    for (size_t p = 0; p < kPixels; ++p) {
        uint64_t expected = 0;  // in units of 2^-6, which all sums are multiples of
        float running = 0.0f;
        for (size_t b = 0; b < kBlocks; ++b) {
            expected += static_cast<uint64_t>(blocks[b * kPixels + p] * 64.0f);
            for (size_t s = 64 * b; s < 64 * (b + 1); ++s) running += (samples[b * kPixels + p] - running) / static_cast<float>(s + 1);
        }
        const image::Fixed96 found{limbs[p], limbs[kPixels + p], limbs[2 * kPixels + p]};
        const image::Fixed96 exact{static_cast<uint32_t>((expected << 34)), static_cast<uint32_t>(expected << 2), static_cast<uint32_t>(expected >> 30)};
        ASSERT_EQ(found, exact) << p;
        EXPECT_GT(std::abs(image::fixed_mean(found, 64 * kBlocks) - running), 0.1f) << p;
    }
}

TEST_F(Samples, rows_in_slices_draw_the_same_picture) {
    for (const uint32_t rows : {1u, 7u}) EXPECT_EQ(builtin_film(kScene, shot(0, 64, rows)).limbs, builtin_film(kScene, shot(0, 64)).limbs) << rows << " rows a slice";
}

TEST_F(Samples, samples_in_slices_draw_the_same_picture) {
    for (const uint32_t samples : {1u, 5u}) EXPECT_EQ(builtin_film(kScene, shot(0, 64, 64, samples)).limbs, builtin_film(kScene, shot(0, 64)).limbs) << samples << " samples a slice";
    EXPECT_EQ(builtin_film(kScene, shot(0, 64, 5, 7)).limbs, builtin_film(kScene, shot(0, 64)).limbs) << "rows and samples";
}

TEST_F(Samples, a_count_that_is_no_multiple_of_a_block_is_a_picture_too) {
    const image::FilmSums &whole = builtin_film(kScene, shot(0, 70)), &cut = builtin_film(kScene, shot(0, 70, 7, 9));
    EXPECT_EQ(whole.limbs, cut.limbs);
    // 70 = 64 + 6, each added exactly.
    const image::FilmSums &first = builtin_film(kScene, shot(0, 64)), &rest = builtin_film(kScene, shot(64, 6));
    const image::FilmPart parts[] = {{&first, "first"}, {&rest, "rest"}};
    EXPECT_EQ(image::merge_films(parts).limbs, whole.limbs);
}

TEST_F(Samples, another_seed_is_another_picture_of_the_same_mean) {
    Shot other = shot(0, 64);
    other.view.seed = 1;
    EXPECT_NE(builtin_film(kScene, other).limbs, builtin_film(kScene, shot(0, 64)).limbs);
    EXPECT_NEAR(mean_rgb(builtin_picture(kScene, other)) / mean_rgb(builtin_picture(kScene, shot(0, 64))), 1.0, 0.02);
}

TEST_F(Samples, full_barriers_change_nothing) {
    for (const gpu::TraceWay way : kWays) {
        if (!device()->caps().supports(way)) continue;
        Shot one = shot(0, 2);
        one.way = way;
        Stage full(make_builtin(kScene).scene, {}, {.full_barriers = true});
        EXPECT_EQ(full.render(one).limbs, builtin_film(kScene, one).limbs) << gpu::trace_way_name(way);
    }
}

// Recorded, not run: what a device makes of a missing barrier is its own affair.
TEST_F(Samples, each_barrier_of_the_renderer_left_out_draws_a_complaint) {
    const gpu::DevicePtr quiet = gpu::Device::open({});
    for (const gpu::TraceWay way : kWays) {
        if (!device()->caps().supports(way)) continue;
        const bool hardware = way != gpu::TraceWay::Compute;
        Shot one = shot(0, 1);
        one.way = way;
        const auto complaints = [&](int skipped, uint32_t& barriers) {
            Stage stage(make_builtin("builtin:textured").scene, {.hardware = hardware, .own_bvh = !hardware, .compact = false}, {.skip_barrier = skipped}, quiet);
            stage.record(one);
            barriers = stage.frame.barrier_count();
            return stage.frame.complaints().size();
        };
        uint32_t barriers = 0, ignored = 0;
        EXPECT_EQ(complaints(-1, barriers), 0u);
        EXPECT_GE(barriers, 2u);
        for (uint32_t skipped = 0; skipped < barriers; ++skipped)
            EXPECT_GT(complaints(static_cast<int>(skipped), ignored), 0u) << gpu::trace_way_name(way) << ": barrier " << skipped << " of " << barriers;
    }
}

}  // namespace
}  // namespace parhelion::testing::samples_test
