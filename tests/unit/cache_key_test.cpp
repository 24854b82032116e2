// Keys, points, irradiance and moments of the world cache as the host computes them with the shaders' own functions.
#include <cmath>
#include <map>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "lib/cache_cell.glsl"

namespace parhelion::shared::cache_key_test {
namespace {

glm::vec3 random_direction(std::mt19937& random) {
    std::normal_distribution<float> normal;
    glm::vec3 d;
    do d = {normal(random), normal(random), normal(random)};
    while (glm::dot(d, d) < 1e-6f);
    return glm::normalize(d);
}

TEST(CacheKeys, mixing_is_undone_exactly) {
    std::mt19937_64 random(1);
    for (int i = 0; i < 100000; ++i) {
        const uint64_t key = random() >> 1, point = random() >> 7;
        ASSERT_EQ(cache_unmix(cache_mix(key, kCacheKeyBits, 32u), kCacheKeyBits, 32u), key);
        ASSERT_EQ(cache_unmix(cache_mix(point, kCachePointBits, 29u), kCachePointBits, 29u), point);
        ASSERT_LT(cache_mix(key, kCacheKeyBits, 32u), uint64_t{1} << 63);
        ASSERT_LT(cache_mix(point, kCachePointBits, 29u), uint64_t{1} << 57);
    }
}

TEST(CacheKeys, every_cell_level_and_normal_has_a_key_of_its_own_negative_coordinates_too) {
    std::set<uint64_t> keys;
    uint64_t made = 0;
    for (const int low : {-8192, -5, 8180})
        for (int x = 0; x < 10; ++x)
            for (int y = 0; y < 10; ++y)
                for (int z = 0; z < 10; ++z)
                    for (const uint level : {0u, 14u, 15u, 31u})
                        for (const uint normal : {0u, 60u, 120u}) {
                            const ivec3 cell(low + x, low + y, low + z);
                            const uint64_t key = cache_key(cell, level, normal, 7u);
                            keys.insert(key);
                            ++made;
                            ASSERT_EQ(cache_key_cell(key), cell);
                            ASSERT_EQ(cache_key_cell(key | kCacheNewborn), cell);
                            ASSERT_EQ(cache_key_level(key | kCacheNewborn), level);
                        }
    EXPECT_EQ(keys.size(), made);
}

// Document 004's fault: a point and the point twice as far from the origin at the next level shared a cell.
TEST(CacheKeys, a_point_and_its_double_at_the_next_level_share_no_cell) {
    const vec3 up(0.0f, 1.0f, 0.0f), p(12.05f, 0.0f, 7.07f);
    const ivec3 fine = cache_cell(p, up, cache_normal_code(up), 12u, vec3(0.0f)), coarse = cache_cell(2.0f * p, up, cache_normal_code(up), 13u, vec3(0.0f));
    EXPECT_EQ(fine.x, coarse.x);
    EXPECT_EQ(fine.z, coarse.z);
    EXPECT_NE(cache_key(fine, 12u, cache_normal_code(up), 1u), cache_key(fine, 13u, cache_normal_code(up), 1u));
}

TEST(CacheKeys, no_cell_has_the_number_of_a_free_slot) {
    const uint64_t none = kCacheNoKey & ~kCacheNewborn;
    EXPECT_EQ(cache_key_normal(none), 127u) << "where codes of normals end at 120";
}

TEST(CacheKeys, slots_and_admission_are_spread_evenly) {
    // 64,000 neighbours over 256 buckets: chi-square with 255 degrees of freedom, mean 255, deviation 22.6; seven of them.
    std::vector<int> buckets(256), probes(kCacheBucket);
    int admitted = 0;
    for (int x = 0; x < 40; ++x)
        for (int y = -20; y < 20; ++y)
            for (int z = 0; z < 40; ++z) {
                const uint64_t key = cache_key(ivec3(x, y, z), 12u, 60u, 3u);
                ++buckets[cache_bucket(key, 255u)];
                ++probes[cache_probe(key, 0u, 0u)];
                admitted += cache_admitted(key, 3u);
                ASSERT_TRUE(!cache_admitted(key, 4u) || cache_admitted(key, 3u)) << "who is let in strictly is let in less strictly";
            }
    double chi2 = 0;
    for (const int n : buckets) chi2 += (n - 250.0) * (n - 250.0) / 250.0;
    EXPECT_NEAR(chi2, 255, 7 * 22.6);
    for (const int n : probes) EXPECT_NEAR(n, 2000, 7 * std::sqrt(2000.0));
    EXPECT_NEAR(admitted, 8000, 7 * std::sqrt(8000.0));
}

TEST(CacheKeys, a_probe_goes_once_round_its_bucket_whatever_slot_it_begins_at) {
    std::mt19937_64 random(2);
    for (int i = 0; i < 1000; ++i) {
        const uint64_t key = random() >> 1;
        std::set<uint> slots;
        for (uint k = 0; k < kCacheBucket; ++k) slots.insert(cache_probe(key, 5u, k));
        ASSERT_EQ(slots.size(), kCacheBucket);
        ASSERT_EQ(*slots.begin(), 5u * kCacheBucket);
        ASSERT_EQ(*slots.rbegin(), 6u * kCacheBucket - 1u);
    }
}

TEST(CacheKeys, normals_have_codes_finer_than_octants_with_the_axes_in_the_middle_of_theirs) {
    std::mt19937 random(3);
    for (const vec3 axis : {vec3(1, 0, 0), vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, -1, 0), vec3(0, 0, 1), vec3(0, 0, -1)}) {
        const uint code = cache_normal_code(axis);
        for (int i = 0; i < 1000; ++i)  // within 4 degrees
            ASSERT_EQ(cache_normal_code(glm::normalize(axis + 0.07f * random_direction(random))), code) << axis.x << axis.y << axis.z;
    }
    // Directions of one code lie within 40 degrees of each other, of an octant within 90.
    std::map<uint, std::vector<vec3>> by_code;
    for (int i = 0; i < 50000; ++i) {
        const vec3 d = random_direction(random);
        const uint code = cache_normal_code(d);
        ASSERT_LT(code, 121u);
        by_code[code].push_back(d);
    }
    float widest = 1.0f;
    for (const auto& [code, directions] : by_code)
        for (const vec3& d : directions) widest = std::min(widest, glm::dot(d, directions.front()));
    EXPECT_GT(widest, std::cos(glm::radians(40.0f)));
    EXPECT_GE(by_code.size(), 100u);
}

TEST(CacheKeys, levels_follow_the_footprint_in_powers_of_two_and_dissolve) {
    const vec3 p(1.0f, 2.0f, -3.0f);
    const uint up = cache_normal_code(vec3(0.0f, 1.0f, 0.0f));
    EXPECT_EQ(cache_level_size(kCacheUnitLevel), 1.0f);
    EXPECT_EQ(cache_level_size(cache_level(p, up, 0.25f, 0.999f)), 0.25f);
    int finer = 0;
    for (int i = 0; i < 1000; ++i) finer += cache_level_size(cache_level(p, up, 0.3125f, float(i) / 1000.0f)) == 0.25f;
    EXPECT_EQ(finer, 750);
    // Far from the origin cells are so large that their numbers fit the key.
    for (const float far : {10.0f, 1000.0f, 65000.0f})
        for (const float sign : {-1.0f, 1.0f}) {
            const vec3 q(sign * far, -sign * far, 0.9f * far);
            const uint level = cache_level(q, up, 1e-6f, 0.0f);
            const ivec3 cell = cache_cell(q, vec3(0.0f, 1.0f, 0.0f), up, level, vec3(0.0f));
            EXPECT_EQ(cell.x, int(std::floor(q.x / cache_level_size(level))));
            EXPECT_EQ(cell.y, int(std::floor((q.y / cache_level_size(level) + 0.0734f) * 4.0f)));
            EXPECT_EQ(cache_key_cell(cache_key(cell, level, up, 0u)), cell);
            EXPECT_EQ(cache_key_normal(cache_key(cell, level, up, 0u)), up);
        }
}

// Two faces of one body that look the same way: half a cell apart along their normal they share none.
TEST(CacheKeys, parallel_faces_keep_apart_wherever_they_lie) {
    for (const vec3 n : {vec3(1, 0, 0), vec3(0, -1, 0), vec3(0, 0, 1)})
        for (int i = 0; i < 1000; ++i) {
            const vec3 p = n * (0.001f * float(i)) + 0.3f;
            const uint code = cache_normal_code(n);
            ASSERT_NE(cache_cell(p, n, code, kCacheUnitLevel, vec3(0.0f)), cache_cell(p + 0.5f * n, n, code, kCacheUnitLevel, vec3(0.0f)));
        }
}

TEST(CacheCells, a_point_comes_back_above_its_plane_near_where_it_was) {
    std::mt19937 random(4);
    std::uniform_real_distribution<float> coordinate(-3.0f, 3.0f), unit;
    int refused = 0;
    for (int i = 0; i < 200000; ++i) {
        const vec3 p(coordinate(random), coordinate(random), coordinate(random)), n = random_direction(random);
        vec3 wo = random_direction(random);
        if (glm::dot(wo, n) < 0.0f) wo = -wo;
        wo *= 10.0f;
        const uint level = 10u + uint(random() % 6u);
        const vec3 jitter = vec3(unit(random), unit(random), unit(random)) - 0.5f;
        const vec3 corner = cache_corner(cache_cell(p, n, cache_normal_code(n), level, jitter), cache_normal_code(n));
        vec3 back, normal;
        const uint64_t point = cache_pack_point(p, n, wo, corner, level);
        refused += point == kCacheNoPoint;
        if (point == kCacheNoPoint) continue;
        cache_unpack_point(point, corner, level, back, normal);
        const float size = cache_level_size(level), above = glm::dot(back - p, n) / size;
        ASSERT_GT(glm::dot(normal, n), 0.99999f);
        ASSERT_GT(above, -1e-5f) << "below its plane";
        ASSERT_LT(above, 1.2e-4f);
        ASSERT_LT(glm::length(back - p) / size, 4e-3f);
    }
    EXPECT_LT(refused, 400) << "only who came from right above";
}

TEST(CacheCells, a_point_in_a_corner_does_not_slide_into_the_wall_even_if_seen_from_its_foot) {
    std::mt19937 random(5);
    std::uniform_real_distribution<float> unit;
    int spoke = 0;
    for (int i = 0; i < 20000; ++i) {
        // Floor y = 0, walls x = 0 and z = 0; the path came from inside, half of them from very near a wall.
        const vec3 p(1e-5f + 1e-4f * unit(random), 0.0f, 1e-5f + unit(random)), n(0.0f, 1.0f, 0.0f);
        const vec3 viewer(unit(random) * (i % 2 == 0 ? 1.0f : 1e-4f), unit(random), unit(random));
        const vec3 corner = cache_corner(cache_cell(p, n, cache_normal_code(n), 12u, vec3(0.0f)), cache_normal_code(n));
        vec3 back, normal;
        const uint64_t point = cache_pack_point(p, n, viewer - p, corner, 12u);
        if (point == kCacheNoPoint) continue;
        ++spoke;
        cache_unpack_point(point, corner, 12u, back, normal);
        ASSERT_GT(back.x, 0.0f);
        ASSERT_GT(back.z, 0.0f);
    }
    EXPECT_GT(spoke, 9900);
}

TEST(CacheCells, the_least_claim_is_the_longest_life_then_the_newest_point) {
    std::mt19937_64 random(6);
    const uint64_t salt = cache_salt(9);
    for (int i = 0; i < 10000; ++i) {
        const uint64_t a = random() >> 7, b = random() >> 7;
        ASSERT_LT(cache_claim(7, a, salt), cache_claim(6, b, salt));
        ASSERT_LT(cache_claim(5, a, salt), cache_old_claim(cache_claim(9, b, salt), 5, salt));
        ASSERT_LT(cache_old_claim(cache_claim(9, b, salt), 6, salt), cache_claim(5, a, salt));
        ASSERT_EQ(cache_claim_life(cache_claim(7, a, salt)), 7u);
        // The point survives being made old, once and again.
        const uint64_t old = cache_old_claim(cache_claim(7, a, salt), 6, salt);
        ASSERT_EQ(old & kCachePointMask, a);
        ASSERT_EQ(cache_old_claim(old, 5, cache_salt(10)) & kCachePointMask, a);
        ASSERT_EQ(cache_claim_life(old), 6u);
        ASSERT_LT(cache_claim(0, a, salt), kCacheNoClaim);
    }
    EXPECT_EQ(cache_claim_life(kCacheNoClaim), 0u);
}

// Of two points each frame's salt prefers another: 1,000 frames, six deviations.
TEST(CacheCells, every_point_has_the_same_chance) {
    int first = 0;
    for (uint frame = 0; frame < 1000; ++frame) first += cache_claim(3, 12345u, cache_salt(frame)) < cache_claim(3, 98765u, cache_salt(frame));
    EXPECT_NEAR(first, 500, 6 * std::sqrt(250.0));
}

TEST(CacheCells, irradiance_keeps_18_bits_over_the_whole_range) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> unit, exponent(-80.0f, 100.0f);
    for (int i = 0; i < 100000; ++i) {
        const vec3 e = vec3(unit(random), unit(random), unit(random)) * std::exp2(exponent(random));
        const vec3 back = cache_unpack_irradiance(cache_pack_irradiance(e));
        const float largest = std::max({e.x, e.y, e.z});
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(back[c], e[c], largest * 4e-6f);
    }
    EXPECT_EQ(cache_unpack_irradiance(cache_pack_irradiance(vec3(0.0f))), vec3(0.0f));
    EXPECT_EQ(cache_unpack_irradiance(cache_pack_irradiance(vec3(1.0f, 0.0f, 0.5f))), vec3(1.0f, 0.0f, 0.5f));
}

TEST(CacheCells, moments_are_rounded_without_bias) {
    std::mt19937 random(8);
    std::uniform_real_distribution<float> unit;
    double spread = 0, change = 0;
    constexpr int kTimes = 20000;
    for (int i = 0; i < kTimes; ++i) {
        const CacheMoments back = cache_unpack_moments(cache_pack_moments({.count = 31, .age = 12, .spread = 0.7f, .change = -0.013f}, vec2(unit(random), unit(random))));
        ASSERT_EQ(back.count, 31u);
        ASSERT_EQ(back.age, 12u);
        spread += back.spread / kTimes;
        change += back.change / kTimes;
    }
    EXPECT_NEAR(spread, 0.7, 0.7 * 1e-3);
    EXPECT_NEAR(change, -0.013, 0.013 * 2e-3);
    const CacheMoments none = cache_unpack_moments(cache_pack_moments({.count = 300, .age = 100, .spread = 0.0f, .change = 0.0f}, vec2(0.9f)));
    EXPECT_EQ(none.count, 255u);
    EXPECT_EQ(none.age, kCacheOldest);
    EXPECT_EQ(none.spread, 0.0f);
    EXPECT_EQ(none.change, 0.0f);
}

}  // namespace
}  // namespace parhelion::shared::cache_key_test
