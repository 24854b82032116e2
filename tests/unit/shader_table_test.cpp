// The shader binding table keeps every rule of Vulkan 1.3, 42.1 "Ray Tracing", for whatever limits a device has.
#include "gpu/shader_table.h"

#include <gtest/gtest.h>

namespace parhelion::gpu::shader_table_test {
namespace {

TEST(ShaderTable, records_and_regions_are_aligned_and_apart_for_any_limits) {
    for (const uint64_t handle : {16u, 32u, 48u, 64u})
        for (const uint64_t handle_alignment : {1u, 8u, 16u, 32u, 64u})
            for (const uint64_t base : {1u, 16u, 32u, 64u, 128u, 256u}) {
                SCOPED_TRACE(::testing::Message() << handle << " bytes, aligned to " << handle_alignment << ", regions to " << base);
                const ShaderTableLayout at = layout_shader_table(handle, handle_alignment, base);
                EXPECT_GE(at.stride, handle);
                EXPECT_EQ(at.stride % handle_alignment, 0u);
                EXPECT_LT(at.stride - handle, handle_alignment) << "no larger than needed";
                EXPECT_GE(at.base, 64u) << "a table for the strictest device is right for all";
                for (const uint64_t region : {at.raygen, at.miss, at.hit}) {
                    EXPECT_EQ(region % base, 0u);
                    EXPECT_EQ(region % at.base, 0u);
                }
                EXPECT_EQ(at.raygen, 0u);
                EXPECT_GE(at.miss, at.raygen + at.stride);
                EXPECT_EQ(at.shadow_miss, at.miss + at.stride) << "the second miss shader is found by the stride";
                EXPECT_GE(at.hit, at.shadow_miss + at.stride);
                EXPECT_EQ(at.bytes, at.hit + at.stride);
            }
}

TEST(ShaderTable, usual_devices_get_the_tables_that_they_are_known_for) {
    const ShaderTableLayout nvidia = layout_shader_table(32, 32, 64);
    EXPECT_EQ(nvidia.stride, 32u);
    EXPECT_EQ(nvidia.miss, 64u);
    EXPECT_EQ(nvidia.shadow_miss, 96u);
    EXPECT_EQ(nvidia.hit, 128u);
    EXPECT_EQ(nvidia.bytes, 160u);
}

}  // namespace
}  // namespace parhelion::gpu::shader_table_test
