// Cameras over the time that their shutter is open, and the moments of samples (shaders/lib/camera_motion.glsl, compiled as C++).
#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "lib/camera_motion.glsl"
#include "renderers/camera_motion.h"
#include "sampling/path_sampler.h"
#include "session/scene_setup.h"
#include "support/correlation.h"

namespace parhelion::camera_motion_test {
namespace {

constexpr float kAspect = 1.5f;

shared::Camera camera(glm::vec3 from, glm::vec3 at, float yfov) { return shader_camera(look_at(from, at, yfov), kAspect); }

void expect_near(glm::vec3 a, glm::vec3 b, float tolerance, const char* what) { EXPECT_LT(glm::length(a - b), tolerance * (1.0f + glm::length(b))) << what; }

void expect_same(const shared::Camera& a, const shared::Camera& b) {
    expect_near(a.position_ws, b.position_ws, 2e-6f, "position");
    expect_near(a.right_ws, b.right_ws, 2e-6f, "right");
    expect_near(a.up_ws, b.up_ws, 2e-6f, "up");
    expect_near(a.forward_ws, b.forward_ws, 2e-6f, "forward");
}

double angle_between(glm::vec3 a, glm::vec3 b) {
    const glm::dvec3 x = glm::normalize(glm::dvec3(a)), y = glm::normalize(glm::dvec3(b));
    return std::atan2(glm::length(glm::cross(x, y)), glm::dot(x, y));
}

const std::pair<shared::Camera, shared::Camera> kMoves[] = {
    {camera({0, 0, 0}, {0, 0, -1}, 0.8f), camera({1, 2, 3}, {1, 2, 2}, 0.8f)},           // slides
    {camera({0, 0, 0}, {0, 0, -1}, 0.8f), camera({0, 0, 0}, {-1, 0, 0}, 0.8f)},          // pans by a right angle
    {camera({1, 2, 3}, {4, 1, -2}, 0.5f), camera({-7, 2, 5}, {3, 9, 1}, 1.2f)},          // everything at once
    {camera({0, 0, 0}, {0, 0, -1}, 0.8f), camera({0, 0, 0}, {1e-3f, 0, 1}, 0.8f)},       // nearly half a turn
    {camera({1e4f, 0, 0}, {0, 0, -1}, 0.8f), camera({1e4f, 1e-3f, 0}, {0, 0, -1}, 0.8f)}  // hardly at all
};

TEST(CameraMotion, begins_and_ends_where_the_cameras_stand) {
    for (const auto& [begin, end] : kMoves) {
        const shared::CameraMotion motion = camera_motion(begin, end);
        const shared::Camera opens = shared::camera_at(begin, motion, 0.0f);
        EXPECT_EQ(opens.position_ws, begin.position_ws);
        EXPECT_EQ(opens.right_ws, begin.right_ws);
        EXPECT_EQ(opens.up_ws, begin.up_ws);
        EXPECT_EQ(opens.forward_ws, begin.forward_ws);
        expect_same(shared::camera_at(begin, motion, 1.0f), end);
    }
}

TEST(CameraMotion, of_a_still_camera_changes_no_bit) {
    const shared::Camera still = kMoves[2].first;
    const shared::Camera now = shared::camera_at(still, camera_motion(still, still), 0.37f);
    EXPECT_EQ(now.position_ws, still.position_ws);
    EXPECT_EQ(now.right_ws, still.right_ws);
    EXPECT_EQ(now.up_ws, still.up_ws);
    EXPECT_EQ(now.forward_ws, still.forward_ws);
}

TEST(CameraMotion, turns_evenly_and_keeps_its_frame_orthogonal) {
    for (const auto& [begin, end] : kMoves) {
        const shared::CameraMotion motion = camera_motion(begin, end);
        const double whole = 2.0 * motion.half_angle;
        shared::Camera last = begin;
        for (int i = 1; i <= 16; ++i) {
            const shared::Camera now = shared::camera_at(begin, motion, float(i) / 16.0f);
            const glm::vec3 r = glm::normalize(now.right_ws), u = glm::normalize(now.up_ws), f = now.forward_ws;
            EXPECT_NEAR(glm::length(f), 1.0f, 1e-6f);
            for (const float product : {glm::dot(r, u), glm::dot(u, f), glm::dot(f, r)}) EXPECT_NEAR(product, 0.0f, 1e-6f);
            expect_near(glm::cross(r, u), -f, 1e-6f, "handedness");
            // An even turn about one axis: every step turns what is not on the axis by the same angle.
            const glm::vec3 axis = motion.axis_ws;
            const glm::vec3 across = f - glm::dot(f, axis) * axis, across_last = last.forward_ws - glm::dot(last.forward_ws, axis) * axis;
            if (whole > 1e-3 && glm::length(across) > 1e-2f) {
                EXPECT_NEAR(angle_between(across, across_last), whole / 16.0, 1e-5) << i;
            }
            // The image's proportions stay.
            EXPECT_NEAR(glm::length(now.right_ws) / glm::length(now.up_ws), kAspect, 1e-5f);
            last = now;
        }
    }
    const shared::Camera middle = shared::camera_at(kMoves[1].first, camera_motion(kMoves[1].first, kMoves[1].second), 0.5f);
    expect_near(middle.forward_ws, {-std::sqrt(0.5f), 0.0f, -std::sqrt(0.5f)}, 1e-6f, "half of a right angle");
}

TEST(CameraMotion, has_sine_and_cosine_to_float_precision) {
    for (int i = 0; i <= 1000; ++i) {
        const float x = 1.5707964f * float(i) / 1000.0f;
        EXPECT_NEAR(shared::sine_and_cosine(x).x, std::sin(double(x)), 2e-7);
        EXPECT_NEAR(shared::sine_and_cosine(x).y, std::cos(double(x)), 2e-7);
    }
}

TEST(CameraMotion, every_aligned_block_of_samples_has_one_moment_in_each_stratum) {
    for (const uint32_t seed : {0u, 1u, 77u})
        for (const uint32_t count : {2u, 16u, 64u, 1024u})
            for (const uint32_t first : {0u, count, 40u * count}) {
                std::set<uint32_t> strata;
                for (uint32_t i = 0; i < count; ++i) {
                    const float share = shared::shutter_share(first + i, seed);
                    ASSERT_TRUE(share >= 0.0f && share < 1.0f);
                    strata.insert(static_cast<uint32_t>(share * float(count)));
                }
                EXPECT_EQ(strata.size(), count) << "seed " << seed << ", from " << first;
            }
    EXPECT_NE(shared::shutter_share(0, 0), shared::shutter_share(0, 1));
}

// Of 1024 samples a correlation of independent numbers is beyond 4 / sqrt(1024) once in 16,000; 32 are looked at for each kind, with fixed seeds.
TEST(CameraMotion, the_moments_of_samples_follow_no_number_of_a_pixel) {
    for (const uint32_t kind : {shared::kSamplerOwen, shared::kSamplerCranley, shared::kSamplerPcg, shared::kSamplerWhite})
        for (uint32_t pixel = 0; pixel < 4; ++pixel)
            for (uint32_t dimension = 0; dimension < 8; dimension += 2) {
                std::vector<double> moments, x, y;
                for (uint32_t i = 0; i < 1024; ++i) {
                    shared::PathSampler s = sampling::make_sampler({pixel, 3u}, i, 0, kind);
                    s.dimension = dimension;
                    const glm::vec2 u = shared::next_2d(s);
                    moments.push_back(shared::shutter_share(i, 0));
                    x.push_back(u.x);
                    y.push_back(u.y);
                }
                EXPECT_LT(std::abs(testing::correlation(moments, x)), 0.125) << kind << ' ' << dimension;
                EXPECT_LT(std::abs(testing::correlation(moments, y)), 0.125) << kind << ' ' << dimension;
            }
}

}  // namespace
}  // namespace parhelion::camera_motion_test
