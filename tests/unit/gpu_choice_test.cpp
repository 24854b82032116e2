// Which device is taken, and how uses map to Vulkan: the parts of src/gpu that need no device.
#include <set>

#include <gtest/gtest.h>

#include "gpu/internal.h"
#include "support/gpu_helpers.h"

namespace parhelion::testing::gpu_choice_test {
namespace {

using gpu::DeviceCaps;
using gpu::DeviceType;
using gpu::Use;

std::vector<DeviceCaps> devices() {
    const auto make = [](uint32_t index, const char* name, DeviceType type, uint64_t gib, bool pipeline, bool query) {
        DeviceCaps caps;
        caps.index = index;
        caps.name = name;
        caps.type = type;
        caps.memory_bytes = gib << 30;
        caps.ray_pipeline = pipeline;
        caps.ray_query = query;
        return caps;
    };
    return {make(0, "llvmpipe (LLVM 15)", DeviceType::Cpu, 64, true, true), make(1, "Radeon iGPU", DeviceType::Integrated, 16, false, true),
            make(2, "GeForce A", DeviceType::Discrete, 24, false, false), make(3, "GeForce B", DeviceType::Discrete, 8, true, true)};
}

TEST(DeviceChoice, discrete_devices_with_more_ways_to_trace_win) {
    std::vector<DeviceCaps> all = devices();
    EXPECT_EQ(gpu::choose_best(all), 3u);
    all[2].ray_pipeline = all[2].ray_query = true;
    EXPECT_EQ(gpu::choose_best(all), 2u) << "more memory";
    all[3] = all[2];
    EXPECT_EQ(gpu::choose_best(all), 2u) << "the first of equals";
    all[2].missing = all[3].missing = {"shaderInt64"};
    EXPECT_EQ(gpu::choose_best(all), 1u) << "unusable ones are left out";
    all[1].missing = {"shaderInt64"};
    EXPECT_EQ(gpu::choose_best(all), 0u);
}

TEST(DeviceChoice, a_selector_is_an_index_or_a_part_of_a_name_in_any_case) {
    const std::vector<DeviceCaps> all = devices();
    EXPECT_EQ(gpu::choose(all, "0"), 0u);
    EXPECT_EQ(gpu::choose(all, "2"), 2u);
    EXPECT_EQ(gpu::choose(all, "LLVM"), 0u);
    EXPECT_EQ(gpu::choose(all, "radeon"), 1u);
    EXPECT_EQ(gpu::choose(all, "geforce"), 3u) << "the best of those that match";
    EXPECT_EQ(gpu::choose(all, ""), 3u);
}

TEST(DeviceChoice, an_unknown_selector_is_a_usage_error_that_lists_the_devices) {
    for (const char* selector : {"4", "arc", "1x", "-1"}) {
        const Error error = error_of([&] { gpu::choose(devices(), selector); });
        EXPECT_EQ(error.code, ErrorCode::Usage) << selector;
        EXPECT_NE(error.line.find("GeForce A"), std::string::npos) << error.line;
        EXPECT_NE(error.line.find("llvmpipe"), std::string::npos) << error.line;
        EXPECT_EQ(error.where, "--device");
    }
}

TEST(DeviceChoice, a_wrong_selector_is_blamed_on_who_gave_it) {
    EXPECT_EQ(error_of([&] { gpu::choose(devices(), "arc", "PARHELION_DEVICE"); }).where, "PARHELION_DEVICE");
}

TEST(DeviceChoice, without_a_usable_device_the_error_names_each_and_everything_it_lacks) {
    std::vector<DeviceCaps> all = devices();
    for (DeviceCaps& caps : all) caps.missing = {"shaderInt64", "maintenance4"};
    const Error error = error_of([&] { gpu::choose_best(all); });
    EXPECT_EQ(error.code, ErrorCode::MissingFeature);
    for (const char* part : {"Radeon iGPU lacks shaderInt64, maintenance4", "GeForce B lacks"}) EXPECT_NE(error.line.find(part), std::string::npos) << error.line;
    EXPECT_EQ(error_of([] { gpu::choose_best({}); }).code, ErrorCode::MissingFeature);
    EXPECT_EQ(error_of([&] { gpu::choose(all, "radeon"); }).code, ErrorCode::MissingFeature);
}

TEST(UseMapping, every_use_has_stages_and_access_that_agree_with_reading_and_writing) {
    constexpr VkAccessFlags2 kWrites = VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT | VK_ACCESS_2_HOST_WRITE_BIT |
                                       VK_ACCESS_2_ACCELERATION_STRUCTURE_WRITE_BIT_KHR | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT |
                                       VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
    std::set<std::string_view> names;
    for (uint32_t u = 0; u <= static_cast<uint32_t>(Use::HostWrite); ++u) {
        const Use use = static_cast<Use>(u);
        const gpu::StageAccess mapped = gpu::stage_access(use);
        EXPECT_NE(mapped.stages, 0u) << gpu::use_name(use);
        EXPECT_EQ((mapped.access & kWrites) != 0, gpu::use_writes(use)) << gpu::use_name(use);
        EXPECT_EQ((mapped.access & ~kWrites) != 0, gpu::use_reads(use)) << gpu::use_name(use);
        EXPECT_TRUE(names.insert(gpu::use_name(use)).second);
    }
}

TEST(Results, a_failed_call_is_named_with_its_result) {
    const Error error = error_of([] { gpu::check_result(VK_ERROR_TOO_MANY_OBJECTS, "impl.vk.vkCreateImage(impl.device, &info)", "GeForce A"); });
    EXPECT_EQ(error.line, "GeForce A: vkCreateImage failed with VK_ERROR_TOO_MANY_OBJECTS");
    EXPECT_EQ(error_of([] { gpu::check_result(VK_ERROR_DEVICE_LOST, "vkQueueSubmit2()", "GeForce A"); }).problem, "the device was lost");
    EXPECT_NO_THROW(gpu::check_result(VK_SUCCESS, "vkQueueSubmit2()", "GeForce A"));
}

}  // namespace
}  // namespace parhelion::testing::gpu_choice_test
