#pragma once
// Small pieces that the tests of src/gpu share.
#include <cstring>
#include <numeric>
#include <string>
#include <vector>

#include "base/error.h"
#include "support/gpu_fixture.h"

namespace parhelion::testing {

// The push constants of device/gpu_add.
struct AddPush {
    uint64_t values = 0;
    uint32_t count = 0, add = 0;
};

template <class T>
std::span<const std::byte> bytes_of(const T& value) {
    return std::as_bytes(std::span(&value, 1));
}

template <class T>
gpu::Buffer mapped_buffer(const gpu::DevicePtr& device, const std::vector<T>& values) {
    gpu::Buffer buffer(device, "test/upload", values.size() * sizeof(T), gpu::MemoryKind::Upload);
    std::memcpy(buffer.mapped(), values.data(), values.size() * sizeof(T));
    return buffer;
}

inline std::vector<uint32_t> numbers(size_t count, uint32_t first = 0) {
    std::vector<uint32_t> out(count);
    std::iota(out.begin(), out.end(), first);
    return out;
}

// Adds 1000 to `count` numbers on the device, by address, binding and push constants; returns the sums.
inline std::vector<uint32_t> add_on(const gpu::DevicePtr& device, uint32_t count) {
    const gpu::Buffer values = mapped_buffer(device, numbers(count)), sums(device, "test/sums", count * 4, gpu::MemoryKind::Readback);
    const gpu::Image picture(device, "test/picture", {.extent = {16, (count + 15) / 16}});
    gpu::CommandList commands(device);
    commands.initialise_layout(picture);
    const gpu::Binding bindings[] = {{0, gpu::BindingKind::StorageBuffer, sums, {}}, {1, gpu::BindingKind::StorageImage, picture, {}}};
    commands.bind(gpu::Program::get(device, test_shader_pack(), "device/gpu_add", "", false), nullptr, bindings, bytes_of(AddPush{values.address(), count, 1000}));
    commands.dispatch((count + 63) / 64, 1, 1);
    EXPECT_TRUE(gpu::wait(device, gpu::submit(device, std::move(commands))));
    const auto out = sums.mapped_as<uint32_t>();
    return {out.begin(), out.end()};
}

template <class Function>
Error error_of(Function function) {
    try {
        function();
    } catch (const Error& error) {
        return error;
    }
    return {ErrorCode::Failed, "nothing was thrown"};
}
template <class Function>
std::string error_line(Function function) {
    return error_of(function).line;
}

}  // namespace parhelion::testing
