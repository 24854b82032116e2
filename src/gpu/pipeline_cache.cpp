// The driver's pipeline cache, kept between runs in the cache folder: one file per device and driver, checked by a header and
// a checksum of ours because drivers trust what they are given. Every failure means no cache, never an error.
#include <cstring>
#include <filesystem>

#include "base/file.h"
#include "base/hash.h"
#include "base/log.h"
#include "base/platform.h"
#include "gpu/internal.h"

namespace parhelion::gpu {

namespace {

constexpr uint64_t kMaxBytes = 64ull << 20;

struct Header {
    char magic[8] = {'P', 'H', 'P', 'C', 'A', 'C', 'H', '1'};
    std::array<uint8_t, VK_UUID_SIZE> uuid{};
    uint64_t bytes = 0, checksum = 0;
};

std::filesystem::path cache_path(const Device::Impl& device) {
    std::string id;
    for (const uint8_t byte : device.physical.cache_uuid) id += fmt::format("{:02x}", byte);
    return platform::cache_folder() / "pipelines" / fmt::format("{:04x}-{:04x}-{}", device.physical.caps.vendor_id, device.physical.caps.device_id, id);
}

// The driver's bytes, empty if there is no intact file.
std::vector<std::byte> read_cache(const Device::Impl& device) {
    std::error_code error;
    const std::filesystem::path path = cache_path(device);
    if (!std::filesystem::is_regular_file(path, error)) return {};
    std::vector<std::byte> file = read_file(path, kMaxBytes + sizeof(Header));
    Header header, expected;
    if (file.size() < sizeof(header)) return {};
    std::memcpy(&header, file.data(), sizeof(header));
    file.erase(file.begin(), file.begin() + sizeof(header));
    const bool intact = std::memcmp(header.magic, expected.magic, sizeof(header.magic)) == 0 && header.uuid == device.physical.cache_uuid &&
                        header.bytes == file.size() && header.checksum == hash_bytes(file.data(), file.size());
    return intact ? file : std::vector<std::byte>{};
}

}  // namespace

void Device::Impl::load_pipeline_cache() {
    std::vector<std::byte> bytes;
    try {
        bytes = read_cache(*this);
    } catch (const std::exception& error) {
        log(LogLevel::Debug, "pipeline cache: {}", error.what());
    }
    loaded_cache_hash = hash_bytes(bytes.data(), bytes.size());
    VkPipelineCacheCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO};
    info.initialDataSize = bytes.size();
    info.pInitialData = bytes.data();
    if (vk.vkCreatePipelineCache(device, &info, nullptr, &pipeline_cache) != VK_SUCCESS) pipeline_cache = nullptr;
}

void Device::Impl::save_pipeline_cache() noexcept {
    try {
        size_t size = 0;
        if (vk.vkGetPipelineCacheData(device, pipeline_cache, &size, nullptr) != VK_SUCCESS || size == 0 || size > kMaxBytes) return;
        std::vector<std::byte> bytes(sizeof(Header) + size);
        if (vk.vkGetPipelineCacheData(device, pipeline_cache, &size, bytes.data() + sizeof(Header)) != VK_SUCCESS) return;
        bytes.resize(sizeof(Header) + size);
        Header header;
        header.uuid = physical.cache_uuid;
        header.bytes = size;
        header.checksum = hash_bytes(bytes.data() + sizeof(Header), size);
        // An empty cache is the driver's own header (Vulkan 1.3, table "Layout for pipeline cache header version one").
        if (header.checksum == loaded_cache_hash || size <= sizeof(VkPipelineCacheHeaderVersionOne)) return;
        std::memcpy(bytes.data(), &header, sizeof(header));
        const std::filesystem::path path = cache_path(*this);
        std::error_code error;
        std::filesystem::create_directories(path.parent_path(), error);
        write_file(path, bytes);
    } catch (const std::exception& error) {
        log(LogLevel::Debug, "pipeline cache: {}", error.what());
    } catch (...) {
    }
}

}  // namespace parhelion::gpu
