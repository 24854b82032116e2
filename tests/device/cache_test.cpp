// The world cache's table, without rays: who asks for what, in which frame, in which order, and when there is no room.
#include <algorithm>
#include <random>
#include <set>

#include "lib/cache_cell.glsl"
#include "support/cache_table.h"

namespace parhelion::testing::cache_test {
namespace {

class CacheTables : public GpuTest {
protected:
    void SetUp() override {
        GpuTest::SetUp();
        if (!IsSkipped() && !LightCache::supported(device()->caps())) GTEST_SKIP() << "no 64-bit atomics on buffers";
    }

    // Cells of 1/4 m without jitter: footprint 1 by the default scale. u = 0.5 asks for no parents.
    static CacheOptions plain(uint32_t cells = 1024) { return {.cells = cells, .jitter = 0.0f}; }
    static constexpr float kSize = 0.25f;
    // Points in the middles of count x count cells of a ground.
    static std::vector<CacheAsk> ground(uint32_t count, uint32_t life = 10) {
        std::vector<CacheAsk> asks;
        for (uint32_t z = 0; z < count; ++z)
            for (uint32_t x = 0; x < count; ++x)
                asks.push_back({.position_ws = (glm::vec3(x, 0.0f, z) + glm::vec3(0.5f, 0.0f, 0.5f) - float(count / 2)) * kSize * glm::vec3(1.0f, 0.0f, 1.0f), .life = life});
        return asks;
    }
    static uint32_t known(const std::vector<CacheAnswer>& answers) {
        return static_cast<uint32_t>(std::count_if(answers.begin(), answers.end(), [](const CacheAnswer& a) { return a.known != 0; }));
    }
    static uint32_t found(const std::vector<CacheAnswer>& answers) {
        return static_cast<uint32_t>(std::count_if(answers.begin(), answers.end(), [](const CacheAnswer& a) { return a.id != 0; }));
    }
    // Of the cells that are in, not of those that came in this frame: some of them may be sent back.
    static std::vector<uint64_t> keys(const CacheTable& table) {
        std::vector<uint64_t> out;
        for (const auto& [key, cell] : table.cells())
            if ((cell.key & shared::kCacheNewborn) == 0) out.push_back(key);
        return out;
    }
};

TEST_F(CacheTables, a_cell_is_read_from_the_frame_after_the_one_that_asked_for_it) {
    CacheBench bench(plain());
    bench.irradiance = {0.25f, 0.5f, 1.0f};
    const std::vector<CacheAsk> asks(64, CacheAsk{.position_ws = {0.1f, 0.0f, 0.1f}});
    EXPECT_EQ(known(bench.step(asks)), 0u) << "not in the frame of birth, whoever came first";
    EXPECT_EQ(bench.table().header().live, 1u);
    const std::vector<CacheAnswer> answers = bench.step(asks);
    EXPECT_EQ(known(answers), 64u);
    EXPECT_EQ(answers[0].irradiance, bench.irradiance);
    EXPECT_EQ(answers[0].count, 1u);
    EXPECT_LE(bench.step(asks)[0].count, 2u);
}

// What a slot holds of a cell that died there is nobody's: not even that cell's, when it comes again.
TEST_F(CacheTables, a_cell_that_comes_again_knows_nothing_in_the_frame_of_its_birth) {
    CacheBench bench(plain());
    const std::vector<CacheAsk> asks(1024, CacheAsk{.position_ws = {0.1f, 0.0f, 0.1f}, .life = 2});
    for (int time = 0; time < 2; ++time) {
        EXPECT_EQ(known(bench.step(asks)), 0u) << time;
        for (int frame = 0; frame < 3; ++frame) EXPECT_EQ(known(bench.step(asks)), asks.size());
        for (int frame = 0; frame < 4; ++frame) bench.step({});
        EXPECT_EQ(bench.stats().live, 0u);
    }
}

TEST_F(CacheTables, a_hundred_thousand_askings_for_a_hundred_cells_make_a_hundred) {
    CacheBench bench(plain());
    std::vector<CacheAsk> asks;
    for (int i = 0; i < 1000; ++i)
        for (const CacheAsk& ask : ground(10)) asks.push_back(ask);
    bench.step(asks);
    EXPECT_EQ(bench.table().cells().size(), 100u);
    EXPECT_EQ(known(bench.step(asks)), asks.size());
    const CacheStats stats = bench.stats();
    EXPECT_EQ(stats.live, 100u);
    EXPECT_EQ(stats.born, 100u);
    EXPECT_EQ(stats.updated, 100u);
    EXPECT_EQ(bench.table().cells().size(), 100u);
}

TEST_F(CacheTables, levels_normals_and_owners_have_cells_of_their_own) {
    CacheBench bench(plain());
    std::vector<CacheAsk> asks;
    for (const float footprint : {1.0f, 2.0f, 4.0f})
        for (const glm::vec3 n : {glm::vec3(0, 1, 0), glm::vec3(0, -1, 0), glm::normalize(glm::vec3(1, 2, 0))})
            for (const uint32_t owner : {1u, 2u}) asks.push_back({.position_ws = {0.1f, 0.02f, 0.1f}, .n_ws = n, .owner = owner, .footprint = footprint});
    bench.step(asks);
    EXPECT_EQ(bench.table().cells().size(), asks.size());
    EXPECT_EQ(known(bench.step(asks)), asks.size());
}

// In a table of twice as many slots: buckets hold 15 of 32 on average, and a few in 65,536 more than they can.
TEST_F(CacheTables, a_million_cells_live_and_are_found) {
    CacheBench bench(plain(1u << 21));
    const std::vector<CacheAsk> asks = ground(1000);
    bench.step(asks);
    const std::vector<CacheAnswer> answers = bench.step(asks);
    const CacheStats stats = bench.stats();
    EXPECT_EQ(known(answers), stats.updated);
    EXPECT_GE(stats.live, 999500u);
    EXPECT_LE(stats.rejected + stats.refused, 1000u);
    EXPECT_EQ(found(answers), stats.born);
    EXPECT_EQ(bench.table().cells().size(), stats.live);
    EXPECT_LE(bench.cache.bytes(), uint64_t{40} * bench.cache.slot_count());
}

// What a table keeps when more come than it has room for depends on neither order nor luck.
TEST_F(CacheTables, a_full_table_keeps_the_same_cells_whatever_order_they_come_in) {
    std::vector<CacheAsk> asks = ground(70);
    std::mt19937 random(1);
    std::vector<std::vector<uint64_t>> kept;
    std::vector<uint32_t> seen;
    for (int run = 0; run < 3; ++run) {
        if (run > 0) std::shuffle(asks.begin(), asks.end(), random);
        CacheBench bench(plain(), {.full_barriers = run == 2});
        for (int frame = 0; frame < 12; ++frame) {
            seen.push_back(known(bench.step(asks)));
            if (frame == 1) kept.push_back(keys(bench.table()));
        }
        kept.push_back(keys(bench.table()));
        EXPECT_GT(bench.stats().refused, 0u);
        EXPECT_GT(kept.back().size(), 500u) << "half of the table is in use at least";
    }
    for (size_t i = 2; i < kept.size(); ++i) EXPECT_EQ(kept[i], kept[i - 2]) << i;
    for (size_t i = 12; i < seen.size(); ++i) EXPECT_EQ(seen[i], seen[i - 12]) << i;
}

TEST_F(CacheTables, cells_that_live_are_not_driven_out_by_new_ones) {
    CacheBench bench(plain());
    const std::vector<CacheAsk> first = ground(20);
    bench.step(first);
    bench.step(first);
    const std::vector<uint64_t> before = keys(bench.table());
    EXPECT_EQ(before.size(), 400u);
    std::vector<CacheAsk> all = ground(70);
    all.insert(all.end(), first.begin(), first.end());
    for (int frame = 0; frame < 6; ++frame) bench.step(all);
    const std::vector<uint64_t> after = keys(bench.table());
    EXPECT_TRUE(std::includes(after.begin(), after.end(), before.begin(), before.end()));
}

TEST_F(CacheTables, holes_that_the_dead_leave_hide_nobody) {
    CacheBench bench(plain());
    std::vector<CacheAsk> asks = ground(24);
    bench.step(asks);
    bench.step(asks);
    std::mt19937 random(2);
    std::shuffle(asks.begin(), asks.end(), random);
    asks.resize(asks.size() / 2);
    // The others die; those that are left keep being found, and none comes in a second time.
    for (int frame = 0; frame < 16; ++frame) EXPECT_EQ(found(bench.step(asks)), asks.size()) << frame;
    EXPECT_EQ(bench.table().cells().size(), asks.size());
    EXPECT_EQ(bench.step(ground(24, 0)).size(), 576u);
    EXPECT_EQ(bench.table().cells().size(), asks.size()) << "who only asks brings nobody in";
}

TEST_F(CacheTables, a_cell_outlives_who_asked_by_its_life_and_leaves_nothing) {
    CacheBench bench(plain());
    bench.step(ground(10, 5));
    for (int frame = 0; frame < 5; ++frame) {
        bench.step({});
        EXPECT_EQ(bench.stats().live, 100u) << frame;
    }
    bench.step({});
    EXPECT_EQ(bench.stats().live, 0u);
    const CacheTable table = bench.table();
    for (uint32_t slot = 0; slot < table.header().slot_count; ++slot) {
        ASSERT_EQ(table.cell(slot).key, shared::kCacheNoKey);
        ASSERT_EQ(table.cell(slot).claim, shared::kCacheNoClaim);
    }
}

TEST_F(CacheTables, of_two_lives_the_longer_counts_now_and_later) {
    CacheBench bench(plain());
    std::vector<CacheAsk> both = ground(1, 3);
    both.push_back(ground(1, 9)[0]);
    both.push_back(ground(1, 2)[0]);
    const auto life = [&] { return shared::cache_claim_life(bench.table().cells().begin()->second.claim); };
    bench.step(both);
    EXPECT_EQ(life(), 9u);
    bench.step(ground(1, 3));
    EXPECT_EQ(life(), 8u) << "a short asking does not shorten a life";
    bench.step(ground(1, 9));
    EXPECT_EQ(life(), 9u);
}

// Cells that keep asking for each other with what life they have left are gone as soon as the camera's last wish is.
TEST_F(CacheTables, cells_do_not_keep_each_other_alive) {
    CacheBench bench(plain());
    bench.step(ground(2, 10));
    for (int frame = 1; frame <= 12; ++frame) {
        const std::map<uint64_t, CacheCell> cells = bench.table().cells();
        if (cells.empty()) {
            EXPECT_GT(frame, 10);
            return;
        }
        uint32_t left = 0;
        for (const auto& [key, cell] : cells) left = std::max(left, shared::cache_claim_life(cell.claim));
        bench.step(left > 0 ? ground(2, left - 1) : std::vector<CacheAsk>{});
    }
    FAIL() << "they still live";
}

TEST_F(CacheTables, a_new_exposure_rescales_what_is_stored) {
    CacheBench bench(plain());
    bench.irradiance = {2.0f, 1.0f, 0.5f};
    bench.next.exposure = 0.5f;
    std::vector<CacheAnswer> before;
    for (int frame = 0; frame < 8; ++frame) before = bench.step(ground(4));
    bench.next.exposure = 2.0f;
    bench.irradiance = {8.0f, 4.0f, 2.0f};  // the same light
    const std::vector<CacheAnswer> after = bench.step(ground(4));
    for (size_t i = 0; i < after.size(); ++i) {
        EXPECT_EQ(before[i].irradiance * 4.0f, bench.irradiance);
        EXPECT_EQ(after[i].irradiance, bench.irradiance);
        EXPECT_GE(after[i].count, before[i].count) << "nothing is forgotten";
    }
}

TEST_F(CacheTables, a_cell_without_samples_is_answered_for_by_the_level_above) {
    CacheBench bench(plain());
    CacheAsk parent{.position_ws = {0.1f, 0.0f, 0.1f}, .footprint = 2.0f};
    bench.irradiance = glm::vec3(4.0f);
    for (int frame = 0; frame < 16; ++frame) bench.step({parent});
    CacheAsk child = parent;
    child.footprint = 1.0f;
    const CacheAnswer at_birth = bench.step({child, parent})[0];
    EXPECT_TRUE(at_birth.known);
    EXPECT_EQ(at_birth.irradiance, glm::vec3(4.0f));
    bench.irradiance = glm::vec3(0.0f);
    const CacheAnswer young = bench.step({child, parent})[0];
    EXPECT_EQ(young.count, 1u);
    EXPECT_GT(young.irradiance.x, 1.5f) << "one sample does not count for all";
    CacheAsk elsewhere = child;
    elsewhere.position_ws.x = 40.0f;
    EXPECT_FALSE(bench.step({elsewhere})[0].known);
}

TEST_F(CacheTables, some_askings_bring_in_the_level_above_too) {
    CacheBench bench(plain());
    std::vector<CacheAsk> asks;
    for (int i = 0; i < 256; ++i) asks.push_back({.position_ws = {0.1f, 0.0f, 0.1f}, .u = float(i) / 256.0f});
    bench.step(asks);
    std::set<uint32_t> levels;
    for (const auto& [key, cell] : bench.table().cells()) levels.insert(shared::cache_key_level(key));
    EXPECT_EQ(levels, (std::set<uint32_t>{13, 14}));
}

// Points of one cell, in three orders: the same one stands for it, and another in another frame.
TEST_F(CacheTables, the_point_that_stands_for_a_cell_does_not_depend_on_order_and_is_drawn_anew) {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> unit(0.01f, 0.24f);
    std::vector<CacheAsk> asks;
    for (int i = 0; i < 500; ++i) asks.push_back({.position_ws = {unit(random), 0.0f, unit(random)}});
    std::vector<uint64_t> points;
    for (int run = 0; run < 3; ++run) {
        CacheBench bench(plain());
        for (int frame = 0; frame < 2; ++frame) {
            std::shuffle(asks.begin(), asks.end(), random);
            bench.step(asks);
            const CacheTable table = bench.table();
            points.push_back(shared::cache_old_claim(table.cells().begin()->second.claim, 0, shared::cache_salt(table.header().frame_index)));
        }
    }
    EXPECT_NE(points[0], points[1]);
    for (size_t i = 2; i < points.size(); ++i) EXPECT_EQ(points[i], points[i - 2]);
}

// 4,000 cells and room for about 800 updates a frame.
TEST_F(CacheTables, the_budget_holds_and_goes_to_the_young_first) {
    CacheBench bench(CacheOptions{.cells = 1u << 14, .budget = 1000, .jitter = 0.0f});
    const std::vector<CacheAsk> asks = ground(63);
    bench.step(asks);
    std::vector<uint32_t> counts;
    for (int frame = 0; frame < 12; ++frame) {
        bench.step(asks);
        const CacheStats stats = bench.stats();
        EXPECT_EQ(stats.live, 3969u);
        EXPECT_LE(stats.updated, 1000u);
        EXPECT_GT(stats.updated, 700u);
    }
    uint32_t without = 0, most = 0;
    for (const CacheAnswer& answer : bench.step(asks)) {
        without += answer.count == 0;
        most = std::max(most, answer.count);
    }
    // By lot alone e^-3 of them, 190, would still wait.
    EXPECT_LT(without, 80u);
    EXPECT_LE(most, 6u);
}

TEST_F(CacheTables, the_work_of_a_frame_follows_the_cells_that_live_not_the_room) {
    for (const uint32_t cells : {1u << 12, 1u << 20}) {
        CacheBench bench(plain(cells));
        for (int frame = 0; frame < 3; ++frame) bench.step(ground(20));
        const std::vector<shared::CacheSize> sizes = download<shared::CacheSize>(bench.cache.sizes());
        EXPECT_EQ(sizes[shared::kCacheSizeMaintain].x * sizes[shared::kCacheSizeMaintain].y, 2u) << "400 cells in groups of 256";
        for (const uint32_t size : {shared::kCacheSizeSelect, shared::kCacheSizeUpdates})
            EXPECT_EQ(sizes[size].x * sizes[size].y, 7u) << "400 cells in groups of 64";
    }
}

TEST_F(CacheTables, a_reset_forgets_everything) {
    CacheBench bench(plain());
    for (int frame = 0; frame < 3; ++frame) bench.step(ground(10));
    bench.cache.reset();
    EXPECT_EQ(known(bench.step(ground(10))), 0u);
    EXPECT_EQ(known(bench.step(ground(10))), 100u);
}

}  // namespace
}  // namespace parhelion::testing::cache_test
