#include "scene_gpu/light_cache.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <string>

#include "base/error.h"

namespace parhelion {

LightCache::LightCache(const gpu::DevicePtr& device, const CacheOptions& options) : options_(options) {
    if (!supported(device->caps()))
        throw Error(ErrorCode::MissingFeature, "the world cache needs 64-bit atomics on buffers (shaderBufferInt64Atomics)", device->caps().name, "use realtime.cache=off");
    const uint32_t slots = std::bit_ceil(std::clamp(options.cells, kLeastCells, kMostCells)), updates = std::max(std::min(options.budget, slots / 4), 1u);
    uint64_t end = 0;
    const auto place = [&](uint64_t count, uint64_t bytes) {
        constexpr uint64_t kAlignment = 64;
        end = (end + kAlignment - 1) / kAlignment * kAlignment;
        return std::exchange(end, end + count * bytes);
    };
    place(1, sizeof(shared::CacheHeader));
    header_.keys = place(slots, sizeof(uint64_t));
    header_.claims = place(slots, sizeof(uint64_t));
    header_.irradiance = place(slots, sizeof(uint64_t));
    header_.moments = place(slots, sizeof(uint32_t));
    for (uint64_t& list : header_.lists) list = place(slots, sizeof(uint32_t));
    header_.buckets = place(slots / shared::kCacheBucket, sizeof(uint32_t));
    header_.updates = place(updates, sizeof(uint32_t));
    header_.kept = place(updates, sizeof(uint64_t));
    buffer_ = gpu::Buffer(device, "cache/cells", end);
    sizes_ = gpu::Buffer(device, "cache/sizes", shared::kCacheSizeCount * sizeof(shared::CacheSize));
    for (uint64_t* address : {&header_.keys, &header_.claims, &header_.irradiance, &header_.moments, &header_.lists[0], &header_.lists[1], &header_.buckets,
                              &header_.updates, &header_.kept})
        *address += buffer_.address();
    header_.slot_count = slots;
    header_.bucket_mask = slots / shared::kCacheBucket - 1;
    header_.update_capacity = updates;
    const auto buffer = [&](const char* name, uint64_t bytes) { return gpu::Buffer(device, std::string("cache/") + name, updates * bytes); };
    updates_ = {.lists = buffer("path_lists", 2 * sizeof(uint32_t)),
                .rays = buffer("rays", sizeof(shared::WavefrontRay)),
                .paths = buffer("paths", sizeof(shared::CachePath)),
                .hits = buffer("hits", sizeof(shared::WavefrontHit)),
                .found = buffer("found", sizeof(shared::CacheUpdate)),
                .light_rays = buffer("light_rays", sizeof(shared::WavefrontShadowRay)),
                .passing = buffer("passing", sizeof(glm::vec4))};
}

shared::CacheFrameData LightCache::begin_frame(uint32_t frame_index, uint32_t seed, float exposure, bool lights_changed, bool lights_switched) {
    constexpr uint32_t kQuickSamples = 2;
    quick_frames_ = lights_changed ? options_.change_frames : quick_frames_ - std::min(quick_frames_, 1u);
    const bool forgets = lights_switched && frames_to_anew_ == 0;
    frames_to_anew_ = forgets ? options_.change_frames : frames_to_anew_ - std::min(frames_to_anew_, 1u);
    const float ratio = exposure / exposure_.value_or(exposure);
    exposure_ = exposure;
    return {.frame_index = frame_index,
            .seed = seed,
            .exposure = exposure,
            .exposure_ratio = ratio,
            .cell_scale = options_.cell_scale,
            .cell_pixels = options_.cell_pixels,
            .jitter = options_.jitter,
            .life = options_.life,
            .most_samples = quick_frames_ != 0 ? std::min(options_.samples, kQuickSamples) : options_.samples,
            .candidates = options_.candidates,
            .forgets = forgets ? 1u : 0u};
}

CacheStats LightCache::read_stats(Frame& frame) const {
    const gpu::Buffer head(frame.device(), "cache/head", sizeof(shared::CacheHeader));
    frame.copy(buffer_, 0, head, 0, sizeof(shared::CacheHeader));
    const gpu::Buffer copy = frame.read_back(head);
    frame.run();
    const shared::CacheHeader& now = copy.mapped_as<shared::CacheHeader>()[0];
    return {.live = now.live,
            .updated = now.update_count,
            .born = now.born,
            .died = now.died,
            .rejected = now.rejected,
            .refused = now.refused,
            .path_rays = std::accumulate(std::begin(now.path_count), std::end(now.path_count), uint64_t{0}),
            .shadow_rays = now.shadow_rays};
}

}  // namespace parhelion
