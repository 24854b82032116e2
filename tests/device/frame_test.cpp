// Frame on a real device: passes by name, barriers found by itself, listings, full-barrier mode, device loss.
#include "frame/frame.h"

#include <numeric>

#include "base/error.h"
#include "support/gpu_fixture.h"

namespace parhelion::testing::frame_test {
namespace {

constexpr uint32_t kCount = 1000;

struct ImagePush {
    uint32_t width = 16, height = 16;
    float gain = 0.5f;
};
struct AddPush {
    uint64_t a = 0, c = 0;
    uint32_t count = kCount;
};
struct FillPush {
    uint64_t out_values = 0;
    uint32_t base = 0, count = kCount;
};
struct ArgsPush {
    uint64_t args = 0;
    uint32_t groups = 0;
};

class FrameTest : public GpuTest {
protected:
    // A frame with every kind of hazard: write -> read by address and binding, write after read, indirect arguments, images,
    // transfers in both directions. Returns what it computed.
    std::pair<std::vector<uint32_t>, std::vector<float>> run(Frame& frame) {
        const gpu::Buffer a = frame.buffer("test/a", kCount * 4), b = frame.buffer("test/b", kCount * 4), c = frame.buffer("test/c", kCount * 4);
        const gpu::Buffer args = frame.buffer("test/args", 12);
        frame.compute("device/frame_fill").write("out_values", a).push(FillPush{.base = 5}).over(kCount);
        frame.compute("device/frame_fill").write("out_values", b).push(FillPush{.base = 7}).over(kCount);
        frame.compute("device/frame_add").read("a", a).read("b", b).write("c", c).push(AddPush{}).over(kCount);
        frame.compute("device/frame_args").write("args", args).push(ArgsPush{.groups = (kCount + 63) / 64}).over(1);
        frame.compute("device/frame_add").read("a", c).read("b", b).write("c", a).push(AddPush{}).over_indirect(args, 0);
        gpu::Image first = frame.image("test/first", {16, 16}, gpu::Format::R32Float), second = frame.image("test/second", {16, 16}, gpu::Format::R32Float);
        std::vector<float> texels(256);
        std::iota(texels.begin(), texels.end(), 0.0f);
        frame.upload_image(first, std::as_bytes(std::span(texels)));
        for (int i = 0; i < 4; ++i) {
            frame.compute("device/frame_image").read("source", first).write("target", second).push(ImagePush{}).over(16, 16);
            std::swap(first, second);
        }
        const gpu::Buffer numbers = frame.read_back(a), image = frame.read_back(first);
        frame.run();
        const auto n = numbers.mapped_as<uint32_t>();
        const auto f = image.mapped_as<float>();
        return {{n.begin(), n.end()}, {f.begin(), f.end()}};
    }
};

}  // namespace

TEST_F(FrameTest, passes_read_what_earlier_passes_wrote) {
    Frame frame(device(), {}, test_shader_pack());
    const auto [numbers, image] = run(frame);
    for (uint32_t i = 0; i < kCount; ++i) ASSERT_EQ(numbers[i], (5 + i) + 2 * (7 + i)) << i;
    EXPECT_TRUE(frame.complaints().empty()) << frame.complaints().front();
    EXPECT_GT(image[255], 0.0f);
}

TEST_F(FrameTest, each_barrier_left_out_draws_a_complaint) {
    uint32_t barriers = 0;
    {
        Frame frame(device(), {}, test_shader_pack());
        run(frame);
        barriers = frame.barrier_count();
    }
    // Sum of two fills; indirect sum after the arguments; four blurs that change places after the upload; both read-backs at once.
    ASSERT_EQ(barriers, 7u);
    // Recording is enough: what a device makes of a missing barrier is its own affair, and the layers would rightly speak up.
    for (uint32_t skipped = 0; skipped < barriers; ++skipped) {
        const gpu::DevicePtr quiet = gpu::Device::open({});
        Frame frame(quiet, {.skip_barrier = static_cast<int>(skipped)}, test_shader_pack());
        run(frame);
        EXPECT_FALSE(frame.complaints().empty()) << "barrier " << skipped << " of " << barriers << " is not needed or not missed";
    }
}

// Two sums of which one is written over the other's source: apart there is a barrier between them, together there is none, and who reads both waits for both.
TEST_F(FrameTest, passes_together_have_one_barrier_before_all_and_none_between) {
    const auto barriers = [&](bool together, const FrameOptions& options) {
        const gpu::DevicePtr quiet = gpu::Device::open({});
        Frame frame(quiet, options, test_shader_pack());
        const gpu::Buffer a = frame.buffer("test/a", kCount * 4), b = frame.buffer("test/b", kCount * 4), c = frame.buffer("test/c", kCount * 4), d = frame.buffer("test/d", kCount * 4);
        frame.compute("device/frame_fill").write("out_values", a).push(FillPush{.base = 5}).over(kCount);
        frame.compute("device/frame_fill").write("out_values", b).push(FillPush{.base = 7}).over(kCount);
        const auto sums = [&] {
            frame.compute("device/frame_add").read("a", a).read("b", b).write("c", c).push(AddPush{}).over(kCount);
            frame.compute("device/frame_add").read("a", a).read("b", a).write("c", b).push(AddPush{}).over(kCount);
        };
        if (together) frame.together(sums);
        else sums();
        frame.compute("device/frame_add").read("a", b).read("b", c).write("c", d).push(AddPush{}).over(kCount);
        gpu::CommandList commands(quiet);
        frame.record(commands);
        return std::pair(frame.barrier_count(), frame.complaints());
    };
    using Complaints = std::vector<std::string>;
    EXPECT_EQ(barriers(false, {}), std::pair(3u, Complaints()));
    EXPECT_EQ(barriers(true, {}), std::pair(2u, Complaints()));
    EXPECT_EQ(barriers(true, {.skip_barrier = 1}).second.size(), 2u) << "both sums are missed";
}

TEST_F(FrameTest, what_a_pass_leaves_untouched_it_does_not_wait_for) {
    Frame frame(device(), {}, test_shader_pack());
    const gpu::Buffer a = frame.buffer("test/a", kCount * 4), b = frame.buffer("test/b", kCount * 4);
    frame.compute("device/frame_fill").write("out_values", a).push(FillPush{.base = 5}).over(kCount);
    frame.compute("device/frame_add").untouched("a", a).untouched("b", a).write("c", b).push(AddPush{.count = 0}).over(kCount);
    frame.run();
    EXPECT_EQ(frame.barrier_count(), 0u);
    EXPECT_TRUE(frame.complaints().empty());
}

TEST_F(FrameTest, full_barriers_change_nothing) {
    Frame plain(device(), {}, test_shader_pack()), full(device(), {.full_barriers = true}, test_shader_pack());
    EXPECT_EQ(run(plain), run(full));
}

TEST_F(FrameTest, names_are_checked_in_both_directions) {
    Frame frame(device(), {}, test_shader_pack());
    const gpu::Buffer a = frame.buffer("test/a", kCount * 4);
    EXPECT_THROW(frame.compute("device/frame_fill").push(FillPush{}).over(1), Error);                                         // not bound
    EXPECT_THROW(frame.compute("device/frame_fill").write("out_values", a).write("x", a).push(FillPush{}).over(1), Error);    // not declared
    EXPECT_THROW(frame.compute("device/frame_fill").read("out_values", a).push(FillPush{}).over(1), Error);                   // other access
    EXPECT_THROW(frame.compute("device/frame_fill").write("out_values", a).push(uint32_t{1}).over(1), Error);                       // push size
    EXPECT_THROW(frame.compute("device/no_such_pass"), Error);
    try {
        frame.compute("device/frame_fill").write("x", a).push(FillPush{}).over(1);
        FAIL();
    } catch (const Error& error) {
        const std::string text = error.what();
        EXPECT_NE(text.find("frame_fill"), std::string::npos) << text;
        EXPECT_NE(text.find("out_values"), std::string::npos) << text;
        EXPECT_NE(text.find("x"), std::string::npos) << text;
    }
}

TEST_F(FrameTest, the_listing_names_passes_reads_and_writes) {
    Frame frame(device(), {}, test_shader_pack());
    run(frame);
    ASSERT_GE(frame.passes().size(), 10u);
    EXPECT_EQ(frame.passes()[2].name, "device/frame_add");
    EXPECT_EQ(frame.passes()[2].reads, (std::vector<std::string>{"test/a", "test/b"}));
    EXPECT_EQ(frame.passes()[2].writes, std::vector<std::string>{"test/c"});
    EXPECT_EQ(frame.passes()[4].extent, "indirect");
    EXPECT_NE(frame.listing().find("device/frame_add"), std::string::npos);
    for (const PassInfo& pass : frame.passes()) EXPECT_GE(pass.gpu_ms, 0.0);
}

TEST_F(FrameTest, history_changes_places_every_frame_and_ends_on_reset_or_resize) {
    Frame frame(device(), {}, test_shader_pack());
    const auto step = [&](gpu::Extent extent) {
        const History<gpu::Image> history = frame.history("test/history", extent, gpu::Format::R32Float);
        frame.compute("device/frame_image").read("source", history.before).write("target", history.now).push(ImagePush{}).over(16, 16);
        frame.run();
        return history;
    };
    const auto first = step({16, 16}), second = step({16, 16});
    EXPECT_FALSE(first.valid);
    EXPECT_TRUE(second.valid);
    EXPECT_EQ(second.before.id(), first.now.id());
    EXPECT_FALSE(step({32, 32}).valid);
    EXPECT_TRUE(step({32, 32}).valid);
    frame.reset_history("test");
    EXPECT_FALSE(step({32, 32}).valid);
}

TEST_F(FrameTest, resources_are_kept_until_the_frame_is_done) {
    Frame frame(device(), {}, test_shader_pack());
    std::weak_ptr<gpu::Buffer::Data> watch;
    gpu::Ticket ticket = 0;
    {
        const gpu::Buffer temporary(device(), "test/temporary", kCount * 4);
        watch = temporary.data();
        frame.compute("device/frame_fill").write("out_values", temporary).push(FillPush{}).over(kCount);
        ticket = frame.submit();
    }
    EXPECT_FALSE(watch.expired());
    frame.wait(ticket);
    EXPECT_TRUE(watch.expired());
}

}  // namespace parhelion::testing::frame_test
