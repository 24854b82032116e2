// A lost device is reported with the last pass that it completed.
#include "base/error.h"
#include "frame/frame.h"
#include "gpu/internal.h"
#include "support/gpu_fixture.h"

namespace parhelion::testing::device_loss_test {

class DeviceLoss : public GpuTest {};

TEST_F(DeviceLoss, the_error_names_the_device_and_the_last_completed_pass) {
    const gpu::DevicePtr lost = gpu::Device::open({.selector = std::to_string(device()->caps().index)});
    Frame frame(lost, {}, test_shader_pack());
    struct FillPush {
        uint64_t out_values = 0;
        uint32_t base = 0, count = 64;
    };
    const gpu::Buffer values = frame.buffer("test/values", 64 * sizeof(uint32_t));
    frame.fill(values, 0);
    frame.compute("device/frame_fill").write("out_values", values).push(FillPush{}).over(64);
    const gpu::Ticket ticket = frame.submit();
    lost->wait_idle();  // all passes are done; then the device is lost
    gpu::Device::Impl& impl = lost->impl();
    const PFN_vkWaitSemaphores wait_function = impl.vk.vkWaitSemaphores;
    impl.vk.vkWaitSemaphores = [](VkDevice, const VkSemaphoreWaitInfo*, uint64_t) { return VK_ERROR_DEVICE_LOST; };
    try {
        frame.wait(ticket);
        ADD_FAILURE() << "no error";
    } catch (const Error& error) {
        const std::string line = error.what();
        EXPECT_EQ(error.code, ErrorCode::Failed);
        EXPECT_NE(line.find(lost->caps().name), std::string::npos) << line;
        EXPECT_NE(line.find("after pass device/frame_fill"), std::string::npos) << line;
    }
    impl.vk.vkWaitSemaphores = wait_function;
}

}  // namespace parhelion::testing::device_loss_test
