// Devices: several in one process, borrowed ones, without ray tracing, with validation; the pipeline cache.
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "base/file.h"
#include "base/hash.h"
#include "gpu/internal.h"
#include "support/gpu_helpers.h"

namespace parhelion::testing::gpu_devices_test {
namespace {

using namespace gpu;

class GpuDevices : public GpuTest {
protected:
    std::string same() const { return std::to_string(device()->caps().index); }

    void expect_sums(const DevicePtr& on) {
        const std::vector<uint32_t> sums = add_on(on, 500);
        for (uint32_t i = 0; i < sums.size(); ++i) ASSERT_EQ(sums[i], i + 1000);
    }
};

TEST_F(GpuDevices, the_enumeration_lists_the_open_device) {
    const std::vector<DeviceCaps> all = enumerate_devices();
    ASSERT_LT(device()->caps().index, all.size());
    const DeviceCaps& caps = all[device()->caps().index];
    EXPECT_EQ(caps.name, device()->caps().name);
    EXPECT_TRUE(caps.usable());
    EXPECT_FALSE(caps.driver.empty());
    EXPECT_GE(caps.api_version, VK_API_VERSION_1_3);
    EXPECT_GE(caps.max_push_constant_bytes, 128u);
    EXPECT_GE(caps.max_bindless_textures, 4096u);
    EXPECT_GT(caps.memory_bytes, 0u);
    EXPECT_GT(caps.subgroup_size, 0u);
}

TEST_F(GpuDevices, an_unknown_device_is_a_usage_error) {
    const Error error = error_of([] { Device::open({.selector = "no such device"}); });
    EXPECT_EQ(error.code, ErrorCode::Usage);
    EXPECT_NE(error.line.find(device()->caps().name), std::string::npos) << error.line;
}

TEST_F(GpuDevices, two_devices_live_in_one_process) {
    DevicePtr first = Device::open({.selector = same()});
    const DevicePtr second = Device::open({.selector = same(), .validate = shared_device_validates()});
    EXPECT_NE(first->impl().device, second->impl().device);
    expect_sums(first);
    expect_sums(second);
    const Buffer kept(first, "test/kept", 64);
    const std::weak_ptr<Device> alive = first;
    first.reset();
    EXPECT_FALSE(alive.expired()) << "a resource keeps its device";
    expect_sums(second);
    EXPECT_EQ(second->validation_message_count(), 0u);
}

TEST_F(GpuDevices, handles_keep_their_device_and_all_is_given_back) {
    std::weak_ptr<Device> alive;
    {
        Program program;
        Sampler sampler;
        {
            const DevicePtr own = Device::open({.selector = same(), .validate = shared_device_validates()});
            alive = own;
            program = Program::get(own, test_shader_pack(), "device/gpu_add", "", false);
            sampler = Sampler(own, {});
        }
        EXPECT_FALSE(alive.expired());
        EXPECT_EQ(program.code().name, "device/gpu_add");
    }
    EXPECT_TRUE(alive.expired());
}

TEST_F(GpuDevices, ray_tracing_can_be_masked) {
    const DevicePtr masked = Device::open({.selector = same(), .validate = shared_device_validates(), .mask_ray_tracing = true});
    EXPECT_FALSE(masked->caps().supports(TraceWay::Pipeline));
    EXPECT_FALSE(masked->caps().supports(TraceWay::Query));
    EXPECT_TRUE(masked->caps().supports(TraceWay::Compute));
    EXPECT_EQ(masked->impl().vk.vkCreateAccelerationStructureKHR, nullptr);
    expect_sums(masked);
    EXPECT_THROW(AccelStruct::top(masked, "test/top", 1), Error);
    EXPECT_EQ(error_of([&] { Program::get(masked, test_shader_pack(), "device/gpu_trace", "query", false); }).code, ErrorCode::MissingFeature);
    EXPECT_NO_THROW(Program::get(masked, test_shader_pack(), "device/gpu_trace", "compute", false));
    EXPECT_EQ(masked->validation_message_count(), 0u);
}

// One way alone can be masked too, for every device that a program sees.
TEST_F(GpuDevices, the_environment_masks_ways_to_trace) {
    const char* before = std::getenv("PARHELION_MASK");
    const std::string kept = before ? before : "";
    const auto ways = [&](const char* mask) {
        setenv("PARHELION_MASK", mask, 1);
        const DeviceCaps caps = enumerate_devices().at(device()->caps().index);
        return std::pair(caps.ray_pipeline, caps.ray_query);
    };
    const auto [pipeline, query] = ways("");
    EXPECT_EQ(ways("pipeline"), std::pair(false, query));
    EXPECT_EQ(ways("query"), std::pair(pipeline, false));
    EXPECT_EQ(ways("query,pipeline"), std::pair(false, false));
    EXPECT_FALSE(Device::open({.selector = same()})->caps().supports(TraceWay::Query));
    setenv("PARHELION_MASK", "pipeline,rays", 1);
    const Error error = error_of([] { enumerate_devices(); });
    EXPECT_EQ(error.code, ErrorCode::Usage);
    EXPECT_NE(error.line.find("PARHELION_MASK"), std::string::npos) << error.line;
    if (before) setenv("PARHELION_MASK", kept.c_str(), 1);
    else unsetenv("PARHELION_MASK");
}

// Shows that silence of the layers means something: a missing barrier between two writes must be heard.
TEST_F(GpuDevices, a_missing_barrier_is_counted_by_validation) {
    DevicePtr validated;
    try {
        validated = Device::open({.selector = same(), .validate = true});
    } catch (const Error& error) {
        if (is_required("validation")) FAIL() << error.what();
        GTEST_SKIP() << error.what();
    }
    const Buffer buffer(validated, "test/twice", 256);
    CommandList commands(validated);
    commands.fill(buffer, 0, 256, 1);
    commands.fill(buffer, 0, 256, 2);
    wait(validated, submit(validated, std::move(commands)));
    EXPECT_EQ(validated->validation_message_count(), 1u);
    ASSERT_EQ(validated->validation_messages().size(), 1u);
    EXPECT_NE(validated->validation_messages()[0].find("SYNC-HAZARD-WRITE-AFTER-WRITE"), std::string::npos) << validated->validation_messages()[0];
}

// A host program: its own instance (with validation), device, queue, command pool and image.
struct Host {
    std::shared_ptr<Instance> instance;
    VkPhysicalDevice physical = nullptr;
    VkDevice device = nullptr;
    VkQueue queue = nullptr;
    uint32_t family = 0;
    DeviceFunctions vk;
    VkCommandPool pool = nullptr;
    VkCommandBuffer commands = nullptr;
    VkImage image = nullptr;
    VkDeviceMemory memory = nullptr;

    explicit Host(uint32_t index) {
        try {
            instance = create_instance(true);
        } catch (const Error&) {
            instance = create_instance(false);
        }
        physical = instance->physical_devices().at(index);
        const std::vector<std::string> names = device_extensions(instance->handle, physical);
        std::vector<const char*> extensions;
        for (const std::string& name : names) extensions.push_back(name.c_str());
        const std::shared_ptr<const void> features = device_features(instance->handle, physical);
        const float priority = 1;
        family = inspect(*instance, physical, 0, false).queue_family;
        VkDeviceQueueCreateInfo queue_info{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, nullptr, 0, family, 1, &priority};
        VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, features.get(), 0, 1, &queue_info, 0, nullptr, static_cast<uint32_t>(extensions.size()), extensions.data()};
        PARHELION_VK("host", instance->vk.vkCreateDevice(physical, &info, nullptr, &device));
#define PARHELION_LOAD(name) vk.name = reinterpret_cast<PFN_##name>(instance->vk.vkGetDeviceProcAddr(device, #name));
        PARHELION_DEVICE_FUNCTIONS(PARHELION_LOAD)
#undef PARHELION_LOAD
        vk.vkGetDeviceQueue(device, family, 0, &queue);
        const VkCommandPoolCreateInfo pool_info{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, nullptr, 0, family};
        PARHELION_VK("host", vk.vkCreateCommandPool(device, &pool_info, nullptr, &pool));
        const VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, nullptr, pool, VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1};
        PARHELION_VK("host", vk.vkAllocateCommandBuffers(device, &allocate, &commands));
    }
    ~Host() {
        vk.vkDestroyImage(device, image, nullptr);
        vk.vkFreeMemory(device, memory, nullptr);
        vk.vkDestroyCommandPool(device, pool, nullptr);
        vk.vkDestroyDevice(device, nullptr);
    }
    Host(const Host&) = delete;
    Host& operator=(const Host&) = delete;

    void make_image(uint32_t side) {
        VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO, nullptr, 0, VK_IMAGE_TYPE_2D, VK_FORMAT_R32G32B32A32_SFLOAT, {side, side, 1}, 1, 1, VK_SAMPLE_COUNT_1_BIT};
        info.usage = VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
        PARHELION_VK("host", vk.vkCreateImage(device, &info, nullptr, &image));
        VkMemoryRequirements needs{};
        vk.vkGetImageMemoryRequirements(device, image, &needs);
        const VkMemoryAllocateInfo allocate{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr, needs.size, static_cast<uint32_t>(std::countr_zero(needs.memoryTypeBits))};
        PARHELION_VK("host", vk.vkAllocateMemory(device, &allocate, nullptr, &memory));
        PARHELION_VK("host", vk.vkBindImageMemory(device, image, memory, 0));
    }
    void begin() {
        const VkCommandBufferBeginInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
        PARHELION_VK("host", vk.vkBeginCommandBuffer(commands, &info));
        VkImageMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2, nullptr, 0, 0, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT};
        barrier.newLayout = VK_IMAGE_LAYOUT_GENERAL;
        barrier.image = image;
        barrier.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
        VkDependencyInfo dependency{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
        dependency.imageMemoryBarrierCount = 1;
        dependency.pImageMemoryBarriers = &barrier;
        vk.vkCmdPipelineBarrier2(commands, &dependency);
    }
    void submit_and_wait() {
        PARHELION_VK("host", vk.vkEndCommandBuffer(commands));
        const VkCommandBufferSubmitInfo buffer{VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO, nullptr, commands, 0};
        VkSubmitInfo2 info{VK_STRUCTURE_TYPE_SUBMIT_INFO_2};
        info.commandBufferInfoCount = 1;
        info.pCommandBufferInfos = &buffer;
        PARHELION_VK("host", vk.vkQueueSubmit2(queue, 1, &info, nullptr));
        PARHELION_VK("host", vk.vkDeviceWaitIdle(device));
    }
};

TEST_F(GpuDevices, a_borrowed_device_works_and_stays_the_hosts) {
    std::shared_ptr<Instance> instance;
    {
        Host host(device()->caps().index);
        instance = host.instance;
        host.make_image(16);
        const DeviceCaps& caps = device()->caps();
        BorrowedDevice handles{host.instance->handle, host.physical, host.device, host.queue, host.family, caps.ray_pipeline, caps.ray_query, caps.block_compression,
                               caps.raster, caps.draw_indirect_count, caps.buffer_int64_atomics, nullptr};
        handles.get_instance_proc_addr = reinterpret_cast<void* (*)(VkInstance, const char*)>(host.instance->vk.vkGetInstanceProcAddr);
        {
            const DevicePtr borrowed = Device::borrow(handles);
            EXPECT_EQ(borrowed->caps().name, caps.name);
            EXPECT_EQ(borrowed->caps().ray_query, caps.ray_query);
            expect_sums(borrowed);

            const Buffer values = mapped_buffer(borrowed, numbers(256)), sums(borrowed, "test/sums", 1024), back(borrowed, "test/back", 4096, MemoryKind::Readback);
            const Image picture = Image::borrow(borrowed, "host/picture", {.extent = {16, 16}}, host.image);
            EXPECT_FALSE(picture.needs_layout());
            host.begin();
            CommandList commands(borrowed, host.commands);
            const Binding bindings[] = {{0, BindingKind::StorageBuffer, sums, {}}, {1, BindingKind::StorageImage, picture, {}}};
            commands.bind(Program::get(borrowed, test_shader_pack(), "device/gpu_add", "", false), nullptr, bindings, bytes_of(AddPush{values.address(), 256, 9}));
            commands.dispatch(4, 1, 1);
            commands.barrier({{Use::ComputeWrite}, {Use::TransferRead}});
            commands.copy_from_image(picture, back, 0);
            commands.barrier({{Use::TransferWrite}, {Use::HostRead}});
            EXPECT_THROW(submit(borrowed, std::move(commands)), Error);
            host.submit_and_wait();
            for (uint32_t i = 0; i < 256; ++i) {
                ASSERT_FLOAT_EQ(back.mapped_as<float>()[4 * i], float(i));
                ASSERT_FLOAT_EQ(back.mapped_as<float>()[4 * i + 1], 9.0f);
            }
            handles.enabled_ray_pipeline = handles.enabled_ray_query = false;
            EXPECT_FALSE(Device::borrow(handles)->caps().supports(TraceWay::Query));
        }
        EXPECT_EQ(host.vk.vkDeviceWaitIdle(host.device), VK_SUCCESS) << "the host's device is still alive";
    }
    EXPECT_TRUE(instance->messages.empty()) << instance->messages[0];
}

// The cache folder for one test.
class PipelineCache : public GpuDevices {
protected:
    void SetUp() override {
        GpuDevices::SetUp();
        if (const char* old = std::getenv("PARHELION_CACHE_DIR")) old_ = old;
        folder_ = std::filesystem::temp_directory_path() / fmt::format("parhelion-cache-test-{}", platform_id());
        std::filesystem::remove_all(folder_);
        setenv("PARHELION_CACHE_DIR", folder_.c_str(), 1);
    }
    void TearDown() override {
        if (old_.empty()) unsetenv("PARHELION_CACHE_DIR");
        else setenv("PARHELION_CACHE_DIR", old_.c_str(), 1);
        std::filesystem::remove_all(folder_);
        GpuDevices::TearDown();
    }
    static uint64_t platform_id() { return reinterpret_cast<uintptr_t>(&test_shader_pack()); }

    // A driver's cache of 100 bytes with a right header, whatever the driver really keeps.
    static std::vector<std::byte>& fake() {
        static std::vector<std::byte> bytes(100);
        return bytes;
    }
    static VkResult give_fake(VkDevice, VkPipelineCache, size_t* size, void* data) {
        if (data) std::memcpy(data, fake().data(), fake().size());
        *size = fake().size();
        return VK_SUCCESS;
    }
    // Opens a device, closes it, and returns the hash of what it loaded.
    uint64_t open_and_close(bool fill) {
        const DevicePtr own = Device::open({.selector = same()});
        VkPipelineCacheHeaderVersionOne header{32, VK_PIPELINE_CACHE_HEADER_VERSION_ONE, own->caps().vendor_id, own->caps().device_id, {}};
        std::memcpy(header.pipelineCacheUUID, own->impl().physical.cache_uuid.data(), VK_UUID_SIZE);
        std::memcpy(fake().data(), &header, sizeof(header));
        if (fill) own->impl().vk.vkGetPipelineCacheData = give_fake;
        return own->impl().loaded_cache_hash;
    }

    std::filesystem::path folder_;
    std::string old_;
};

TEST_F(PipelineCache, it_is_kept_between_devices_and_a_damaged_one_is_not_used) {
    if (device()->caps().type != DeviceType::Cpu) GTEST_SKIP() << "made-up cache contents are given to the CPU driver only";
    const uint64_t none = hash_bytes(nullptr, 0);
    EXPECT_EQ(open_and_close(true), none);
    ASSERT_TRUE(std::filesystem::exists(folder_ / "pipelines"));
    const std::filesystem::path file = std::filesystem::directory_iterator(folder_ / "pipelines")->path();
    EXPECT_EQ(open_and_close(true), hash_bytes(fake().data(), fake().size()));
    const std::vector<std::byte> whole = read_file(file, 1 << 20);
    for (const size_t at : {size_t(0), size_t(9), size_t(25), whole.size() - 1}) {
        std::vector<std::byte> damaged = whole;
        damaged[at] ^= std::byte{1};
        write_file(file, damaged);
        EXPECT_EQ(open_and_close(false), none) << at;
    }
    write_file(file, std::span(whole).first(whole.size() - 1));
    EXPECT_EQ(open_and_close(false), none);
    write_file(file, std::span(whole).first(3));
    EXPECT_EQ(open_and_close(false), none);
}

TEST_F(PipelineCache, a_folder_that_cannot_be_written_breaks_nothing) {
    std::ofstream(folder_) << "a file, not a folder";
    EXPECT_NO_THROW(open_and_close(true));
    std::filesystem::remove(folder_);
    setenv("PARHELION_CACHE_DIR", "/proc/none", 1);
    EXPECT_NO_THROW(open_and_close(true));
}

}  // namespace
}  // namespace parhelion::testing::gpu_devices_test
