#pragma once
// What all sorts of programs are made of (gpu/program.cpp).
#include <functional>

#include "gpu/internal.h"

namespace parhelion::gpu {

[[noreturn]] void fail(const ShaderCode& code, const std::string& what);
// Throws Error if the pack has no such shader.
const ShaderCode& require(const ShaderPack& pack, std::string_view name, std::string_view variant, Stage stage);
// Set 0 must be the scene set, set 1 must fit a push descriptor set, and there is no other but the outputs.
void check_bindings(const Device::Impl& device, const ShaderCode& code);
bool sees_scene(const ShaderCode& code);
// Of data.code; push constants go to data.push_stages.
void make_layouts(Device::Impl& device, Program::Data& data, VkShaderStageFlags set1_stages);

// Lives as long as the pipeline is being made.
struct ShaderModule {
    Device::Impl& device;
    VkShaderModule handle = nullptr;
    ShaderModule(Device::Impl& owner, const ShaderCode& code);
    ShaderModule(const ShaderModule&) = delete;
    ShaderModule& operator=(const ShaderModule&) = delete;
    ~ShaderModule();
};
VkPipelineShaderStageCreateInfo stage_info(const ShaderModule& module, Stage stage);

// The device's program of this key, made if it has none. The device owns it; what is returned keeps the device.
std::shared_ptr<Program::Data> keep_program(const DevicePtr& device, const std::pair<uint64_t, std::string>& key,
                                            const std::function<std::shared_ptr<Program::Data>()>& make);

}  // namespace parhelion::gpu
