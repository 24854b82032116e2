// Raster passes on a real device: what they cover, depth, culling, blending, scissors, draws from buffers, and their hazards.
#include <algorithm>
#include <array>
#include <cstdlib>

#include "base/error.h"
#include "frame/frame.h"
#include "gpu/internal.h"
#include "support/gpu_fixture.h"
#include "support/gpu_helpers.h"

namespace parhelion::testing::raster_test {
namespace {

constexpr uint32_t kSide = 16;
const gpu::ClearColor kBlack = gpu::ClearColor::floats(0, 0, 0, 0), kNobody = gpu::ClearColor::uints(~0u, ~0u, ~0u, ~0u);

struct Corner {
    float x, y, depth;
    std::array<float, 4> color;
};
struct FlatPush {
    uint64_t corners = 0;
    uint32_t gain = 1;
};
struct DrawsPush {
    uint64_t draws = 0, count = 0;
    uint32_t drawn = 0, room = 0;
};

// Counter-clockwise on the picture: the lower left half of the square [x0, x1] x [y0, y1] (y down).
std::vector<Corner> half(float x0, float y0, float x1, float y1, float depth, std::array<float, 4> color) {
    return {{x0, y0, depth, color}, {x0, y1, depth, color}, {x1, y1, depth, color}};
}
std::vector<Corner> square(float x0, float y0, float x1, float y1, float depth, std::array<float, 4> color) {
    std::vector<Corner> out = half(x0, y0, x1, y1, depth, color);
    out.insert(out.end(), {{x0, y0, depth, color}, {x1, y1, depth, color}, {x1, y0, depth, color}});
    return out;
}

struct Picture {
    std::vector<float> colors;    // rgba
    std::vector<uint32_t> rows;   // rgba
    std::vector<float> depth;
    uint32_t row(uint32_t x, uint32_t y) const { return rows[4 * (y * kSide + x)]; }
    std::array<float, 4> color(uint32_t x, uint32_t y) const {
        std::array<float, 4> out{};
        std::copy_n(colors.begin() + 4 * (y * kSide + x), 4, out.begin());
        return out;
    }
    friend bool operator==(const Picture&, const Picture&) = default;
};

class Raster : public GpuTest {
protected:
    void SetUp() override {
        GpuTest::SetUp();
        if (!IsSkipped() && !device()->caps().raster) GTEST_SKIP() << "this device does not rasterise";
    }
    gpu::Buffer corners(const gpu::DevicePtr& on, const std::vector<Corner>& list) {
        gpu::Buffer buffer(on, "test/corners", list.size() * sizeof(Corner), gpu::MemoryKind::Upload);
        std::copy(list.begin(), list.end(), buffer.mapped_as<Corner>().begin());
        return buffer;
    }
    // The pass without its draws, into the frame's images.
    Pass pass(Frame& frame, const gpu::Buffer& list, const gpu::RasterState& state, bool clear = true, gpu::Format rows = gpu::Format::Rgba32Uint) {
        Pass out = frame.raster("device/raster_flat", state);
        out.read("corners", list)
            .color("rows", frame.image("test/rows", {kSide, kSide}, rows), clear ? std::optional(kNobody) : std::nullopt)
            .color("colors", frame.image("test/colors", {kSide, kSide}, gpu::Format::Rgba32Float), clear ? std::optional(kBlack) : std::nullopt)
            .depth(frame.image("test/depth", {kSide, kSide}, gpu::Format::Depth32Float), clear ? std::optional(0.0f) : std::nullopt)
            .push(FlatPush{});
        return out;
    }
    Picture read(Frame& frame) {
        const gpu::Buffer rows = frame.read_back(frame.image("test/rows", {kSide, kSide}, gpu::Format::Rgba32Uint));
        const gpu::Buffer colors = frame.read_back(frame.image("test/colors", {kSide, kSide}, gpu::Format::Rgba32Float));
        const gpu::Buffer depth = frame.read_back(frame.image("test/depth", {kSide, kSide}, gpu::Format::Depth32Float));
        frame.run();
        const auto c = colors.mapped_as<float>(), d = depth.mapped_as<float>();
        const auto r = rows.mapped_as<uint32_t>();
        return {{c.begin(), c.end()}, {r.begin(), r.end()}, {d.begin(), d.end()}};
    }
    Picture draw(const std::vector<Corner>& list, const gpu::RasterState& state, const std::vector<DrawCall>& draws) {
        Frame frame(device(), {}, test_shader_pack());
        pass(frame, corners(device(), list), state).draw(draws);
        const Picture out = read(frame);
        EXPECT_TRUE(frame.complaints().empty()) << frame.complaints().front();
        return out;
    }
    // A list of draws made by a compute pass, drawn in two passes of which the second keeps what the first has drawn.
    Picture draw_lists(Frame& frame) {
        std::vector<Corner> list;
        for (uint32_t i = 0; i < 4; ++i) {
            const float x = -1.0f + 0.5f * static_cast<float>(i);
            const std::vector<Corner> one = half(x, -1, x + 0.5f, 1, 0.5f, {float(i), 0, 0, 1});
            list.insert(list.end(), one.begin(), one.end());
        }
        const gpu::Buffer triangles = corners(frame.device(), list), draws = frame.buffer("test/draws", 8 * 16), count = frame.buffer("test/count", 4);
        for (const bool first : {true, false}) {
            frame.compute("device/raster_draws").write("draws", draws).write("count", count).push(DrawsPush{.drawn = first ? 2u : 4u, .room = 8}).over(8);
            pass(frame, triangles, {.depth_test = gpu::DepthTest::Nearer}, first).draw_indirect(draws, 0, count, 0, 8);
        }
        return read(frame);
    }
};

}  // namespace

// A device that lacks this too, besides what is masked already.
gpu::DevicePtr open_without(const std::string& what) {
    const char* before = std::getenv("PARHELION_MASK");
    const std::string kept = before ? before : "";
    setenv("PARHELION_MASK", kept.empty() ? what.c_str() : (kept + "," + what).c_str(), 1);
    const gpu::DevicePtr device = gpu::Device::open({.validate = shared_device_validates()});
    if (before) setenv("PARHELION_MASK", kept.c_str(), 1);
    else unsetenv("PARHELION_MASK");
    return device;
}

TEST_F(Raster, a_triangle_covers_the_pixels_whose_centres_it_holds_with_y_down) {
    // Its diagonal runs through no pixel's centre.
    const Picture picture = draw(half(-1, -1.0625f, 1, 0.9375f, 0.25f, {0, 1, 0, 1}), {.depth_test = gpu::DepthTest::Nearer}, {{.draw = {.vertex_count = 3, .first_instance = 7}}});
    for (uint32_t y = 0; y < kSide; ++y)
        for (uint32_t x = 0; x < kSide; ++x) {
            const float px = (x + 0.5f) / (kSide / 2) - 1, py = (y + 0.5f) / (kSide / 2) - 1;
            const bool inside = py + 0.0625f > px && py < 0.9375f;
            ASSERT_EQ(picture.row(x, y), inside ? 7u : ~0u) << x << "," << y;
            ASSERT_EQ(picture.depth[y * kSide + x], inside ? 0.25f : 0.0f);
            ASSERT_EQ(picture.rows[4 * (y * kSide + x) + 1], inside ? 1u : ~0u);
        }
}

TEST_F(Raster, faces_are_culled_from_behind_only_where_that_is_asked_for) {
    std::vector<Corner> list = square(-1, -1, 1, 1, 0.5f, {1, 0, 0, 1});
    std::swap(list[3], list[4]);  // the upper right half is seen from behind
    const std::vector<DrawCall> draws = {{.draw = {.vertex_count = 6}}};
    const Picture culled = draw(list, {.cull = gpu::Cull::Back}, draws), all = draw(list, {}, draws);
    EXPECT_EQ(culled.row(2, 12), 0u);
    EXPECT_EQ(culled.row(12, 2), ~0u);
    EXPECT_EQ(all.row(12, 2), 0u);
    EXPECT_EQ(all.rows[4 * (2 * kSide + 12) + 1], 0u);
}

TEST_F(Raster, the_nearer_wins_in_any_order_and_the_first_of_equals) {
    std::vector<Corner> list = square(-1, -1, 1, 1, 0.25f, {1, 0, 0, 1});
    const std::vector<Corner> near = square(-1, -1, 0, 1, 0.5f, {0, 1, 0, 1}), equal = square(-1, -1, 1, 1, 0.25f, {0, 0, 1, 1});
    list.insert(list.end(), near.begin(), near.end());
    list.insert(list.end(), equal.begin(), equal.end());
    const auto call = [](uint32_t i) { return DrawCall{.draw = {.vertex_count = 6, .first_vertex = 6 * i, .first_instance = i}}; };
    const gpu::RasterState nearer{.depth_test = gpu::DepthTest::Nearer};
    const Picture picture = draw(list, nearer, {call(0), call(1), call(2)});
    EXPECT_EQ(picture.row(3, 3), 1u);
    EXPECT_EQ(picture.row(12, 3), 0u);
    EXPECT_EQ(draw(list, nearer, {call(1), call(0), call(2)}), picture);
    EXPECT_EQ(draw(list, {}, {call(1), call(0)}).row(3, 3), 0u);
}

TEST_F(Raster, blending_and_scissors_act_draw_by_draw) {
    std::vector<Corner> list = square(-1, -1, 1, 1, 0, {1, 0.5f, 0, 1});
    const std::vector<Corner> over = square(-1, -1, 1, 1, 0, {0, 1, 0, 0.25f});
    list.insert(list.end(), over.begin(), over.end());
    const std::vector<DrawCall> draws = {{.draw = {.vertex_count = 6}}, {.draw = {.vertex_count = 6, .first_vertex = 6}, .scissor = gpu::Rect{4, 2, 3, 100}}};
    // Integers cannot be blended: only colours are drawn here.
    Frame frame(device(), {}, test_shader_pack());
    const gpu::Buffer triangles = corners(device(), list);
    const gpu::Image first = frame.image("test/first", {kSide, kSide}, gpu::Format::Rgba32Float), second = frame.image("test/second", {kSide, kSide}, gpu::Format::Rgba32Float);
    for (const auto& [blend, image] : {std::pair(gpu::Blend::Alpha, first), std::pair(gpu::Blend::Premultiplied, second)})
        frame.raster("device/raster_flat", {.blend = blend}, "+COLOR_ONLY").read("corners", triangles).color("colors", image, kBlack).push(FlatPush{}).draw(draws);
    const gpu::Buffer a = frame.read_back(first), b = frame.read_back(second);
    frame.run();
    const auto at = [](const gpu::Buffer& buffer, uint32_t x, uint32_t y) {
        std::array<float, 4> out{};
        std::copy_n(buffer.mapped_as<float>().begin() + 4 * (y * kSide + x), 4, out.begin());
        return out;
    };
    using Color = std::array<float, 4>;
    EXPECT_EQ(at(a, 5, 8), (Color{0.75f, 0.625f, 0, 1}));
    EXPECT_EQ(at(b, 5, 8), (Color{0.75f, 1.375f, 0, 1}));
    for (const auto& [x, y] : {std::pair(3u, 8u), std::pair(7u, 8u), std::pair(5u, 1u)}) EXPECT_EQ(at(a, x, y), (Color{1, 0.5f, 0, 1})) << x << "," << y;
}

TEST_F(Raster, draws_come_from_buffers_as_many_as_they_say_with_or_without_the_devices_help) {
    Frame frame(device(), {}, test_shader_pack());
    const Picture picture = draw_lists(frame);
    EXPECT_TRUE(frame.complaints().empty()) << frame.complaints().front();
    for (uint32_t i = 0; i < 4; ++i) EXPECT_EQ(picture.row(4 * i, 15), 10 + i);
    const gpu::DevicePtr without = open_without("draw_count");
    EXPECT_FALSE(without->caps().draw_indirect_count);
    Frame other(without, {}, test_shader_pack());
    EXPECT_EQ(draw_lists(other), picture);
    EXPECT_EQ(without->validation_message_count(), 0u);
}

TEST_F(Raster, each_barrier_left_out_draws_a_complaint) {
    uint32_t barriers = 0;
    {
        Frame frame(device(), {}, test_shader_pack());
        draw_lists(frame);
        barriers = frame.barrier_count();
    }
    // The first list before its draws; the second after them; its draws after it and after the first pass; the read-backs of colours and depth.
    ASSERT_EQ(barriers, 5u);
    for (uint32_t skipped = 0; skipped < barriers; ++skipped) {
        const gpu::DevicePtr quiet = gpu::Device::open({});
        Frame frame(quiet, {.skip_barrier = static_cast<int>(skipped)}, test_shader_pack());
        draw_lists(frame);
        EXPECT_FALSE(frame.complaints().empty()) << "barrier " << skipped << " of " << barriers << " is not needed or not missed";
    }
    Frame full(device(), {.full_barriers = true}, test_shader_pack()), plain(device(), {}, test_shader_pack());
    EXPECT_EQ(draw_lists(full), draw_lists(plain));
}

TEST_F(Raster, the_listing_shows_what_is_drawn_into) {
    Frame frame(device(), {}, test_shader_pack());
    draw_lists(frame);
    const PassInfo &first = frame.passes().at(1), &second = frame.passes().at(3);
    EXPECT_EQ(first.name, "device/raster_flat");
    EXPECT_EQ(first.extent, "16x16");
    EXPECT_EQ(first.reads, (std::vector<std::string>{"test/corners", "test/draws", "test/count"}));
    EXPECT_EQ(first.writes, (std::vector<std::string>{"test/colors", "test/rows", "test/depth"}));
    EXPECT_EQ(second.reads, (std::vector<std::string>{"test/corners", "test/draws", "test/count", "test/colors", "test/rows", "test/depth"}));
}

TEST_F(Raster, outputs_and_resources_are_checked_by_name) {
    Frame frame(device(), {}, test_shader_pack());
    const gpu::Buffer list = corners(device(), half(-1, -1, 1, 1, 0, {1, 1, 1, 1}));
    const gpu::Image rows = frame.image("test/rows", {kSide, kSide}, gpu::Format::Rgba32Uint), colors = frame.image("test/colors", {kSide, kSide}, gpu::Format::Rgba32Float);
    const auto base = [&] { return frame.raster("device/raster_flat", {}); };
    EXPECT_NE(error_line([&] { base().read("corners", list).color("rows", rows).push(FlatPush{}).draw({}); }).find("colors, rows"), std::string::npos);
    EXPECT_THROW(base().read("corners", list).color("rows", rows).color("colors", colors).color("x", colors).push(FlatPush{}).draw({}), Error);
    EXPECT_THROW(base().color("rows", rows).color("colors", colors).push(FlatPush{}).draw({}), Error);                         // corners are missing
    EXPECT_THROW(base().read("corners", list).color("rows", rows).color("colors", colors).draw({}), Error);                     // push() is missing
    EXPECT_THROW(base().read("corners", list).color("rows", rows).color("colors", colors).push(FlatPush{}).over(1), Error);
    EXPECT_THROW(frame.raster("device/raster_flat", {.depth_test = gpu::DepthTest::Nearer}).read("corners", list).color("rows", rows).color("colors", colors).push(FlatPush{}).draw({}), Error);
    EXPECT_THROW(frame.raster("device/no_such_pass", {}), Error);
    EXPECT_NO_THROW(base().read("corners", list).color("rows", rows, kNobody).color("colors", colors, kBlack).push(FlatPush{}).draw({}));
}

TEST_F(Raster, a_device_without_it_says_so) {
    const gpu::DevicePtr without = open_without("raster");
    EXPECT_FALSE(without->caps().raster);
    EXPECT_FALSE(without->caps().draw_indirect_count);
    Frame frame(without, {}, test_shader_pack());
    EXPECT_EQ(error_of([&] { pass(frame, corners(without, half(-1, -1, 1, 1, 0, {1, 1, 1, 1})), {}).draw({}); }).code, ErrorCode::MissingFeature);
    EXPECT_EQ(without->validation_message_count(), 0u);
}

}  // namespace parhelion::testing::raster_test
