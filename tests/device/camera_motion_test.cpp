// Cameras while their shutter is open: the device and the host compute the same bits.
#include <cstring>

#include "lib/camera_motion.glsl"
#include "renderers/camera_motion.h"
#include "session/scene_setup.h"
#include "support/gpu_fixture.h"

namespace parhelion::testing::camera_motion_test {
namespace {

class CameraMotions : public GpuTest {};

struct Move {
    shared::Camera camera;
    shared::CameraMotion motion;
};

Move move(glm::vec3 from, glm::vec3 at, glm::vec3 to, glm::vec3 at_end) {
    const shared::Camera begin = shader_camera(look_at(from, at, 0.7f), 1.5f), end = shader_camera(look_at(to, at_end, 0.9f), 1.5f);
    return {begin, camera_motion(begin, end)};
}

TEST_F(CameraMotions, are_on_the_device_what_they_are_on_the_host) {
    constexpr uint32_t kSamples = 256, kSeed = 5;
    const std::vector<Move> moves = {move({0, 0, 0}, {0, 0, -1}, {3, 1, 2}, {-4, 0, 9}), move({100, 20, 3}, {0, 0, -1}, {100, 20, 3}, {0, 7, -1})};
    struct Push {
        uint64_t moves = 0, cameras = 0, moments = 0;
        uint32_t move_count, sample_count = kSamples, seed = kSeed;
    };
    const gpu::Buffer input = upload<Move>("moves", moves);
    const gpu::Buffer cameras(device(), "test/cameras", moves.size() * kSamples * sizeof(shared::Camera)), moments(device(), "test/moments", kSamples * sizeof(float));
    Frame frame(device(), {}, test_shader_pack());
    frame.compute("device/camera_motion").read("moves", input).write("cameras", cameras).write("moments", moments).push(Push{.move_count = static_cast<uint32_t>(moves.size())}).over(kSamples);
    frame.run();
    const auto found = download<shared::Camera>(cameras);
    const auto found_moments = download<float>(moments);
    for (uint32_t i = 0; i < kSamples; ++i) {
        const float share = shared::shutter_share(i, kSeed);
        ASSERT_EQ(found_moments[i], share) << i;
        for (size_t m = 0; m < moves.size(); ++m) {
            const shared::Camera expected = shared::camera_at(moves[m].camera, moves[m].motion, share);
            ASSERT_EQ(std::memcmp(&found[m * kSamples + i], &expected, sizeof(expected)), 0) << "move " << m << ", sample " << i;
        }
    }
}

}  // namespace
}  // namespace parhelion::testing::camera_motion_test
