// Which way `--trace auto` takes: the table of device classes, and what was measured where somebody asked for it.
#include "session/trace_choice.h"

#include <cstdlib>
#include <fstream>
#include <set>

#include <gtest/gtest.h>

#include "base/file.h"
#include "session/render_settings.h"
#include "session/trace_bench.h"
#include "support/process.h"

namespace parhelion::testing::trace_choice_test {
namespace {

gpu::DeviceCaps device(std::string name, uint32_t vendor, gpu::DeviceType type, bool pipeline, bool query) {
    gpu::DeviceCaps caps;
    caps.name = std::move(name);
    caps.driver = "driver 1.2.3";
    caps.vendor_id = vendor;
    caps.type = type;
    caps.ray_pipeline = pipeline;
    caps.ray_query = query;
    return caps;
}

constexpr auto kDiscrete = gpu::DeviceType::Discrete;

TEST(DeviceClasses, cards_without_ray_tracing_cores_trace_in_compute_and_others_by_query) {
    const auto way = [](const gpu::DeviceCaps& caps) { return gpu::device_class(caps).way; };
    EXPECT_EQ(way(device("llvmpipe (LLVM 15)", 0x10005, gpu::DeviceType::Cpu, true, true)), gpu::TraceWay::Compute);
    EXPECT_EQ(way(device("NVIDIA H100 80GB HBM3", 0x10DE, kDiscrete, true, false)), gpu::TraceWay::Compute);
    EXPECT_EQ(way(device("NVIDIA GeForce GTX 1080", 0x10DE, kDiscrete, true, true)), gpu::TraceWay::Compute);
    EXPECT_EQ(way(device("NVIDIA GeForce RTX 4090", 0x10DE, kDiscrete, true, true)), gpu::TraceWay::Query);
    EXPECT_EQ(way(device("AMD Radeon RX 7900", 0x1002, kDiscrete, true, true)), gpu::TraceWay::Query);
    EXPECT_EQ(way(device("AMD Radeon RX 480", 0x1002, kDiscrete, false, false)), gpu::TraceWay::Compute);
    EXPECT_EQ(way(device("Intel Arc A770", 0x8086, kDiscrete, true, true)), gpu::TraceWay::Query);
    EXPECT_EQ(way(device("another", 1, kDiscrete, true, false)), gpu::TraceWay::Pipeline);
}

// As measured on an H100; the CPU device would lose its passes' times. A device that cannot draw traces, whatever its class.
TEST(DeviceClasses, data_centre_gpus_and_the_cpu_trace_the_triangles_under_pixels_and_others_draw_them) {
    const auto draws = [](gpu::DeviceCaps caps, GBufferMode mode = GBufferMode::Auto, bool can = true) {
        caps.raster = can;
        return may_draw_pixels({.gbuffer_mode = mode}, caps);
    };
    const gpu::DeviceCaps h100 = device("NVIDIA H100 80GB HBM3", 0x10DE, kDiscrete, true, false), cpu = device("llvmpipe (LLVM 15)", 0x10005, gpu::DeviceType::Cpu, true, true);
    EXPECT_FALSE(draws(h100));
    EXPECT_FALSE(draws(device("NVIDIA H200", 0x10DE, kDiscrete, false, false))) << "its ray tracing hidden";
    EXPECT_FALSE(draws(cpu));
    EXPECT_TRUE(draws(device("NVIDIA GeForce GTX 1080", 0x10DE, kDiscrete, true, true)));
    EXPECT_TRUE(draws(device("NVIDIA GeForce RTX 4090", 0x10DE, kDiscrete, true, true)));
    EXPECT_TRUE(draws(device("AMD Radeon RX 480", 0x1002, kDiscrete, false, false)));
    const gpu::DeviceCaps rtx = device("NVIDIA GeForce RTX 4090", 0x10DE, kDiscrete, true, true);
    EXPECT_FALSE(draws(rtx, GBufferMode::Auto, false));
    EXPECT_FALSE(draws(rtx, GBufferMode::Trace));
    EXPECT_TRUE(draws(cpu, GBufferMode::Raster));
    EXPECT_TRUE(draws(h100, GBufferMode::Raster)) << "asked for";
}

TEST(DeviceClasses, every_device_has_one_whose_way_it_can_go_and_whose_nodes_are_named) {
    for (const uint32_t vendor : {0x10DEu, 0x1002u, 0x8086u, 0x5143u})
        for (const auto type : {gpu::DeviceType::Cpu, gpu::DeviceType::Discrete, gpu::DeviceType::Integrated, gpu::DeviceType::Other})
            for (const bool pipeline : {false, true})
                for (const bool query : {false, true}) {
                    const gpu::DeviceCaps caps = device("a device", vendor, type, pipeline, query);
                    EXPECT_TRUE(caps.supports(gpu::device_class(caps).way)) << gpu::device_class(caps).name;
                    EXPECT_NE(gpu::device_class(caps).layout, gpu::NodeLayout::Auto);
                }
    std::set<std::string_view> names;
    for (const gpu::DeviceClass& row : gpu::device_classes()) EXPECT_TRUE(names.insert(row.name).second) << row.name;
}

// A cache folder of its own.
class MeasuredTraceTest : public ::testing::Test {
protected:
    void SetUp() override {
        if (const char* old = std::getenv("PARHELION_CACHE_DIR")) before_ = old;
        setenv("PARHELION_CACHE_DIR", folder_.path().c_str(), 1);
    }
    void TearDown() override { before_ ? setenv("PARHELION_CACHE_DIR", before_->c_str(), 1) : unsetenv("PARHELION_CACHE_DIR"); }

    TemporaryFolder folder_;
    std::optional<std::string> before_;
    gpu::DeviceCaps caps_ = device("AMD Radeon RX 7900", 0x1002, kDiscrete, true, true);
};

TEST_F(MeasuredTraceTest, the_fastest_way_measured_wins_over_the_table_on_that_device_and_driver_alone) {
    EXPECT_EQ(decide_trace(caps_, TraceChoice::Auto, gpu::NodeLayout::Auto).source, "table");
    store_measured_trace(caps_, {{{"binary", 900.0}, {"compact", 1200.5}, {"four", 800.0}, {"pipeline", 700.0}, {"query", 1000.0}}});
    TraceDecision decision = decide_trace(caps_, TraceChoice::Auto, gpu::NodeLayout::Auto);
    EXPECT_EQ(decision.way, gpu::TraceWay::Compute);
    EXPECT_EQ(decision.layout, gpu::NodeLayout::Compact);
    EXPECT_EQ(decision.source, "measured");
    EXPECT_EQ(decide_trace(caps_, TraceChoice::Auto, gpu::NodeLayout::Four).layout, gpu::NodeLayout::Four) << "trace.bvh wins";

    decision = decide_trace(caps_, TraceChoice::Query, gpu::NodeLayout::Auto);
    EXPECT_EQ(decision.way, gpu::TraceWay::Query);
    EXPECT_EQ(decision.source, "option");

    gpu::DeviceCaps newer = caps_;
    newer.driver = "driver 1.2.4";
    EXPECT_EQ(decide_trace(newer, TraceChoice::Auto, gpu::NodeLayout::Auto).source, "table");
    EXPECT_NE(measured_trace_file(newer), measured_trace_file(caps_));

    store_measured_trace(caps_, {{{"binary", 900.0}, {"query", 1000.0}}});
    EXPECT_EQ(decide_trace(caps_, TraceChoice::Auto, gpu::NodeLayout::Auto).way, gpu::TraceWay::Query) << "measured again";
}

TEST_F(MeasuredTraceTest, a_file_that_is_broken_or_foreign_counts_for_nothing) {
    store_measured_trace(caps_, {{{"binary", 900.0}, {"query", 500.0}}});
    const std::filesystem::path file = measured_trace_file(caps_);
    const std::string good = read_text_file(file, 1 << 16);
    ASSERT_TRUE(read_measured_trace(caps_));

    std::string changed = good;
    changed.replace(changed.find("900"), 3, "400");
    for (const std::string& bad : {std::string(), good.substr(0, good.size() / 2), changed, std::string("[1, 2]"), std::string("{}"), std::string(100'000, ' ')}) {
        write_text_file(file, bad);
        EXPECT_FALSE(read_measured_trace(caps_)) << bad.substr(0, 40);
        EXPECT_EQ(decide_trace(caps_, TraceChoice::Auto, gpu::NodeLayout::Auto).source, "table");
    }
    // Another device's, put in this one's place.
    gpu::DeviceCaps other = caps_;
    other.name = "AMD Radeon RX 7800";
    write_text_file(file, good);
    std::filesystem::copy_file(file, measured_trace_file(other));
    EXPECT_FALSE(read_measured_trace(other));
    // What the device can do has changed.
    gpu::DeviceCaps without = caps_;
    without.ray_query = false;
    EXPECT_FALSE(read_measured_trace(without));
    EXPECT_TRUE(read_measured_trace(caps_));
}

TEST_F(MeasuredTraceTest, a_cache_folder_that_cannot_be_made_is_an_error_that_names_it) {
    write_text_file(folder_.path() / "file", "");
    setenv("PARHELION_CACHE_DIR", (folder_.path() / "file").c_str(), 1);
    try {
        store_measured_trace(caps_, {{{"binary", 1.0}}});
        FAIL();
    } catch (const Error& error) {
        EXPECT_NE(error.line.find("PARHELION_CACHE_DIR"), std::string::npos) << error.line;
    }
}

// ---- bench trace ----

TEST(TraceBench, hits_agree_by_triangle_or_by_distance_within_some_roundings) {
    const shared::DumpedRay ray{.origin_ws = {0, 0, 4}, .reach = 1, .direction_ws = {1, 0, 0}, .alpha_key = 0};
    const auto hit = [](uint32_t primitive, float t) { return shared::Hit{.instance_bits = 0, .geometry = 0, .primitive = primitive, .barycentrics = 0, .t = t}; };
    shared::Hit miss = hit(0, 0);
    miss.instance_bits = shared::kHitMiss;
    EXPECT_TRUE(same_hit(ray, hit(3, 2.0f), hit(3, 2.1f)));
    EXPECT_TRUE(same_hit(ray, hit(3, 2.0f), hit(4, 2.000001f)));
    EXPECT_FALSE(same_hit(ray, hit(3, 2.0f), hit(4, 2.0001f)));
    EXPECT_FALSE(same_hit(ray, hit(3, 2.0f), miss));
    EXPECT_TRUE(same_hit(ray, miss, miss));
    EXPECT_TRUE(same_distance(ray, INFINITY, INFINITY));
    EXPECT_FALSE(same_distance(ray, INFINITY, 2.0f));
}

TraceBenchReport report_with(double agreement) {
    RayRates rates;
    rates.rays = 1'000'000;
    rates.tracers = {{"pipeline", 2.0, 1.0}, {"compute", 5.0, agreement}, {"", 10.0, 1.0}};
    return {.device = "a device", .driver = "a driver", .size = {20, 50}, .cpu = true, .scenes = {{"room-s", 10, 1, {rates}}}, .outside = "Embree"};
}

TEST(TraceBench, the_table_has_rates_and_our_own_over_theirs) {
    const std::string table = trace_bench_table(report_with(1.0));
    for (const char* part : {"core-second", "compute/pipeline", "compute/Embree", " 2.50 ", " 0.50 ", "5.000"}) EXPECT_NE(table.find(part), std::string::npos) << part << "\n" << table;
}

TEST(TraceBench, tracers_that_disagree_are_an_error_that_says_where) {
    check_agreement(report_with(0.99999));
    try {
        check_agreement(report_with(0.9999));
        FAIL();
    } catch (const Error& error) {
        EXPECT_NE(error.line.find("room-s: compute and pipeline differ on 0.0100 % of the primary rays"), std::string::npos) << error.line;
    }
}

}  // namespace
}  // namespace parhelion::testing::trace_choice_test
