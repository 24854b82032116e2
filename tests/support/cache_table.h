#pragma once
// A world cache without a scene: given points ask it (tests/device/shaders/cache_ask.comp), and its table is read back whole.
#include <map>

#include "passes/cache/cache.h"
#include "support/render_fixture.h"

namespace parhelion::testing {

struct CacheAsk {
    glm::vec3 position_ws{0.0f}, n_ws{0.0f, 1.0f, 0.0f}, back_ws{3.0f, 5.0f, 4.0f};
    uint32_t owner = 0;
    float footprint = 1.0f, u = 0.5f;
    uint32_t life = 10;
};
struct CacheAnswer {
    glm::vec3 irradiance;
    uint32_t known, id, level, count, age, life;

    friend bool operator==(const CacheAnswer&, const CacheAnswer&) = default;
};

// What lies in one slot.
struct CacheCell {
    uint64_t key = 0, claim = 0, irradiance = 0;
    uint32_t moments = 0, slot = 0;
};

// The table as it lies in memory.
class CacheTable {
public:
    CacheTable(Frame& frame, const LightCache& cache) {
        const gpu::Buffer copy = frame.read_back(cache.buffer());
        frame.run();
        bytes_.assign(copy.mapped(), copy.mapped() + cache.buffer().bytes());
        address_ = cache.buffer().address();
    }
    const shared::CacheHeader& header() const { return *reinterpret_cast<const shared::CacheHeader*>(bytes_.data()); }
    template <class T>
    const T* at(uint64_t address) const {
        return reinterpret_cast<const T*>(bytes_.data() + (address - address_));
    }
    CacheCell cell(uint32_t slot) const {
        const shared::CacheHeader& h = header();
        return {at<uint64_t>(h.keys)[slot], at<uint64_t>(h.claims)[slot], at<uint64_t>(h.irradiance)[slot], at<uint32_t>(h.moments)[slot], slot};
    }
    std::vector<uint32_t> live() const {
        const uint32_t* list = at<uint32_t>(header().lists[header().list]);
        return {list, list + header().live};
    }
    // By key, and held to be what a table must be: every key once, in its bucket, and in the list of live cells.
    std::map<uint64_t, CacheCell> cells() const;

private:
    std::vector<std::byte> bytes_;
    uint64_t address_ = 0;
};

// A cache whose frames are: its passes, `irradiance` in place of rays, then `asks`.
class CacheBench {
public:
    explicit CacheBench(const CacheOptions& options, const FrameOptions& frame_options = {})
        : frame(shared_device(), frame_options, joint_shader_pack()), cache(shared_device(), options) {}

    std::vector<CacheAnswer> step(const std::vector<CacheAsk>& asks);
    CacheTable table() { return CacheTable(frame, cache); }
    CacheStats stats() { return cache.read_stats(frame); }

    Frame frame;
    LightCache cache;
    passes::CacheFrame next{.frame_index = 1};
    glm::vec3 irradiance{1.0f};
};

}  // namespace parhelion::testing
