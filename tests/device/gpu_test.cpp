// The GPU layer on a real device: resources, programs, both hardware ways to trace, timers, errors.
#include <utility>
#include <cstring>

#include "gpu/internal.h"
#include "support/gpu_helpers.h"
#include "support/pack_writer.h"

namespace parhelion::testing::gpu_test {
namespace {

using namespace gpu;

void run(const DevicePtr& device, CommandList&& commands) { ASSERT_TRUE(wait(device, submit(device, std::move(commands)))); }

class GpuLayer : public GpuTest {};

TEST_F(GpuLayer, a_buffer_comes_back_as_it_was_copied) {
    const std::vector<uint32_t> values = numbers(1000);
    const Buffer from = mapped_buffer(device(), values), middle(device(), "test/middle", 4000), to(device(), "test/back", 4000, MemoryKind::Readback);
    EXPECT_EQ(middle.address() % 256, 0u);
    CommandList commands(device());
    commands.copy(from, 0, middle, 0, 4000);
    commands.barrier({{Use::TransferWrite}, {Use::TransferRead}});
    commands.copy(middle, 40, to, 0, 3960);
    commands.fill(to, 3960, 40, 7);
    run(device(), std::move(commands));
    EXPECT_EQ(to.mapped_as<uint32_t>()[0], 10u);
    EXPECT_EQ(to.mapped_as<uint32_t>()[989], 999u);
    EXPECT_EQ(to.mapped_as<uint32_t>()[990], 7u);
    CommandList wrong(device());
    EXPECT_THROW(wrong.copy(from, 8, to, 0, 4000), Error);
    EXPECT_THROW(wrong.fill(to, 2, 4, 0), Error);
}

TEST_F(GpuLayer, an_image_of_every_format_comes_back_as_it_was_copied) {
    for (uint32_t f = 1; f <= static_cast<uint32_t>(Format::Rgba32Uint); ++f) {
        const Format format = static_cast<Format>(f);
        const uint32_t row = 13 * format_bytes(format), bytes = row * 7;
        const Image image(device(), "test/image", {.format = format, .extent = {13, 7}});
        EXPECT_TRUE(image.needs_layout());
        std::vector<uint8_t> texels(bytes);
        for (uint32_t i = 0; i < bytes; ++i) texels[i] = static_cast<uint8_t>(i % 60);  // no NaN in any format
        const Buffer from = mapped_buffer(device(), texels), to(device(), "test/back", bytes, MemoryKind::Readback);
        CommandList commands(device());
        commands.initialise_layout(image);
        commands.copy_to_image(from, 0, image, 0, 0, 3);
        commands.initialise_layout(image);  // does nothing, or it would draw a message for want of a barrier
        commands.copy_to_image(from, uint64_t(row) * 3, image, 0, 3, 4);
        commands.barrier({{Use::TransferWrite}, {Use::TransferRead}});
        commands.copy_from_image(image, to, 0);
        run(device(), std::move(commands));
        EXPECT_FALSE(image.needs_layout());
        EXPECT_EQ(std::memcmp(to.mapped(), texels.data(), bytes), 0) << format_name(format);
    }
}

TEST_F(GpuLayer, a_transition_that_is_never_submitted_did_not_happen) {
    const Image image(device(), "test/image", {.extent = {4, 4}});
    {
        CommandList dropped(device());
        dropped.initialise_layout(image);
        EXPECT_FALSE(image.needs_layout());
    }
    EXPECT_TRUE(image.needs_layout());
}

TEST_F(GpuLayer, a_compute_program_reads_by_address_and_writes_buffer_and_image) {
    const std::vector<uint32_t> sums = add_on(device(), 1000);
    for (uint32_t i = 0; i < 1000; ++i) ASSERT_EQ(sums[i], i + 1000);
}

TEST_F(GpuLayer, programs_are_made_once_and_refuse_wrong_bindings) {
    const ShaderPack& pack = test_shader_pack();
    const Program program = Program::get(device(), pack, "device/gpu_add", "", false);
    EXPECT_EQ(program.data().get(), Program::get(device(), pack, "device/gpu_add", "", false).data().get());
    EXPECT_FALSE(program.uses_scene_set());
    EXPECT_TRUE(Program::get(device(), pack, "device/gpu_textures", "", false).uses_scene_set());
    EXPECT_NE(error_line([&] { Program::get(device(), pack, "device/nothing", "", false); }).find("device/nothing"), std::string::npos);

    const Buffer buffer(device(), "test/buffer", 64);
    const Image image(device(), "test/image", {.extent = {4, 4}}), half(device(), "test/half", {.format = Format::Rgba16Float, .extent = {4, 4}});
    const Binding b{0, BindingKind::StorageBuffer, buffer, {}}, i{1, BindingKind::StorageImage, image, {}}, wrong{1, BindingKind::StorageImage, half, {}};
    CommandList commands(device());
    const auto bind = [&](std::vector<Binding> bindings, size_t push_bytes) {
        const std::vector<std::byte> push(push_bytes);
        return error_line([&] { commands.bind(program, nullptr, bindings, push); });
    };
    EXPECT_NE(bind({b}, 16).find("bound 0 storage buffer; declared 0 storage buffer, 1 storage image"), std::string::npos) << bind({b}, 16);
    EXPECT_NE(bind({b, b}, 16).find("declared"), std::string::npos);
    EXPECT_NE(bind({b, i, {2, BindingKind::StorageBuffer, buffer, {}}}, 16).find("declared"), std::string::npos);
    EXPECT_NE(bind({b, wrong}, 16).find("declared rgba32f, image test/half is rgba16f"), std::string::npos) << bind({b, wrong}, 16);
    EXPECT_NE(bind({b, i}, 12).find("12 bytes of push constants"), std::string::npos);
    EXPECT_EQ(bind({b, i}, 16), "nothing was thrown");
    EXPECT_NE(error_line([&] { commands.trace(1, 1, 1); }).find("no ray tracing program is bound"), std::string::npos);
    EXPECT_NE(error_line([&] { commands.dispatch(1u << 31, 1, 1); }).find("work groups"), std::string::npos);
}

// A pipeline whose closest-hit shader is of the raygen's variant has all of them in it: they share a payload.
TEST_F(GpuLayer, hit_and_miss_shaders_are_of_the_raygens_variant_together_or_plain) {
    const auto pack = [](auto keeps) {
        std::vector<ShaderCode> shaders;
        for (const ShaderCode& shader : ShaderPack::builtin().all())
            if (keeps(shader)) shaders.push_back(shader);
        return ShaderPack(PackWriter().write(shaders));
    };
    const auto is_part = [](const ShaderCode& shader, std::string_view name) { return shader.name == name && shader.variant == "+SHADE_IN_HIT"; };
    const auto get = [&](const ShaderPack& from) { return error_line([&] { Program::get(device(), from, "reference/path_trace", "pipeline+SHADE_IN_HIT", true); }); };
    PARHELION_REQUIRE_WAY(TraceWay::Pipeline);
    for (const char* name : {"scene/miss", "scene/shadow_miss"}) {
        const std::string line = get(pack([&](const ShaderCode& shader) { return !is_part(shader, name); }));
        EXPECT_NE(line.find(fmt::format("there is no miss shader '{}' in variant '+SHADE_IN_HIT'", name)), std::string::npos) << line;
    }
    const std::string line = get(pack([&](const ShaderCode& shader) { return !(is_part(shader, "scene/hit") && shader.stage == Stage::AnyHit); }));
    EXPECT_NE(line.find("there is no any hit shader 'scene/hit' in variant '+SHADE_IN_HIT'"), std::string::npos) << line;

    // What shades sees the view at the address that raygen pushes; a raygen that pushes another thing first is refused.
    std::vector<ShaderCode> shaders(ShaderPack::builtin().all().begin(), ShaderPack::builtin().all().end());
    for (ShaderCode& shader : shaders)
        if (shader.name == "reference/path_trace" && shader.stage == Stage::Raygen)
            for (PushPointer& pointer : shader.push_pointers)
                if (pointer.name == "view") pointer.name = "another";
    const std::string mixed = get(ShaderPack(PackWriter().write(shaders)));
    EXPECT_NE(mixed.find("the push constants of reference/path_trace have no address 'view' at 0"), std::string::npos) << mixed;
}

TEST_F(GpuLayer, the_scene_set_holds_a_header_and_textures_and_mips_are_averages) {
    const Buffer header = mapped_buffer(device(), std::vector<uint32_t>{8}), out(device(), "test/texels", 8 * 16, MemoryKind::Readback);
    const Sampler sampler(device(), {}), same(device(), {}), nearest(device(), {.mag = Filter::Nearest, .min = Filter::Nearest});
    EXPECT_EQ(sampler.data().get(), same.data().get());
    EXPECT_NE(sampler.data().get(), nearest.data().get());
    SceneSet set(device(), "test/scene", 16);
    set.set_header(header);
    std::vector<Image> textures;
    std::vector<Buffer> texels;
    CommandList commands(device());
    for (uint32_t i = 0; i < 8; ++i) {
        textures.emplace_back(device(), "test/texture", ImageDesc{.extent = {1, 1}});
        texels.push_back(mapped_buffer(device(), std::vector<float>{float(i), 0, 0, 0}));
        commands.initialise_layout(textures[i]);
        commands.copy_to_image(texels[i], 0, textures[i], 0, 0, 1);
        set.set_texture(8 + i, textures[i], sampler);
    }
    const Image own(device(), "test/own", {.extent = {2, 2}, .mip_count = 2});
    const Buffer own_texels = mapped_buffer(device(), std::vector<float>{0, 100, 0, 0, 0, 200, 0, 0, 0, 300, 0, 0, 0, 400, 0, 0});
    commands.initialise_layout(own);
    commands.copy_to_image(own_texels, 0, own, 0, 0, 2);
    commands.barrier({{Use::TransferWrite}, {Use::TransferRead}});
    commands.blit_mip(own, 0);
    commands.barrier({{Use::TransferWrite}, {Use::ComputeSample}});
    const Binding bindings[] = {{0, BindingKind::SampledImage, own, nearest}, {1, BindingKind::StorageBuffer, out, {}}};
    const Program program = Program::get(device(), test_shader_pack(), "device/gpu_textures", "", false);
    EXPECT_THROW(commands.bind(program, nullptr, bindings, {}), Error);
    commands.bind(program, &set, bindings, {});
    commands.dispatch(1, 1, 1);
    run(device(), std::move(commands));
    for (uint32_t i = 0; i < 8; ++i) {
        EXPECT_FLOAT_EQ(out.mapped_as<float>()[4 * i], float(i));
        EXPECT_FLOAT_EQ(out.mapped_as<float>()[4 * i + 1], 250.0f);
    }
}

TEST_F(GpuLayer, timers_never_run_backwards) {
    if (device()->caps().timestamp_period_ns == 0) GTEST_SKIP() << "no timestamps";
    const TimerPool timers(device(), 8);
    const Buffer buffer(device(), "test/fill", 16 << 20);
    CommandList commands(device());
    commands.reset_timers(timers);
    for (uint32_t i = 0; i < 8; ++i) {
        commands.write_timer(timers, i);
        commands.barrier({{Use::TransferWrite}, {Use::TransferWrite}});
        commands.fill(buffer, 0, buffer.bytes(), i);
    }
    run(device(), std::move(commands));
    const std::vector<double> ms = timers.read_ms(8);
    EXPECT_EQ(ms[0], 0.0);
    for (size_t i = 1; i < ms.size(); ++i) EXPECT_GE(ms[i], ms[i - 1]);
    EXPECT_GT(ms.back(), 0.0);
    EXPECT_LT(ms.back(), 60e3);
}

TEST_F(GpuLayer, a_marker_tells_the_last_completed_command) {
    const Buffer marker(device(), "test/marker", 256, MemoryKind::Readback), buffer(device(), "test/fill", 4096);
    CommandList commands(device());
    for (uint32_t i = 1; i <= 3; ++i) {
        commands.barrier({{Use::TransferWrite}, {Use::TransferWrite}});
        commands.fill(buffer, 0, 4096, i);
        commands.write_marker(marker, 0);
        commands.write_marker(marker, i);
    }
    run(device(), std::move(commands));
    EXPECT_EQ(marker.mapped_as<uint32_t>()[0], 3u);
}

TEST_F(GpuLayer, command_lists_are_recycled) {
    for (int i = 0; i < 20; ++i) {
        CommandList commands(device());
        run(device(), std::move(commands));
    }
    EXPECT_LE(device()->impl().busy_slots.size() + device()->impl().free_slots.size(), 4u);
}

TEST_F(GpuLayer, memory_is_accounted_by_group_and_given_back) {
    const auto of_group = [&](std::string_view group) {
        for (const MemoryUse& use : device()->memory_use())
            if (use.group == group) return use.bytes;
        return uint64_t(0);
    };
    {
        const Buffer a(device(), "accounted/a", 1 << 20), b(device(), "accounted/b", 1 << 20, MemoryKind::Upload);
        const Image c(device(), "accounted/c", {.extent = {256, 256}});
        EXPECT_GE(of_group("accounted"), (2u << 20) + 256 * 256 * 16);
        EXPECT_LT(of_group("accounted"), 8u << 20);
    }
    EXPECT_EQ(of_group("accounted"), 0u);
}

TEST_F(GpuLayer, no_memory_is_an_error_with_name_and_bytes) {
    Device::Impl& impl = device()->impl();
    EXPECT_NE(error_line([&] { Buffer(device(), "scene/huge", 1ull << 50); }).find("scene/huge"), std::string::npos);
    const PFN_vkCreateBuffer create = impl.vk.vkCreateBuffer;
    impl.vk.vkCreateBuffer = [](VkDevice, const VkBufferCreateInfo*, const VkAllocationCallbacks*, VkBuffer*) { return VK_ERROR_OUT_OF_DEVICE_MEMORY; };
    const std::string line = error_line([&] { Buffer(device(), "scene/vertices", 12345); });
    impl.vk.vkCreateBuffer = create;
    EXPECT_NE(line.find("not enough memory for scene/vertices (12345 bytes)"), std::string::npos) << line;
    EXPECT_THROW(Buffer(device(), "scene/none", 0), Error);
    EXPECT_THROW(Image(device(), "scene/wide", {.extent = {1u << 20, 1}}), Error);
}

TEST_F(GpuLayer, a_lost_device_is_named_at_submit_and_at_wait) {
    const DevicePtr lost = Device::open({.selector = std::to_string(device()->caps().index)});
    Device::Impl& impl = lost->impl();
    const PFN_vkQueueSubmit2 submit_function = impl.vk.vkQueueSubmit2;
    impl.vk.vkQueueSubmit2 = [](VkQueue, uint32_t, const VkSubmitInfo2*, VkFence) { return VK_ERROR_DEVICE_LOST; };
    const std::string at_submit = error_line([&] { submit(lost, CommandList(lost)); });
    EXPECT_NE(at_submit.find(lost->caps().name + ": the device was lost"), std::string::npos) << at_submit;
    impl.vk.vkQueueSubmit2 = submit_function;
    const Ticket ticket = submit(lost, CommandList(lost));
    const PFN_vkWaitSemaphores wait_function = impl.vk.vkWaitSemaphores;
    impl.vk.vkWaitSemaphores = [](VkDevice, const VkSemaphoreWaitInfo*, uint64_t) { return VK_ERROR_DEVICE_LOST; };
    EXPECT_NE(error_line([&] { wait(lost, ticket); }).find("the device was lost"), std::string::npos);
    impl.vk.vkWaitSemaphores = wait_function;
    EXPECT_TRUE(wait(lost, ticket));
    EXPECT_TRUE(is_done(lost, ticket));
    EXPECT_FALSE(wait(lost, ticket + 1, 0.001));
}

// Four unit-square geometries of two triangles, side by side as instances 0 to 3; instance 3 is not opaque, and there the
// any-hit code lets the second triangle vanish.
class GpuTrace : public GpuTest {
protected:
    static constexpr uint32_t kWidth = 64, kHeight = 16;

    // Replaces the bottom levels by compacted copies.
    void compact() {
        const AccelSizes sizes(device(), 2);
        CommandList measure(device());
        measure.measure_blas(std::vector{solid_, holes_}, sizes);
        ASSERT_TRUE(wait(device(), submit(device(), std::move(measure))));
        const std::vector<uint64_t> bytes = sizes.read();
        ASSERT_EQ(bytes.size(), 2u);
        CommandList copy(device());
        AccelStruct* const built[] = {&solid_, &holes_};
        std::vector<AccelStruct> kept;
        for (size_t i = 0; i < 2; ++i) {
            EXPECT_GT(bytes[i], 0u);
            EXPECT_LE(bytes[i], built[i]->bytes());
            const AccelStruct small = AccelStruct::compacted(device(), "test/compacted", bytes[i]);
            copy.compact_blas(*built[i], small);
            kept.push_back(std::exchange(*built[i], small));
        }
        ASSERT_TRUE(wait(device(), submit(device(), std::move(copy))));
    }

    enum class Made { Built, Compacted, Refitted };

    // Replaces the bottom levels by ones that were built elsewhere and fitted to these geometries.
    void refit(const BlasGeometry& solid, const BlasGeometry& holes) {
        const Buffer elsewhere = mapped_buffer(device(), std::vector<float>{7, 0, 3, 8, 0, 3, 7, 1, 0, 6, 5, 0});
        CommandList commands(device());
        std::vector<BlasBuild> builds, refits;
        for (auto [blas, geometry] : {std::pair(&solid_, solid), std::pair(&holes_, holes)}) {
            *blas = AccelStruct::bottom(device(), "test/refitted", {&geometry, 1}, BlasClass::Deforming);
            BlasGeometry before = geometry;
            before.positions = elsewhere.address();
            builds.push_back({AccelStruct::bottom(device(), "test/rest", {&geometry, 1}, BlasClass::Deforming), {before}, {}});
            refits.push_back({*blas, {geometry}, builds.back().blas});
        }
        const Buffer scratch(device(), "test/scratch", 2 * std::max(solid_.scratch_bytes(), holes_.scratch_bytes()));
        commands.build_blas(builds, scratch);
        commands.full_barrier();
        commands.build_blas(refits, scratch);
        ASSERT_TRUE(wait(device(), submit(device(), std::move(commands))));
    }

    void build(Made made) {
        const std::vector<float> corners{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
        const Buffer positions = mapped_buffer(device(), corners), indices = mapped_buffer(device(), std::vector<uint32_t>{0, 1, 2, 1, 3, 2});
        const BlasGeometry solid{positions.address(), 4, indices.address(), 2, true};
        BlasGeometry holes = solid;
        holes.opaque = false;
        solid_ = AccelStruct::bottom(device(), "test/solid", {&solid, 1});
        holes_ = AccelStruct::bottom(device(), "test/holes", {&holes, 1});
        top_ = AccelStruct::top(device(), "test/top", 8);
        const Buffer scratch(device(), "test/scratch", solid_.scratch_bytes() + holes_.scratch_bytes() + top_.scratch_bytes());
        CommandList bottoms(device());
        const BlasBuild both[] = {{solid_, {solid}, {}}, {holes_, {holes}, {}}};
        bottoms.build_blas(both, scratch);
        ASSERT_TRUE(wait(device(), submit(device(), std::move(bottoms))));
        if (made == Made::Compacted) compact();
        if (made == Made::Refitted) refit(solid, holes);
        std::vector<TlasInstance> instances;
        for (uint32_t i = 0; i < 4; ++i)
            if (i != 2) instances.push_back({{0.25f, 0, 0, 0.25f * float(i), 0, 1, 0, 0, 0, 0, 1, 0}, i | 0xFFu << 24, kInstanceDisableCulling << 24, (i == 3 ? holes_ : solid_).address()});
        const Buffer list = mapped_buffer(device(), instances);
        CommandList commands(device());
        commands.build_tlas(top_, list, 0, static_cast<uint32_t>(instances.size()), scratch, 0);
        EXPECT_THROW(commands.build_tlas(top_, list, 0, 9, scratch, 0), Error);
        ASSERT_TRUE(wait(device(), submit(device(), std::move(commands))));
    }

    // What the rays of gpu_trace.trace must find: {instance * 100 + triangle or -1, free}.
    static std::pair<int, int> expected(uint32_t x, uint32_t y) {
        const uint32_t instance = x / 16;
        const float u = (float(x % 16) + 0.5f) / 16, v = (float(y) + 0.5f) / kHeight;
        const int triangle = u + v < 1 ? 0 : 1;
        if (instance == 2 || (instance == 3 && triangle == 1)) return {-1, 1};
        return {static_cast<int>(instance) * 100 + triangle, 0};
    }

    void trace(bool ray_tracing, bool indirect, Made made = Made::Built) {
        ASSERT_NO_FATAL_FAILURE(build(made));
        SceneSet set(device(), "test/scene", 0);
        set.set_accel(top_, top_);
        const Buffer hits(device(), "test/hits", kWidth * kHeight * 8, MemoryKind::Readback);
        const Buffer args = mapped_buffer(device(), ray_tracing ? std::vector<uint32_t>{0, kWidth, kHeight, 1} : std::vector<uint32_t>{0, kWidth / 8, kHeight / 8, 1});
        CommandList commands(device());
        const Program program = Program::get(device(), pack(), "device/gpu_trace", ray_tracing ? "pipeline" : "query", ray_tracing);
        const Binding binding{0, BindingKind::StorageBuffer, hits, {}};
        const uint32_t size[] = {kWidth, kHeight};
        commands.bind(program, &set, {&binding, 1}, std::as_bytes(std::span(size)));
        if (ray_tracing && indirect) commands.trace_indirect(args, 4);
        else if (ray_tracing) commands.trace(kWidth, kHeight, 1);
        else if (indirect) commands.dispatch_indirect(args, 4);
        else commands.dispatch(kWidth / 8, kHeight / 8, 1);
        ASSERT_TRUE(wait(device(), submit(device(), std::move(commands))));
        for (uint32_t y = 0; y < kHeight; ++y)
            for (uint32_t x = 0; x < kWidth; ++x) {
                if (x % 16 + y == 15) continue;  // on the diagonal either triangle is right
                const int* found = hits.mapped_as<int>().data() + 2 * (y * kWidth + x);
                ASSERT_EQ(std::pair(found[0], found[1]), expected(x, y)) << x << ' ' << y;
            }
    }

    // The test pack with its hit and miss shaders under the names of the scene's.
    static const ShaderPack& pack() {
        static const ShaderPack made = [] {
            std::vector<ShaderCode> shaders(test_shader_pack().all().begin(), test_shader_pack().all().end());
            for (ShaderCode& shader : shaders)
                for (const char* name : {"hit", "miss", "shadow_miss"})
                    if (shader.name == std::string("device/gpu_") + name) shader.name = std::string("scene/") + name;
            return ShaderPack(PackWriter().write(shaders));
        }();
        return made;
    }

    AccelStruct solid_, holes_, top_;
};

TEST_F(GpuTrace, ray_queries_find_the_triangles) {
    PARHELION_REQUIRE_WAY(TraceWay::Query);
    trace(false, false);
}

TEST_F(GpuTrace, indirect_ray_queries_find_the_triangles) {
    PARHELION_REQUIRE_WAY(TraceWay::Query);
    trace(false, true);
}

TEST_F(GpuTrace, a_ray_tracing_pipeline_finds_the_triangles) {
    PARHELION_REQUIRE_WAY(TraceWay::Pipeline);
    trace(true, false);
}

TEST_F(GpuTrace, compacted_bottom_levels_hold_the_same_triangles) {
    const bool query = device()->caps().ray_query;
    PARHELION_REQUIRE_WAY(query ? TraceWay::Query : TraceWay::Pipeline);
    trace(!query, false, Made::Compacted);
}

TEST_F(GpuTrace, refitted_bottom_levels_hold_the_triangles_where_they_are_now) {
    const bool query = device()->caps().ray_query;
    PARHELION_REQUIRE_WAY(query ? TraceWay::Query : TraceWay::Pipeline);
    trace(!query, false, Made::Refitted);
}

TEST_F(GpuTrace, an_indirect_ray_tracing_pipeline_finds_the_triangles) {
    PARHELION_REQUIRE_WAY(TraceWay::Pipeline);
    if (!device()->impl().physical.trace_indirect) GTEST_SKIP() << "no indirect trace";
    trace(true, true);
}

}  // namespace
}  // namespace parhelion::testing::gpu_test
