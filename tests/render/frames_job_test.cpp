// Jobs that play frames: what stands where in each, which files they write, and what is left when they stop early. In process; the
// program's own part is in cli_frames_test.cpp.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/file.h"
#include "image/decode.h"
#include "scene/gltf/write.h"
#include "session/job.h"
#include "support/process.h"
#include "support/render_fixture.h"

namespace parhelion::testing::frames_job_test {
namespace {

class FramesJob : public GpuTest {
protected:
    TemporaryFolder folder;

    RenderOptions options(const std::string& scene, const std::string& animate, FramePlay play) const {
        RenderOptions out;
        out.scene = scene;
        out.load.animate = animate;
        out.size = {24, 16};
        out.samples = {0, 2};
        out.max_bounces = 3;
        out.exposure_ev = 3.0;
        out.output.exr_float = true;
        out.output.files = {folder.file("a.####.exr")};
        out.trace = TraceChoice::Compute;
        out.play = play;
        return out;
    }
    RenderReport run(const RenderOptions& what) const { return run_render_job(what, device()); }
    image::ImageF frame(const char* number) const { return image::read_linear(folder.file(fmt::format("a.{}.exr", number))); }
    std::string bytes(const char* name) const { return read_bytes(folder.file(name)); }
};

std::vector<uint64_t> drawn(const RenderReport& report, bool written) {
    std::vector<uint64_t> numbers;
    for (const PlayedFrame& frame : report.play->frames)
        if (frame.written || !written) numbers.push_back(frame.number);
    return numbers;
}
using Numbers = std::vector<uint64_t>;

std::vector<float> plane_of(const image::ImageF& picture, std::string_view channel) {
    for (size_t c = 0; c < picture.channels.size(); ++c)
        if (picture.channels[c] == channel) return {picture.plane(c).begin(), picture.plane(c).end()};
    ADD_FAILURE() << "there is no channel " << channel;
    return {};
}

}  // namespace

TEST_F(FramesJob, a_part_of_a_sequence_is_the_very_files_of_the_whole) {
    RenderOptions job = options("builtin:cornell", "spin", {.frames = {0, 4}, .fps = 10});
    job.aovs = {"depth", "motion"};
    const RenderReport report = run(job);
    EXPECT_EQ(folder.names(), (std::vector<std::string>{"a.0000.exr", "a.0001.exr", "a.0002.exr", "a.0003.exr"}));
    ASSERT_EQ(report.play->frames.size(), 4u);
    EXPECT_DOUBLE_EQ(report.play->frames[3].time, 0.3);
    EXPECT_GT(report.play->frames[3].rays.path, 24u * 16u * 2u);
    EXPECT_EQ(report.rays.path, report.play->frames[0].rays.path + report.play->frames[1].rays.path + report.play->frames[2].rays.path + report.play->frames[3].rays.path);
    const nlohmann::json json = report_json(report);
    EXPECT_EQ(json["frames"], 4);
    EXPECT_EQ(json["play"]["drawn"].size(), 4u);
    EXPECT_TRUE(json["complete"].get<bool>());
    job.play->frames = {2, 4};
    job.output.files = {folder.file("b.####.exr")};
    run(job);
    EXPECT_EQ(bytes("a.0002.exr"), bytes("b.0002.exr"));
    EXPECT_EQ(bytes("a.0003.exr"), bytes("b.0003.exr"));
    EXPECT_FALSE(std::filesystem::exists(folder.file("b.0001.exr")));
    // The first frame is the picture of a job without frames, but for what says that it is a frame.
    job.play.reset();
    job.output.files = {folder.file("one.exr")};
    run(job);
    image::ImageF first = frame("0000");
    EXPECT_EQ(first.attributes.erase("frame_hash"), 1u);
    const image::ImageF one = image::read_linear(folder.file("one.exr"));
    EXPECT_EQ(first.channels, one.channels);
    EXPECT_EQ(std::memcmp(first.data.data(), one.data.data(), first.data.size() * sizeof(float)), 0);
    EXPECT_EQ(first.attributes, one.attributes);
    // What has turned moves against the frame before, in the first frame nothing does.
    const auto moves = [&](const char* number) { return std::ranges::count_if(plane_of(frame(number), "motion.X"), [](float v) { return std::abs(v) > 1e-3f; }); };
    EXPECT_EQ(moves("0000"), 0);
    EXPECT_GT(moves("0001"), 5);
    EXPECT_GT(moves("0003"), 5);
}

// Lights that were added and taken away before leave no trace in what random numbers mean.
TEST_F(FramesJob, a_frame_alone_is_that_of_the_sequence_whatever_has_come_and_gone) {
    for (const auto& [scene, animate] : {std::pair("builtin:cornell", "sparks"), std::pair("builtin:many-lights", "guests")}) {
        for (const double shutter : {0.0, 0.1}) {
            RenderOptions job = options(scene, animate, {.frames = {6, 16}, .fps = 5});
            job.shutter_seconds = shutter;
            job.output.files = {folder.file("a.####.exr")};
            run(job);
            job.play->frames = {15, 16};
            job.output.files = {folder.file("alone.####.exr")};
            run(job);
            const image::ImageF whole = image::read_linear(folder.file("a.0015.exr")), alone = image::read_linear(folder.file("alone.0015.exr"));
            for (size_t c = 0; c < whole.channels.size(); ++c) EXPECT_TRUE(std::ranges::equal(whole.plane(c), alone.plane(c))) << animate << ", shutter " << shutter << ", " << whole.channels[c];
        }
    }
}

TEST_F(FramesJob, every_frame_shows_the_scene_and_the_camera_of_its_time) {
    write_text_file(folder.file("path.json"), R"({"keys": [{"time": 1, "look_from": [0, 1, 3.8], "look_at": [0, 1, 0]}, {"time": 2, "look_from": [0.8, 1.4, 3], "look_at": [0, 1, 0]}]})");
    const struct {
        const char* animate;
        bool path;
    } cases[] = {{"spin", false}, {"", true}, {"spin", true}, {"cut", false}};
    for (const auto& [animate, path] : cases) {
        SCOPED_TRACE(fmt::format("{} {}", animate, path));
        RenderOptions job = options("builtin:cornell", animate, {.frames = {0, 3}, .fps = 2});
        job.aovs = {"depth"};
        job.load.time = 1.0;
        job.samples = {0, 1};
        job.max_bounces = 1;
        if (path) job.camera_path = folder.file("path.json");
        run(job);
        std::vector<std::vector<float>> depths;
        for (int i = 0; i < 3; ++i) {
            RenderOptions one = job;
            one.play.reset();
            one.load.time = 1.0 + 0.5 * i;
            one.output.files = {folder.file("one.exr")};
            run(one);
            depths.push_back(plane_of(frame(fmt::format("{:04}", i).c_str()), "depth"));
            EXPECT_EQ(depths.back(), plane_of(image::read_linear(folder.file("one.exr")), "depth")) << i;
        }
        EXPECT_NE(depths[0], depths[2]);
    }
}

// Without --fps the clock stands: every frame is another sample of one picture.
TEST_F(FramesJob, the_mean_of_realtime_frames_is_that_of_those_after_the_warm_up) {
    RenderOptions job = options("builtin:cornell", "", {.frames = {0, 70}});
    job.renderer = RendererKind::Realtime;
    EXPECT_EQ(run(job).finished_end, 70u);
    EXPECT_EQ(folder.names().size(), 70u);
    std::vector<double> sums;
    for (int i = 3; i < 70; ++i) {
        const image::ImageF next = frame(fmt::format("{:04}", i).c_str());
        sums.resize(next.data.size());
        for (size_t k = 0; k < sums.size(); ++k) sums[k] += double(next.data[k]);
    }
    job.play = {.frames = {0, 70}, .average = true, .warmup = 3};
    job.output.files = {folder.file("mean.exr")};
    const RenderReport report = run(job);
    EXPECT_EQ(report.sample_count(), 67u);
    EXPECT_EQ(report.play->frames.size(), 70u);
    const image::ImageF written = image::read_linear(folder.file("mean.exr"));
    ASSERT_EQ(written.data.size(), sums.size());
    for (size_t k = 0; k < sums.size(); ++k) ASSERT_NEAR(written.data[k], sums[k] / 67, 1e-5 * sums[k] / 67 + 1e-9) << k;
    // A plain name without a mean: the last frame.
    job.play = {.frames = {0, 5}};
    job.output.files = {folder.file("last.exr")};
    run(job);
    EXPECT_EQ(bytes("last.exr"), bytes("a.0004.exr"));
    EXPECT_NE(bytes("last.exr"), bytes("a.0003.exr"));
}

TEST_F(FramesJob, out_of_time_a_sequence_ends_with_a_whole_frame) {
    RenderOptions job = options("builtin:cornell", "spin", {.frames = {0, 10000}, .fps = 30});
    job.time_budget_seconds = 0.5;
    const RenderReport report = run(job);
    EXPECT_TRUE(report.out_of_time);
    EXPECT_GE(report.finished_end, 1u);
    EXPECT_EQ(folder.names().size(), report.finished_end);
    EXPECT_FALSE(report_json(report)["complete"].get<bool>());
    const uint64_t last = report.finished_end - 1;
    job.time_budget_seconds.reset();
    job.play->frames = {last, last + 1};
    job.output.files = {folder.file("again.####.exr")};
    run(job);
    EXPECT_EQ(bytes(fmt::format("a.{:04}.exr", last).c_str()), bytes(fmt::format("again.{:04}.exr", last).c_str()));
}

// Lights come and go, so that tables of the scene have other rows from frame to frame.
TEST_F(FramesJob, a_resumed_sequence_is_the_uninterrupted_one_and_what_is_there_is_not_drawn) {
    for (const RendererKind renderer : {RendererKind::Reference, RendererKind::Wavefront}) {
        SCOPED_TRACE(static_cast<int>(renderer));
        RenderOptions job = options("builtin:cornell", "sparks", {.frames = {0, 8}, .fps = 3});
        job.renderer = renderer;
        job.aovs = {"ids", "motion"};
        job.output.files.push_back(folder.file("a.####.png"));
        run(job);
        std::map<std::string, std::string> whole;
        for (const std::string& name : folder.names()) whole[name] = bytes(name.c_str());
        ASSERT_EQ(whole.size(), 16u);
        // Lost, half, cut short, damaged, another frame's, something else.
        std::filesystem::remove(folder.file("a.0001.exr"));
        std::filesystem::remove(folder.file("a.0002.png"));
        std::filesystem::resize_file(folder.file("a.0003.exr"), whole["a.0003.exr"].size() - 40);
        std::filesystem::resize_file(folder.file("a.0004.png"), whole["a.0004.png"].size() / 2);
        write_text_file(folder.file("a.0006.exr"), whole["a.0005.exr"]);
        write_text_file(folder.file("a.0007.png"), "no picture");
        job.resume = true;
        const RenderReport report = run(job);
        EXPECT_EQ(report.play->kept, (Numbers{0, 5}));
        EXPECT_EQ(drawn(report, false), (Numbers{1, 2, 3, 4, 6, 7}));
        EXPECT_TRUE(report_json(report)["complete"].get<bool>());
        EXPECT_EQ(report_json(report)["play"]["kept"], nlohmann::json({0, 5}));
        for (const auto& [name, content] : whole) EXPECT_EQ(bytes(name.c_str()), content) << name;
        // Nothing is left to do; a longer sequence is the same one.
        EXPECT_EQ(run(job).play->frames.size(), 0u);
        EXPECT_EQ(folder.names().size(), 16u);
        job.play->frames = {5, 9};
        EXPECT_EQ(drawn(run(job), true), Numbers{8});
        for (const std::string& name : folder.names()) std::filesystem::remove(folder.file(name));
    }
}

TEST_F(FramesJob, resumed_realtime_frames_have_the_history_that_they_would_have_had) {
    RenderOptions job = options("builtin:cornell", "torch", {.frames = {0, 7}, .fps = 10});
    job.renderer = RendererKind::Realtime;
    job.denoise = DenoiseKind::Builtin;
    job.assignments = {"realtime.reuse=full"};
    run(job);
    const std::string third = bytes("a.0003.exr"), fifth = bytes("a.0005.exr");
    const auto lose = [&] {
        std::filesystem::remove(folder.file("a.0003.exr"));
        std::filesystem::remove(folder.file("a.0005.exr"));
    };
    lose();
    job.resume = true;
    RenderReport report = run(job);
    EXPECT_EQ(report.play->kept, (Numbers{0, 1, 2, 4, 6}));
    EXPECT_EQ(drawn(report, false), (Numbers{0, 1, 2, 3, 4, 5}));
    EXPECT_EQ(drawn(report, true), (Numbers{3, 5}));
    EXPECT_EQ(bytes("a.0003.exr"), third);
    EXPECT_EQ(bytes("a.0005.exr"), fifth);
    // With less of it they are others, which say so: a run that wants all of it draws them again.
    lose();
    job.play->preroll = 1;
    report = run(job);
    EXPECT_EQ(drawn(report, false), (Numbers{2, 3, 4, 5}));
    EXPECT_NE(bytes("a.0003.exr"), third);
    EXPECT_EQ(run(job).play->kept.size(), 7u);
    job.play->preroll = 2;
    EXPECT_EQ(run(job).play->kept.size(), 5u);
    // As far back as frame 0 it is all of it.
    lose();
    job.play->preroll = 3;
    EXPECT_EQ(drawn(run(job), false).front(), 0u);
    job.play->preroll.reset();
    EXPECT_EQ(run(job).play->kept.size(), 7u);
    EXPECT_EQ(bytes("a.0005.exr"), fifth);
}

TEST_F(FramesJob, a_part_with_preroll_begins_so_many_frames_before) {
    RenderOptions job = options("builtin:cornell", "torch", {.frames = {6, 8}, .fps = 10, .preroll = 2});
    job.renderer = RendererKind::Realtime;
    const RenderReport report = run(job);
    EXPECT_EQ(drawn(report, false), (Numbers{4, 5, 6, 7}));
    EXPECT_EQ(folder.names(), (std::vector<std::string>{"a.0006.exr", "a.0007.exr"}));
    EXPECT_DOUBLE_EQ(report.play->frames[0].time, 0.4);
}

TEST_F(FramesJob, a_failure_says_how_to_go_on) {
    std::filesystem::create_directory(folder.file("a.0002.exr"));
    try {
        run(options("builtin:cornell", "spin", {.frames = {0, 3}, .fps = 10}));
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.hint, "2 frames are written: the same command with --resume keeps them");
    }
}

TEST_F(FramesJob, frames_of_a_changed_scene_or_command_are_drawn_again) {
    const auto write_scene = [&](double time) {
        LoadOptions load;
        load.animate = "spin";
        load.time = time;
        write_gltf(load_scene("builtin:cornell", load).scene, folder.file("scene.glb"));
    };
    write_scene(0);
    RenderOptions job = options(folder.file("scene.glb"), "", {.frames = {0, 2}, .fps = 10});
    job.resume = true;
    EXPECT_EQ(drawn(run(job), true), (Numbers{0, 1}));
    EXPECT_EQ(drawn(run(job), true), Numbers{});
    write_scene(0.25);
    EXPECT_EQ(drawn(run(job), true), (Numbers{0, 1}));
    job.samples.end = 3;
    EXPECT_EQ(drawn(run(job), true), (Numbers{0, 1}));
}

}  // namespace parhelion::testing::frames_job_test
