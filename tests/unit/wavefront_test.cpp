// The wavefront's memory and settings.
#include <gtest/gtest.h>

#include "base/error.h"
#include "gpu/device_class.h"
#include "passes/wavefront/wavefront.h"
#include "session/render_settings.h"

namespace parhelion::wavefront_test {
namespace {

TEST(WavefrontState, a_path_takes_at_most_200_bytes_in_every_machine_of_one_vertex_a_round) {
    for (const bool classes : {false, true})
        for (const bool extra : {false, true})
            for (const bool indirect : {false, true}) {
                const passes::WavefrontShape shape{.slots = 1, .classes = classes, .indirect = indirect, .extra = extra};
                EXPECT_GE(passes::state_bytes(shape), 32u + 12u + 16u + 16u + 32u + 32u) << "ray, hit, path, slot, vertex, shadow ray";
                EXPECT_LE(passes::state_bytes(shape), 200u) << classes << extra << indirect;
                passes::WavefrontShape split = shape;
                split.split = true;
                EXPECT_EQ(passes::state_bytes(split), passes::state_bytes(shape) + 2 * sizeof(shared::WavefrontSplit) + sizeof(shared::WavefrontClassSums));
            }
}

TEST(WavefrontState, each_vertex_that_waits_for_connect_takes_as_much_again) {
    passes::WavefrontShape shape{.slots = 1};
    const uint64_t one = passes::state_bytes(shape);
    shape.round_length = 5;
    EXPECT_EQ(passes::state_bytes(shape), one + 4 * (sizeof(shared::WavefrontVertex) + sizeof(shared::WavefrontShadowRay) + sizeof(uint32_t)));
}

// A frame of 8K would take 6.6 GB if every pixel had a path.
TEST(WavefrontState, the_paths_of_no_class_of_devices_take_more_than_a_gigabyte) {
    for (const gpu::DeviceClass& device : gpu::device_classes()) {
        EXPECT_GT(device.wavefront_slots, 0u) << device.name;
        EXPECT_LE(device.wavefront_slots, kMaxWavefrontSlots) << device.name;
        EXPECT_LE(200ull * device.wavefront_slots, 1ull << 30) << device.name;
    }
}

TEST(WavefrontSettings, options_are_what_the_settings_say) {
    RenderSettings settings;
    WavefrontOptions options = wavefront_options(settings);
    EXPECT_EQ(options.slots, 0u);
    EXPECT_EQ(options.connect, ConnectWhen::Once);
    EXPECT_EQ(options.dispatch, WavefrontDispatch::Indirect);
    EXPECT_TRUE(options.classes);
    EXPECT_EQ(options.memory_bytes, 512ull << 20);
    EXPECT_EQ(options.shadow_capacity, 0u) << "room for all that can come";
    for (const char* assignment : {"wavefront.slots=37", "wavefront.connect=each_bounce", "wavefront.dispatch=full", "wavefront.classes=off", "wavefront.memory_mb=5000"}) apply_assignment(settings, assignment);
    options = wavefront_options(settings);
    EXPECT_EQ(options.slots, 37u);
    EXPECT_EQ(options.connect, ConnectWhen::EachBounce);
    EXPECT_EQ(options.dispatch, WavefrontDispatch::Full);
    EXPECT_FALSE(options.classes);
    EXPECT_EQ(options.memory_bytes, 5000ull << 20);
}

TEST(WavefrontSettings, wrong_ones_are_named) {
    for (const char* assignment : {"wavefront.slots=4194305", "wavefront.slots=-1", "wavefront.connect=twice", "wavefront.dispatch=direct", "wavefront.classes=maybe", "wavefront.memory_mb=0"}) {
        RenderSettings settings;
        try {
            apply_assignment(settings, assignment);
            ADD_FAILURE() << assignment << " is accepted";
        } catch (const Error& error) {
            EXPECT_EQ(error.code, ErrorCode::Usage) << assignment;
            EXPECT_NE(error.line.find(std::string(assignment).substr(0, std::string(assignment).find('='))), std::string::npos) << error.line;
        }
    }
}

}  // namespace
}  // namespace parhelion::wavefront_test
