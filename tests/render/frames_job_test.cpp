// Jobs that play frames: what stands where in each, which files they write, and what is left when they stop early. In process; the
// program's own part is in cli_frames_test.cpp.
#include <cmath>

#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/file.h"
#include "image/decode.h"
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
    // The first frame is the picture of a job without frames.
    job.play.reset();
    job.output.files = {folder.file("one.exr")};
    run(job);
    EXPECT_EQ(bytes("a.0000.exr"), bytes("one.exr"));
    // What has turned moves against the frame before, in the first frame nothing does.
    const auto moves = [&](const char* number) { return std::ranges::count_if(plane_of(frame(number), "motion.X"), [](float v) { return std::abs(v) > 1e-3f; }); };
    EXPECT_EQ(moves("0000"), 0);
    EXPECT_GT(moves("0001"), 5);
    EXPECT_GT(moves("0003"), 5);
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

}  // namespace parhelion::testing::frames_job_test
