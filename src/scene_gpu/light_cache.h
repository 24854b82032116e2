#pragma once
// The world cache's storage: a hash table of cells with the irradiance at them, in one buffer (shared/cache.h). Each view has its
// own: cells are sized by its pixels and pre-exposed as it is. passes/cache keeps it current; shaders/scene/cache.glsl asks it. docs/world-cache.md.
#include <cstdint>
#include <optional>
#include <utility>

#include "frame/frame.h"
#include "shared/cache.h"

namespace parhelion {

struct CacheOptions {
    uint32_t cells = 1u << 18;     // that there is room for; made a power of two
    uint32_t life = 10;            // frames that a cell lives on after a pixel asked for it
    uint32_t budget = 40000;       // cells that are updated in a frame, at most a quarter of the room
    uint32_t samples = 32;         // that a cell's running mean is worth at most
    uint32_t candidates = 8;       // lights that one choice is made among
    float cell_scale = 0.25f;      // size of a cell over the footprint that asks for it
    float cell_pixels = 8.0f;      // least size of a cell, in pixels of who looks at it
    float jitter = 1.0f;           // of look-ups, in cells: blends neighbours
    uint32_t change_frames = 16;   // frames after a change of the lights in which means are short

    bool operator==(const CacheOptions&) const = default;
};

// What happened to the cells since the last frame's end, as of the last frame that is done.
struct CacheStats {
    uint32_t live = 0, updated = 0;
    uint32_t born = 0, died = 0;
    uint32_t rejected = 0;  // came in and went again, because their bucket overflowed
    uint32_t refused = 0;   // askings that found no place
    uint64_t path_rays = 0, shadow_rays = 0;
};

// What updates need between their passes, 204 bytes for each cell that one frame updates. Apart, so that passes that share nothing need not wait for each other.
struct CacheUpdateBuffers {
    gpu::Buffer lists;       // uint[2][updates]: whose paths go on, of rounds by turns
    gpu::Buffer rays, paths, hits;  // shared::WavefrontRay, CachePath, WavefrontHit
    gpu::Buffer found;       // shared::CacheUpdate
    gpu::Buffer light_rays;  // shared::WavefrontShadowRay: to the light that was chosen
    gpu::Buffer passing;     // vec4: what of it arrives, and how many rays that took
};

class LightCache {
public:
    static constexpr uint32_t kLeastCells = 1u << 10, kMostCells = 1u << 24;

    // Whether the device has what the cache needs: 64-bit atomics on buffers.
    static bool supported(const gpu::DeviceCaps& caps) { return caps.buffer_int64_atomics; }

    // Throws Error: a device without them (MissingFeature), or without the memory.
    LightCache(const gpu::DevicePtr& device, const CacheOptions& options);

    // Of the program: what shaders bind as `cache`.
    const gpu::Buffer& buffer() const { return buffer_; }
    const gpu::Buffer& sizes() const { return sizes_; }  // shared::CacheSize[]: work sizes of its passes
    const CacheOptions& options() const { return options_; }
    uint32_t slot_count() const { return header_.slot_count; }
    const CacheUpdateBuffers& updates() const { return updates_; }
    uint64_t bytes() const { return buffer_.bytes(); }
    const shared::CacheHeader& layout() const { return header_; }  // addresses and sizes; the rest is as of an empty cache

    // Forgets everything: the next frame begins with an empty table.
    void reset() { empty_ = true; }
    bool take_empty() { return std::exchange(empty_, false); }  // whether the table must be emptied before it is used

    // What the coming frame gives the shaders. `exposure`: what stored radiance is multiplied by, from now on; `lights_changed`: a light has
    // been switched, moved or painted, so cells do not wait until each has noticed; `lights_switched`: one that matters has, so they begin anew.
    shared::CacheFrameData begin_frame(uint32_t frame_index, uint32_t seed, float exposure, bool lights_changed, bool lights_switched);

    // Waits for the frames before.
    CacheStats read_stats(Frame& frame) const;

private:
    CacheOptions options_;
    shared::CacheHeader header_{};
    gpu::Buffer buffer_, sizes_;
    CacheUpdateBuffers updates_;
    bool empty_ = true;
    std::optional<float> exposure_;
    uint32_t quick_frames_ = 0;    // that are left in which means are short,
    uint32_t frames_to_anew_ = 0;  // and before cells may begin anew again: a lamp that fades is not switched in every frame
};

}  // namespace parhelion
