// The film's exact arithmetic on the device equals the host's (image/film.h), bit for bit.
#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include <glm/glm.hpp>

#include "image/film.h"
#include "support/gpu_fixture.h"

namespace parhelion::testing::fixed_point_test {
namespace {

class FixedPoint : public GpuTest {};

TEST_F(FixedPoint, sums_equal_the_hosts_bit_for_bit) {
    constexpr uint32_t kInfinity = 0x7F800000u;
    std::vector<uint32_t> bits = {0u, 0x80000000u, 1u, 0x007FFFFFu, 0x00800000u, 0x80800000u, 0x7F7FFFFFu, 0xFF7FFFFFu, kInfinity, kInfinity | 0x80000000u, 0x7FC00000u, 0xFFC00001u};
    for (int exponent = -66; exponent <= 56; ++exponent)  // every shift, smallest and largest mantissa, both signs
        for (const uint32_t mantissa : {0u, 1u, 0x400000u, 0x7FFFFFu})
            for (const uint32_t sign : {0u, 0x80000000u}) bits.push_back(sign | static_cast<uint32_t>(exponent + 127) << 23 | mantissa);
    std::mt19937 random(7);
    while (bits.size() < 100000) bits.push_back(random());
    while (bits.size() < 200000) bits.push_back(std::bit_cast<uint32_t>(std::ldexp(float(random() & 0xFFFFFFu), int(random() % 60) - 64)) | (random() & 0x80000000u));
    std::vector<glm::uvec2> pairs;
    for (size_t i = 0; i < bits.size(); ++i) pairs.emplace_back(bits[i], bits[(i * 7919 + 13) % bits.size()]);

    struct Push {
        uint64_t pairs = 0, sums = 0;
        uint32_t count;
    };
    const auto count = static_cast<uint32_t>(pairs.size());
    const gpu::Buffer input = upload<glm::uvec2>("pairs", pairs), output(device(), "test/sums", pairs.size() * 36);
    Frame frame(device(), {}, test_shader_pack());
    frame.compute("device/fixed_point").read("pairs", input).write("sums", output).push(Push{.count = count}).over(count);
    frame.run();
    const std::vector<image::Fixed96> found = download<image::Fixed96>(output);
    for (size_t i = 0; i < pairs.size(); ++i) {
        const image::Fixed96 a = image::fixed_from_float(std::bit_cast<float>(pairs[i].x)), b = image::fixed_from_float(std::bit_cast<float>(pairs[i].y));
        ASSERT_EQ(found[3 * i], a) << std::hex << pairs[i].x;
        ASSERT_EQ(found[3 * i + 1], b) << std::hex << pairs[i].y;
        ASSERT_EQ(found[3 * i + 2], image::fixed_add(a, b)) << std::hex << pairs[i].x << " + " << pairs[i].y;
    }
}

}  // namespace
}  // namespace parhelion::testing::fixed_point_test
