#pragma once
// What tests of the BSDF's and of glass's triple give to the device.
#include <cmath>
#include <random>
#include <vector>

#include <glm/glm.hpp>

namespace parhelion::testing {

// The unit vector with this cosine to the normal and this azimuth in radians.
inline glm::vec3 direction(double z, double phi) {
    const double r = std::sqrt(1 - z * z);
    return {r * std::cos(phi), r * std::sin(phi), z};
}

// `count` copies of one input with three numbers in [0, 1) each, as the path sampler draws them; the same ones in every call.
template <class Input>
std::vector<Input> with_random_numbers(const Input& input, uint32_t count) {
    std::mt19937 random(11);
    const auto unit = [&] { return static_cast<float>(random() >> 8) * 0x1p-24f; };
    std::vector<Input> inputs(count, input);
    for (Input& i : inputs) i.given.x = unit(), i.given.y = unit(), i.given.z = unit();
    return inputs;
}

}  // namespace parhelion::testing
