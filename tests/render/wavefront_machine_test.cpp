// The wavefront's pictures depend on samples alone: not on how its machine is built, how many paths it holds, or how a job is cut.
// What it counts is what happened.
#include <algorithm>

#include "base/error.h"
#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "support/render_fixture.h"

namespace parhelion::testing::wavefront_machine_test {
namespace {

constexpr uint32_t kSize = 20;
constexpr uint32_t kClassOfStrip[] = {shared::kClassPlain, shared::kClassCoated, shared::kClassTransmissive, shared::kClassEmitter, shared::kClassMiss};
const std::vector<std::string> kSplit{"normal", "path.*", "variance"};

struct Variant {
    const char* name;
    WavefrontOptions options;
    uint32_t rounds = 8;
    bool same_kernels = true;  // as the first variant's
};
constexpr uint64_t kSlotBytes = 200;  // for a vertex that waits for Connect, a little more than it takes
const Variant kVariants[] = {
    {"each bounce", {.connect = ConnectWhen::EachBounce}},
    {"each bounce, a round a frame", {.connect = ConnectWhen::EachBounce}, 1},
    {"once", {.connect = ConnectWhen::Once}},
    {"once, little memory", {.slots = kSize * kSize, .connect = ConnectWhen::Once, .memory_bytes = 3 * kSlotBytes * kSize * kSize}},
    {"once, no memory", {.connect = ConnectWhen::Once, .memory_bytes = 1}},
    {"full-size dispatch", {.connect = ConnectWhen::EachBounce, .dispatch = WavefrontDispatch::Full}},
    {"once, full-size dispatch", {.connect = ConnectWhen::Once, .dispatch = WavefrontDispatch::Full}},
    {"no classes", {.connect = ConnectWhen::EachBounce, .classes = false}, 8, false},
    {"once, full-size dispatch, no classes", {.connect = ConnectWhen::Once, .dispatch = WavefrontDispatch::Full, .classes = false}, 8, false},
    {"37 slots", {.slots = 37, .connect = ConnectWhen::EachBounce}},
    {"37 slots, once", {.slots = 37, .connect = ConnectWhen::Once}},
    {"37 slots, once, little memory, no classes", {.slots = 37, .connect = ConnectWhen::Once, .classes = false, .memory_bytes = 3 * kSlotBytes * 37}, 3, false},
    {"9973 slots, full-size dispatch", {.slots = 9973, .connect = ConnectWhen::EachBounce, .dispatch = WavefrontDispatch::Full}},
};

class WavefrontMachine : public GpuTest {
protected:
    // Strips of one class of materials each and a gap, a fifth of the picture, on the ground under a ceiling with a lamp between them.
    static Stage& strips() {
        shared_device();  // outlives the stage
        static Stage stage([] {
            std::vector<Material> materials(4, builtin::glossy("plain", glm::vec3(0.7f, 0.6f, 0.5f), 0.0f, 0.5f));
            materials[1].clearcoat = 1.0f;
            materials[2].transmission = 1.0f;
            materials[2].thickness = 1.0f;
            materials[3] = builtin::lambert("glow", glm::vec3(0.5f));
            materials[3].unlit = true;
            SceneEdit edit;
            for (size_t i = 0; i < materials.size(); ++i) {
                Primitive strip;
                add_quad(strip, {2.0f * float(i) - 5.0f, 0.0f, 5.0f}, {2.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -10.0f});
                builtin::add_object(edit, materials[i].name, std::move(strip), edit.add(materials[i]));
            }
            Primitive ceiling;
            add_quad(ceiling, {-5.0f, 3.0f, -5.0f}, {10.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 10.0f});
            builtin::add_object(edit, "ceiling", std::move(ceiling), edit.add(builtin::lambert("ceiling", glm::vec3(0.8f))));
            edit.add(Light{.kind = LightKind::Point, .intensity = 20.0f, .place = {.node_from_object = glm::translate(glm::mat4(1.0f), {0.1f, 1.5f, 0.2f})}});
            return make_scene(std::move(edit));
        }());
        return stage;
    }
    static Shot strips_shot(uint32_t samples = 3) {
        return {.view = {.width = kSize, .height = kSize, .aovs = kSplit}, .camera = camera_from_above(2.0f, 5.0f), .sample_count = samples};
    }
    static uint64_t sum(const std::array<uint64_t, shared::kClassCount>& counts) {
        uint64_t total = 0;
        for (const uint64_t count : counts) total += count;
        return total;
    }
    static uint64_t ray_sum(const WavefrontStats& stats) {
        uint64_t total = 0;
        for (const auto& counts : stats.rays) total += sum(counts);
        return total;
    }
    static uint64_t shadow_sum(const WavefrontStats& stats) {
        uint64_t total = 0;
        for (const auto& counts : stats.shadows) total += sum(counts);
        return total;
    }
    // Bit for bit where kernels are the same or the device is a CPU; other compilers may round otherwise in another kernel.
    void expect_same(const image::FilmSums& found, const image::FilmSums& expected, bool same_kernels) {
        if (same_kernels || device()->caps().type == gpu::DeviceType::Cpu) {
            EXPECT_EQ(differing_words(found, expected), 0u);
        } else {
            EXPECT_GE(share_equal(image::resolve_film(found), image::resolve_film(expected)), 0.97);
        }
    }
    std::string overflow_message(Stage& stage, const Shot& shot) {
        try {
            stage.render(shot);
        } catch (const Error& error) {
            EXPECT_EQ(error.code, ErrorCode::Failed);
            return error.line;
        }
        return "no error";
    }
};

TEST_F(WavefrontMachine, every_structure_and_dispatch_draws_the_same_bits) {
    for (const gpu::TraceWay way : kWays) {
        if (!device()->caps().supports(way)) continue;
        Shot shot = strips_shot(way == gpu::TraceWay::Compute ? 3 : 1);
        shot.way = way;
        shot.wavefront = kVariants[0].options;
        const image::FilmSums expected = strips().render(shot);
        EXPECT_GT(mean_rgb(image::resolve_film(expected)), 0.0);
        const RayCounts rays = strips().rays;
        for (const Variant& variant : kVariants) {
            SCOPED_TRACE(fmt::format("{}, {}", variant.name, gpu::trace_way_name(way)));
            shot.wavefront = variant.options;
            shot.rounds = variant.rounds;
            expect_same(strips().render(shot), expected, variant.same_kernels);
            if (variant.same_kernels) {
                EXPECT_EQ(strips().rays.path, rays.path);
                EXPECT_EQ(strips().rays.shadow, rays.shadow);
            }
        }
    }
}

// Rays that pass panes, and nested volumes, are in the built-in scene of glass.
TEST_F(WavefrontMachine, structures_agree_where_paths_pass_panes_and_volumes) {
    Shot shot{.view = {.width = kSize, .height = kSize, .aovs = kSplit}, .sample_count = 2, .wavefront = kVariants[0].options};
    const image::FilmSums expected = builtin_stage("builtin:glass").render(shot);
    for (const Variant& variant : kVariants) {
        SCOPED_TRACE(variant.name);
        shot.wavefront = variant.options;
        shot.rounds = variant.rounds;
        expect_same(builtin_stage("builtin:glass").render(shot), expected, variant.same_kernels);
    }
}

TEST_F(WavefrontMachine, one_slot_draws_the_whole_picture) {
    Shot shot{.view = {.width = 5, .height = 4, .aovs = kSplit}, .sample_count = 2};
    Stage& stage = builtin_stage("builtin:cornell");
    shot.wavefront.emplace();
    const image::FilmSums expected = stage.render(shot);
    for (const ConnectWhen connect : {ConnectWhen::EachBounce, ConnectWhen::Once}) {
        shot.wavefront = WavefrontOptions{.slots = 1, .connect = connect};
        EXPECT_EQ(differing_words(stage.render(shot), expected), 0u);
        EXPECT_EQ(stage.wavefront.slots, 1u);
        EXPECT_EQ(stage.wavefront.iterations, stage.rays.path) << "of one ray each";
    }
}

// A work group of the pipeline is one ray: more than 32,768 rays take more than one row of groups.
TEST_F(WavefrontMachine, lists_longer_than_a_row_of_work_groups_are_traced_whole) {
    PARHELION_REQUIRE_WAY(gpu::TraceWay::Pipeline);
    Shot shot{.way = gpu::TraceWay::Pipeline, .view = {.width = 256, .height = 144, .max_bounces = 1}, .sample_count = 1};
    Stage& stage = builtin_stage("builtin:cornell");
    const image::FilmSums expected = stage.render(shot);
    shot.wavefront = WavefrontOptions{.slots = 256 * 144};
    expect_same(stage.render(shot), expected, false);
    EXPECT_EQ(stage.wavefront.slots, 256u * 144u);
    EXPECT_EQ(sum(stage.wavefront.rays[0]), 256u * 144u);
}

TEST_F(WavefrontMachine, more_than_a_million_paths_at_a_time_draw_the_picture) {
    constexpr uint32_t kWidth = 1100, kHeight = 1000;
    static_assert(kWidth * kHeight > 1u << 20);
    Shot shot{.view = {.width = kWidth, .height = kHeight, .max_bounces = 1}, .sample_count = 1};
    Stage& stage = builtin_stage("builtin:cornell");
    const image::FilmSums expected = stage.render(shot);
    shot.rounds = 1;
    shot.wavefront = WavefrontOptions{.slots = kWidth * kHeight, .dispatch = WavefrontDispatch::Full};
    expect_same(stage.render(shot), expected, false);
    EXPECT_EQ(stage.wavefront.slots, kWidth * kHeight);
    EXPECT_EQ(stage.wavefront.round_length, 2u);
    EXPECT_EQ(sum(stage.wavefront.rays[0]), kWidth * kHeight);
}

TEST_F(WavefrontMachine, connect_runs_as_often_as_memory_asks) {
    const auto round_length = [&](const WavefrontOptions& options, uint32_t max_bounces) {
        Shot shot = strips_shot(1);
        shot.view.max_bounces = max_bounces;
        shot.wavefront = options;
        strips().render(shot);
        return strips().wavefront.round_length;
    };
    EXPECT_EQ(round_length({.connect = ConnectWhen::EachBounce}, 16), 1u);
    EXPECT_EQ(round_length({.connect = ConnectWhen::Once}, 4), 5u) << "the vertices of the longest path";
    const uint32_t cut = round_length({.slots = kSize * kSize, .connect = ConnectWhen::Once, .memory_bytes = 3 * kSlotBytes * kSize * kSize}, 16);
    EXPECT_GT(cut, 2u);
    EXPECT_LT(cut, 17u);
    EXPECT_EQ(round_length({.connect = ConnectWhen::Once, .memory_bytes = 1}, 16), 1u);
}

TEST_F(WavefrontMachine, slices_and_ranges_are_the_whole_bit_for_bit) {
    for (const ConnectWhen connect : {ConnectWhen::EachBounce, ConnectWhen::Once}) {
        const auto film = [&](uint32_t first, uint32_t count, uint32_t rows, uint32_t samples) {
            return builtin_stage("builtin:cornell")
                .render({.view = {.width = 16, .height = 13, .max_bounces = 3, .aovs = {"normal", "variance", "depth", "ids", "motion"}},
                         .first_sample = first,
                         .sample_count = count,
                         .slice_rows = rows,
                         .slice_samples = samples,
                         .wavefront = WavefrontOptions{.slots = 101, .connect = connect}});
        };
        const image::FilmSums whole = film(0, 70, 1u << 20, 64);
        EXPECT_EQ(differing_words(film(0, 70, 3, 64), whole), 0u) << "three rows a slice";
        EXPECT_EQ(differing_words(film(0, 70, 9, 7), whole), 0u) << "rows and samples";
        const image::FilmSums first = film(0, 64, 1u << 20, 64), rest = film(64, 6, 1, 6);
        const image::FilmPart parts[] = {{&rest, "rest"}, {&first, "first"}};
        EXPECT_EQ(differing_words(image::merge_films(parts), whole), 0u) << "parts of the range";
    }
}

TEST_F(WavefrontMachine, the_same_samples_are_the_same_bits_whatever_was_drawn_before) {
    Shot shot = strips_shot();
    shot.wavefront.emplace();
    const image::FilmSums expected = strips().render(shot);
    shot.view.seed = 5;
    EXPECT_NE(differing_words(strips().render(shot), expected), 0u);
    shot.view.seed = 0;
    EXPECT_EQ(differing_words(strips().render(shot), expected), 0u);
}

TEST_F(WavefrontMachine, full_barriers_change_nothing) {
    Stage full(make_builtin("builtin:cornell").scene, {}, {.full_barriers = true});
    for (const gpu::TraceWay way : kWays) {
        if (!device()->caps().supports(way)) continue;
        for (const Variant& variant : {kVariants[0], kVariants[2], kVariants[8]}) {
            const Shot shot{.way = way, .view = {.width = 16, .height = 16, .aovs = kSplit}, .sample_count = 2, .wavefront = variant.options};
            EXPECT_EQ(differing_words(full.render(shot), builtin_stage("builtin:cornell").render(shot)), 0u) << variant.name << ", " << gpu::trace_way_name(way);
        }
    }
}

// Recorded, not run. Two rounds: what the second needs of the first is in the frame.
TEST_F(WavefrontMachine, each_barrier_left_out_draws_a_complaint) {
    const gpu::DevicePtr quiet = gpu::Device::open({});
    for (const Variant& variant : {kVariants[0], kVariants[3], kVariants[7], kVariants[5]}) {
        Shot shot{.view = {.width = kSize, .height = kSize, .max_bounces = 3, .aovs = kSplit}, .sample_count = 2, .wavefront = variant.options, .rounds = 2};
        const auto complaints = [&](int skipped, uint32_t& barriers) {
            Stage stage(make_builtin("builtin:cornell").scene, {.hardware = false, .own_bvh = true}, {.skip_barrier = skipped}, quiet);
            stage.record(shot);
            barriers = stage.frame.barrier_count();
            return stage.frame.complaints().size();
        };
        uint32_t barriers = 0, ignored = 0;
        EXPECT_EQ(complaints(-1, barriers), 0u) << variant.name;
        EXPECT_GE(barriers, 14u) << variant.name;
        for (uint32_t skipped = 0; skipped < barriers; ++skipped)
            EXPECT_GT(complaints(static_cast<int>(skipped), ignored), 0u) << variant.name << ": barrier " << skipped << " of " << barriers;
    }
}

// All rays of the first iteration ask for light (every pixel sees a surface, and a point light always has some), later ones may not:
// with one scattering, entries without room are those of the first.
TEST_F(WavefrontMachine, an_overflow_is_counted_and_reported) {
    Stage& stage = builtin_stage("builtin:cornell");
    Shot shot{.view = {.width = kSize, .height = kSize, .max_bounces = 1}, .sample_count = 1};
    stage.render(shot);
    const uint64_t shadows = stage.rays.shadow;
    ASSERT_GT(shadows, 200u);
    shot.wavefront = WavefrontOptions{.connect = ConnectWhen::EachBounce, .shadow_capacity = static_cast<uint32_t>(shadows) - 7};
    EXPECT_NE(overflow_message(stage, shot).find("list of shadow rays was too short for 7 entries"), std::string::npos) << overflow_message(stage, shot);
    shot.wavefront->shadow_capacity = 1;
    EXPECT_NE(overflow_message(stage, shot).find(fmt::format("list of shadow rays was too short for {} entries", shadows - 1)), std::string::npos) << overflow_message(stage, shot);
    shot.wavefront->shadow_capacity = static_cast<uint32_t>(shadows);
    EXPECT_EQ(overflow_message(stage, shot), "no error");
}

TEST_F(WavefrontMachine, too_many_slots_are_wrong_usage) {
    EXPECT_NO_THROW(Wavefront(device(), {.slots = kMaxWavefrontSlots}));
    try {
        Wavefront(device(), {.slots = kMaxWavefrontSlots + 1});
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.code, ErrorCode::Usage);
        EXPECT_EQ(error.where, "wavefront.slots");
    }
}

TEST_F(WavefrontMachine, a_slice_is_finished_before_the_next_begins) {
    Wavefront machine(device(), {});
    machine.start({0, 1, 0, 1});
    EXPECT_ANY_THROW(machine.start({1, 1, 0, 1}));
}

class WavefrontCounts : public WavefrontMachine {};

TEST_F(WavefrontCounts, rays_that_all_miss_are_one_a_sample) {
    SceneEdit edit;
    Primitive below;
    add_quad(below, {-1.0f, -1.0f, 1.0f}, {2.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -2.0f});
    builtin::add_object(edit, "below", std::move(below), edit.add(builtin::lambert("below", glm::vec3(0.5f))));
    edit.set_environment(Environment{.name = "constant", .scale = glm::vec3(1.0f)});
    Stage stage(make_scene(std::move(edit)));
    stage.render({.view = {.width = 16, .height = 16}, .camera = look_at({0, 1, 0}, {0, 9, 0.1f}, 1.0f), .sample_count = 5, .wavefront = WavefrontOptions{.slots = 256}});
    const WavefrontStats& stats = stage.wavefront;
    EXPECT_EQ(stats.rays[0][shared::kClassMiss], 16u * 16u * 5u);
    EXPECT_EQ(ray_sum(stats), 16u * 16u * 5u);
    EXPECT_EQ(shadow_sum(stats), 0u);
    EXPECT_EQ(stats.slots, 256u);
    EXPECT_EQ(stats.iterations, 5u);
    EXPECT_EQ(stats.slot_iterations, 5u * 256u);
}

// In a closed room every path has all its rays where no roulette ends it.
TEST_F(WavefrontCounts, a_closed_room_counts_every_bounce_of_every_path) {
    Stage& stage = builtin_stage("builtin:diffuse-box");
    for (const bool classes : {true, false})
        for (const ConnectWhen connect : {ConnectWhen::EachBounce, ConnectWhen::Once}) {
            stage.render({.view = {.width = 16, .height = 16, .max_bounces = 36, .roulette_start = 1000}, .sample_count = 2, .wavefront = WavefrontOptions{.slots = 256, .connect = connect, .classes = classes}});
            const WavefrontStats& stats = stage.wavefront;
            for (uint32_t bounce = 0; bounce + 1 < shared::kCountedBounces; ++bounce) EXPECT_EQ(stats.rays[bounce][shared::kClassPlain], 512u) << bounce;
            EXPECT_EQ(stats.rays[shared::kCountedBounces - 1][shared::kClassPlain], 512u * (37 - (shared::kCountedBounces - 1))) << "the last row counts all later ones too";
            EXPECT_EQ(ray_sum(stats), stage.rays.path);
            EXPECT_EQ(shadow_sum(stats), stage.rays.shadow);
            if (connect == ConnectWhen::Once) continue;
            EXPECT_EQ(stats.iterations, 74u);
            EXPECT_EQ(stats.slot_iterations, stage.rays.path) << "all slots are busy until the end";
        }
}

TEST_F(WavefrontCounts, what_the_camera_sees_is_counted_by_class) {
    for (const bool classes : {true, false})
        for (const uint32_t slots : {0u, 37u}) {
            Shot shot = strips_shot(2);
            shot.wavefront = WavefrontOptions{.slots = slots, .classes = classes};
            strips().render(shot);
            const WavefrontStats& stats = strips().wavefront;
            for (const uint32_t c : kClassOfStrip) EXPECT_EQ(stats.rays[0][c], 2u * kSize * kSize / 5u) << c;
            EXPECT_EQ(stats.shadows[0][shared::kClassMiss] + stats.shadows[0][shared::kClassEmitter], 0u);
            EXPECT_GT(stats.shadows[0][shared::kClassPlain], 0u);
            EXPECT_EQ(stats.rays[1][shared::kClassEmitter] + stats.rays[1][shared::kClassCoated] + stats.rays[1][shared::kClassTransmissive], 0u) << "only the ceiling is above the ground";
            EXPECT_GT(stats.rays[2][shared::kClassCoated], 0u);
            EXPECT_EQ(ray_sum(stats), strips().rays.path);
            EXPECT_EQ(shadow_sum(stats), strips().rays.shadow);
        }
}

TEST_F(WavefrontCounts, a_coated_ball_in_the_open_is_met_once_a_path) {
    SceneEdit edit;
    Material coated = builtin::glossy("coated", glm::vec3(0.8f), 0.0f, 0.4f);
    coated.clearcoat = 1.0f;
    builtin::add_object(edit, "ball", make_sphere(1.0f, 48, true), edit.add(coated));
    edit.set_environment(Environment{.name = "constant", .scale = glm::vec3(1.0f)});
    Stage stage(make_scene(std::move(edit)));
    stage.render({.view = {.width = 16, .height = 16, .max_bounces = 4}, .camera = camera_from_above(3.0f, 0.5f), .sample_count = 2, .wavefront = WavefrontOptions{}});
    const WavefrontStats& stats = stage.wavefront;
    EXPECT_EQ(stats.rays[0][shared::kClassCoated], 512u);
    EXPECT_EQ(sum(stats.rays[0]), 512u);
    EXPECT_EQ(stats.rays[1][shared::kClassMiss], sum(stats.rays[1]));
    EXPECT_GT(stats.rays[1][shared::kClassMiss], 400u);
    EXPECT_EQ(ray_sum(stats), sum(stats.rays[0]) + sum(stats.rays[1]));
    EXPECT_EQ(stats.shadows[0][shared::kClassCoated], shadow_sum(stats));
}

}  // namespace
}  // namespace parhelion::testing::wavefront_machine_test
