#include "support/cache_table.h"

#include "lib/cache_cell.glsl"

namespace parhelion::testing {

std::map<uint64_t, CacheCell> CacheTable::cells() const {
    std::map<uint64_t, CacheCell> out;
    const shared::CacheHeader& h = header();
    std::vector<bool> listed(h.slot_count, false);
    for (const uint32_t slot : live()) {
        if (slot >= h.slot_count || listed[slot]) {
            ADD_FAILURE() << "slot " << slot << " is in the list twice, or no slot";
            return out;
        }
        listed[slot] = true;
    }
    size_t misplaced = 0, unlisted = 0, twice = 0;
    for (uint32_t slot = 0; slot < h.slot_count; ++slot) {
        const CacheCell there = cell(slot);
        const bool exists = there.key != shared::kCacheNoKey;
        unlisted += exists != listed[slot];
        if (!exists) continue;
        const uint64_t key = there.key & ~shared::kCacheNewborn;
        misplaced += shared::cache_bucket(key, h.bucket_mask) != slot / shared::kCacheBucket;
        twice += !out.emplace(key, there).second;
    }
    EXPECT_EQ(misplaced, 0u) << "keys outside their buckets";
    EXPECT_EQ(unlisted, 0u) << "slots that live without being listed, or the reverse";
    EXPECT_EQ(twice, 0u) << "keys that are there twice";
    return out;
}

std::vector<CacheAnswer> CacheBench::step(const std::vector<CacheAsk>& asks) {
    struct AskPush {
        uint64_t asks, answers, cache;
        uint32_t count;
    };
    struct SamplePush {
        uint64_t cache, found, passing;
        glm::vec3 irradiance;
    };
    passes::begin_cache(frame, gpu::TraceWay::Compute, cache, next);
    ++next.frame_index;
    frame.compute("device/cache_sample")
        .read("cache", cache.buffer())
        .write("found", cache.updates().found)
        .write("passing", cache.updates().passing)
        .push(SamplePush{.irradiance = irradiance})
        .over(cache.layout().update_capacity);
    passes::blend_cache(frame, cache);
    if (asks.empty()) {
        frame.run();
        return {};
    }
    const gpu::Buffer input(frame.device(), "test/asks", asks.size() * sizeof(CacheAsk)), output(frame.device(), "test/answers", asks.size() * sizeof(CacheAnswer));
    frame.upload(input, 0, std::as_bytes(std::span(asks)));
    frame.compute("device/cache_ask")
        .read("asks", input)
        .write("answers", output)
        .read_write("cache", cache.buffer())
        .push(AskPush{.count = static_cast<uint32_t>(asks.size())})
        .over(static_cast<uint32_t>(asks.size()));
    const gpu::Buffer copy = frame.read_back(output);
    frame.run();
    const auto found = copy.mapped_as<CacheAnswer>();
    return {found.begin(), found.end()};
}

}  // namespace parhelion::testing
