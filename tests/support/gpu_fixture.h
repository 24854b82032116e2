#pragma once
// What device and render tests share: one device a process (validation on where the layers are installed), its Frame, and the
// rules of skipping. PARHELION_REQUIRE=device,query,pipeline,compute,validation makes a missing thing a failure; a way to trace that
// PARHELION_MASK hides is not missing.
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "frame/frame.h"
#include "gpu/command_list.h"

namespace parhelion::testing {

bool is_required(std::string_view what);

// The process's device; nullptr if the machine has none.
const gpu::DevicePtr& shared_device();
bool shared_device_validates();  // the validation layers are installed and on
const gpu::ShaderPack& test_shader_pack();  // tests/device/shaders, names "device/<file>"

// Runs a test on the shared device; skips (or fails, if required) without one, and fails on any validation message.
class GpuTest : public ::testing::Test {
protected:
    void SetUp() override;
    void TearDown() override;
    const gpu::DevicePtr& device() const { return shared_device(); }

    template <class T>
    gpu::Buffer upload(std::string name, std::span<const T> data) {
        gpu::Buffer buffer(device(), "test/" + name, data.size_bytes());
        Frame frame(device());
        frame.upload(buffer, 0, std::as_bytes(data));
        frame.run();
        return buffer;
    }
    template <class T>
    std::vector<T> download(const gpu::Buffer& buffer) {
        Frame frame(device());
        const gpu::Buffer copy = frame.read_back(buffer);
        frame.run();
        const std::span<T> data = copy.mapped_as<T>();
        return {data.begin(), data.end()};
    }
    // Skips the test unless the device can trace this way.
    void require_way(gpu::TraceWay way);

private:
    uint64_t messages_before_ = 0;
};

}  // namespace parhelion::testing

#define PARHELION_REQUIRE_WAY(way)                                                       \
    do {                                                                                 \
        require_way(way);                                                                \
        if (IsSkipped() || HasFatalFailure()) return;                                    \
    } while (false)
