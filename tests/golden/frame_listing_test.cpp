// The recorded frame of each renderer and way to trace equals its stored listing, and docs/frame.md is made from those.
// PARHELION_UPDATE_GOLDEN=1 rewrites both.
#include <cstdlib>
#include <fstream>

#include "renderers/realtime.h"
#include "renderers/wavefront.h"
#include "session/scene_setup.h"
#include "support/render_fixture.h"

namespace parhelion::testing::frame_listing_test {
namespace {

const std::string kGolden = PARHELION_SOURCE_DIR "/tests/golden/", kDocument = PARHELION_SOURCE_DIR "/docs/frame.md";
const std::string kFirstHits = kGolden + "reference.first_hits.txt";

const std::string kRealtime = kGolden + "realtime.txt";

std::string read(const std::string& path) {
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), {}};
}

void expect_file(const std::string& path, const std::string& content) {
    if (std::getenv("PARHELION_UPDATE_GOLDEN")) std::ofstream(path) << content;
    EXPECT_EQ(read(path), content) << path << " is out of date; PARHELION_UPDATE_GOLDEN=1 rewrites it";
}

std::string wavefront_golden(ConnectWhen when) { return kGolden + "wavefront." + (when == ConnectWhen::Once ? "once" : "each_bounce") + ".txt"; }
std::string golden_name(gpu::TraceWay way) { return kGolden + "reference." + std::string(gpu::trace_way_name(way)) + ".txt"; }

class FrameListing : public GpuTest {};

// Which bottom levels become smaller, and are copied, depends on the device: the listings are the CPU device's.
TEST_F(FrameListing, the_reference_records_the_passes_that_are_written_down) {
    if (device()->caps().type != gpu::DeviceType::Cpu) GTEST_SKIP() << "not the CPU device";
    for (const gpu::TraceWay way : kWays) {
        if (!device()->caps().supports(way)) continue;
        const bool hardware = way != gpu::TraceWay::Compute;
        Stage stage(make_builtin("builtin:cornell").scene, {.hardware = hardware, .own_bvh = !hardware});
        stage.record({.way = way, .view = {.width = 64, .height = 64}, .sample_count = 64});
        expect_file(golden_name(way), stage.listings_before + stage.frame.listing());
        if (way != gpu::TraceWay::Compute) continue;
        stage.record({.way = way, .view = {.width = 64, .height = 64, .aovs = {"depth"}}, .sample_count = 64});
        expect_file(kFirstHits, stage.frame.listing());
    }
}

TEST_F(FrameListing, the_wavefront_records_the_kernels_that_are_written_down) {
    if (device()->caps().type != gpu::DeviceType::Cpu) GTEST_SKIP() << "not the CPU device";
    Stage& stage = builtin_stage("builtin:glass");
    stage.scene_gpu.finish(stage.frame);
    stage.frame.run();
    for (const ConnectWhen when : {ConnectWhen::EachBounce, ConnectWhen::Once}) {
        const CameraView camera = view_of((*stage.scene.cameras().begin()).value, 1.0f);
        View view(device(), {.width = 64, .height = 64, .camera = shader_camera(camera, 1.0f), .max_bounces = 4});
        view.prepare(stage.frame);
        stage.frame.run();
        Wavefront wavefront(device(), {.connect = when, .classes = true});
        wavefront.start({.first_row = 0, .row_count = 64, .first_sample = 0, .sample_count = 2});
        wavefront.record(stage.frame, stage.scene_gpu, gpu::TraceWay::Compute, view);
        stage.frame.run();
        expect_file(wavefront_golden(when), stage.frame.listing());
    }
}

TEST_F(FrameListing, realtime_records_the_passes_that_are_written_down) {
    if (device()->caps().type != gpu::DeviceType::Cpu) GTEST_SKIP() << "not the CPU device";
    Stage& stage = builtin_stage("builtin:cornell");
    stage.scene_gpu.finish(stage.frame);
    stage.frame.run();
    const CameraView camera = view_of((*stage.scene.cameras().begin()).value, 1.0f);
    View view(device(), {.width = 64, .height = 64, .camera = shader_camera(camera, 1.0f), .filter = PixelFilter::Point});
    Realtime realtime(device(), view, {});
    for (int i = 0; i < 2; ++i) {
        realtime.record(stage.frame, stage.scene_gpu, gpu::TraceWay::Compute, view, true);
        stage.frame.run();
    }
    expect_file(kRealtime, stage.frame.listing());
}

TEST_F(FrameListing, the_document_is_made_from_the_listings) {
    std::string text =
        "# Frame listings\n\n"
        "What `parhelion render builtin:cornell --list-frame` records: every pass with what it reads and writes. Made from\n"
        "`tests/golden/` by the test `golden` (`PARHELION_UPDATE_GOLDEN=1` rewrites it).\n\n"
        "The first frames of a scene bring it in, in slices, and build what its way to trace needs (here one slice, and one to compact\n"
        "the driver's bottom levels); the last rows, from `view/data` on, are all that a slice of work consists of afterwards. A pass behind\n"
        "`&` runs beside the one before it; what stands behind a bar repeats.\n";
    for (const gpu::TraceWay way : kWays) {
        const std::string name(gpu::trace_way_name(way));
        text += "\n## reference, --trace " + name + "\n\n```\n" + read(golden_name(way)) + "```\n";
    }
    text += "\n## reference, --aov depth (ids, motion)\n\nThe first slice of a view's rows also takes their first hits.\n\n```\n" + read(kFirstHits) + "```\n";
    text += "\n## wavefront, wavefront.connect=each_bounce\n\nThe first frame of a slice of builtin:glass: one iteration ([wavefront](wavefront.md)). Later frames repeat the rows from Generate to\nFinalize, as often as takes about 60 ms.\n\n```\n" +
            read(wavefront_golden(ConnectWhen::EachBounce)) + "```\n";
    text += "\n## wavefront, wavefront.connect=once\n\nWith at most 4 scatterings a path has 5 vertices.\n\n```\n" + read(wavefront_golden(ConnectWhen::Once)) + "```\n";
    text += "\n## realtime\n\nThe second frame of builtin:cornell: paths of at most four vertices ([realtime](realtime.md)). Scenes of layered materials have more rounds, and two kernels of Shade.\n\n```\n" + read(kRealtime) + "```\n";
    expect_file(kDocument, text);
}

}  // namespace
}  // namespace parhelion::testing::frame_listing_test
