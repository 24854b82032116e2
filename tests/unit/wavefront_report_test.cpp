// The statistics of the wavefront as JSON and as a table.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "session/job.h"

namespace parhelion::wavefront_report_test {
namespace {

using Json = nlohmann::ordered_json;

// 4 iterations of 10 slots: 20 rays of the camera, of which 5 missed, 8 after a scattering, 2 after 31 or more.
WavefrontReport some_report() {
    WavefrontReport report{.options = {.connect = ConnectWhen::Once, .dispatch = WavefrontDispatch::Full, .classes = false}};
    WavefrontStats& stats = report.stats;
    stats.rays[0] = {5, 1, 10, 3, 1};
    stats.shadows[0] = {0, 0, 9, 2, 1};
    stats.rays[1] = {8, 0, 0, 0, 0};
    stats.rays[31] = {0, 0, 2, 0, 0};
    stats.iterations = 4;
    stats.slot_iterations = 40;
    stats.slots = 10;
    stats.round_length = 3;
    stats.state_bytes = 188;
    return report;
}

RenderReport some_render() {
    RenderReport report{.renderer = "wavefront"};
    report.size = {4, 2};
    report.wanted = {0, 2};
    report.finished_end = 2;
    report.render_seconds = 1;
    report.rays = {.path = 30000, .shadow = 12000};
    for (const char* name : {"wavefront/extend [compute]", "wavefront/connect [compute+LAYERS]", "wavefront/shade [+PLAIN]", "reference/first_hit [compute]", "reference/add_block"})
        report.passes.push_back({name, 2, 1});
    report.wavefront = some_report();
    return report;
}

}  // namespace

TEST(WavefrontReport, the_json_has_the_options_and_a_row_for_every_bounce_that_had_rays) {
    const Json json = wavefront_json(some_report());
    EXPECT_EQ(json["connect"], "once");
    EXPECT_EQ(json["dispatch"], "full");
    EXPECT_EQ(json["classes"], false);
    EXPECT_EQ(json["slots"], 10);
    EXPECT_EQ(json["round_length"], 3);
    EXPECT_EQ(json["state_bytes"], 188);
    EXPECT_EQ(json["iterations"], 4);
    EXPECT_DOUBLE_EQ(json["occupancy"], 30.0 / 40);
    ASSERT_EQ(json["bounces"].size(), 32u);
    const Json& first = json["bounces"][0];
    EXPECT_EQ(first["bounce"], 0);
    EXPECT_EQ(first["rays"], 20);
    EXPECT_EQ(first["misses"], 5);
    EXPECT_EQ(first["shadow_rays"], 12);
    EXPECT_DOUBLE_EQ(first["occupancy"], 20.0 / 40);
    EXPECT_EQ(first["rays_by_class"], Json({{"miss", 5}, {"emitter", 1}, {"plain", 10}, {"coated", 3}, {"transmissive", 1}}));
    EXPECT_EQ(first["shadow_rays_by_class"]["coated"], 2);
    EXPECT_EQ(first["and_later"], false);
    EXPECT_EQ(json["bounces"][31]["and_later"], true);

    WavefrontReport short_paths = some_report();
    short_paths.stats.rays[31] = {};
    EXPECT_EQ(wavefront_json(short_paths)["bounces"].size(), 2u);
    EXPECT_EQ(wavefront_json({})["bounces"].size(), 0u);
    EXPECT_EQ(wavefront_json({})["occupancy"], 0.0);
    EXPECT_EQ(wavefront_json({})["classes"], true);
}

TEST(WavefrontReport, the_table_has_the_same_numbers) {
    const std::string table = wavefront_table(some_report());
    EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 2 + 32);
    EXPECT_NE(table.find("10 slots of 188 bytes, connect once (after 3 bounces), dispatch full, classes off; 4 iterations, in which 75.0 %"), std::string::npos) << table;
    EXPECT_NE(table.find("\n     0             20    50.00 %             12              5              1             10              3              1\n"), std::string::npos) << table;
    EXPECT_NE(table.find("\n   31+              2     5.00 %"), std::string::npos) << table;
}

TEST(WavefrontReport, a_renders_json_names_the_renderer_and_counts_the_rays_of_its_passes) {
    const Json json = report_json(some_render());
    EXPECT_EQ(json["renderer"], "wavefront");
    EXPECT_EQ(json["wavefront"]["slots"], 10);
    const auto& passes = json["passes"];
    EXPECT_EQ(passes[0]["rays"], 30000);  // Extend
    EXPECT_EQ(passes[1]["rays"], 12000);  // Connect
    EXPECT_EQ(passes[2]["rays"], 0);
    EXPECT_EQ(passes[3]["rays"], 8);  // first hits: one a pixel
    EXPECT_EQ(passes[4]["rays"], 0);
    EXPECT_TRUE(report_json(RenderReport{})["wavefront"].is_null());
}

TEST(WavefrontReport, its_rays_a_second_count_the_time_of_all_its_kernels) {
    const RenderReport report = some_render();
    EXPECT_DOUBLE_EQ(report.trace_seconds(), 0.006);
    EXPECT_DOUBLE_EQ(report.mega_rays_per_second(), 42000 / 0.006 / 1e6);
}

}  // namespace parhelion::wavefront_report_test
