#include "scene/sky.h"

#include <cmath>
#include <numbers>

#include "base/parallel.h"
#include "scene/atmosphere.h"

namespace parhelion {

namespace {

constexpr double kViewerAltitude = 2.0;                            // metres
constexpr float kSunAngularRadius = 0.5f * 0.53f * 0.01745329252f;  // half of 0.53 degrees

// Direction of a texel's middle, as Environment lays them out.
glm::dvec3 direction_of(const Environment& e, size_t x, size_t y) {
    const double theta = std::numbers::pi * (double(y) + 0.5) / e.height, phi = 2.0 * std::numbers::pi * ((double(x) + 0.5) / e.width - 0.5);
    return {std::sin(theta) * std::sin(phi), std::cos(theta), -std::sin(theta) * std::cos(phi)};
}

// Illuminance of level ground by the map's upper half, lux.
glm::dvec3 sky_illuminance(const Environment& e) {
    glm::dvec3 sum(0.0);
    for (size_t y = 0; y < e.height / 2; ++y) {
        const double top = std::cos(std::numbers::pi * double(y) / e.height), bottom = std::cos(std::numbers::pi * double(y + 1) / e.height);
        for (size_t x = 0; x < e.width; ++x)
            sum += glm::dvec3(e.radiance[y * e.width + x]) * (std::numbers::pi / e.width * (top * top - bottom * bottom));
    }
    return sum;
}

Environment map_of(const Atmosphere& atmosphere, glm::dvec3 to_sun, glm::dvec3 sun_illuminance, const SkyOptions& options) {
    Environment e{.name = "clear sky", .width = 2 * options.rows, .height = options.rows, .scale = glm::vec3(1.0f)};
    e.radiance.resize(size_t(e.width) * e.height);
    glm::dvec3 ground(0.0);  // radiance; known when the sky is
    const auto fill = [&](size_t first, size_t last) {
        parallel_for(last - first, 8, [&](size_t begin, size_t end) {
            for (size_t y = first + begin; y < first + end; ++y)
                for (size_t x = 0; x < e.width; ++x) {
                    const Atmosphere::Seen seen = atmosphere.look(kViewerAltitude, direction_of(e, x, y), to_sun);
                    e.radiance[y * e.width + x] = glm::vec3(seen.air + seen.ground * ground);
                }
        });
    };
    fill(0, e.height / 2);
    const glm::dvec3 on_ground = sun_illuminance * std::max(0.0, to_sun.y) + sky_illuminance(e);
    ground = on_ground * (double(options.ground_albedo) / std::numbers::pi);
    fill(e.height / 2, e.height);
    return e;
}

}  // namespace

Sky make_clear_sky(const SkyOptions& options) {
    const double across = std::cos(options.sun_elevation);
    const glm::dvec3 to_sun(across * std::sin(options.sun_azimuth), std::sin(options.sun_elevation), across * std::cos(options.sun_azimuth));
    const Atmosphere atmosphere(double(options.ground_albedo));
    const glm::dvec3 illuminance = atmosphere.sun_illuminance(kViewerAltitude, to_sun.y);
    Sky sky;
    sky.environment = map_of(atmosphere, to_sun, illuminance, options);
    const double strongest = std::max(illuminance.r, std::max(illuminance.g, illuminance.b));
    sky.sun.name = "sun";
    sky.sun.kind = LightKind::Directional;
    sky.sun.color = strongest > 0.0 ? glm::vec3(illuminance / strongest) : glm::vec3(0.0f);
    sky.sun.intensity = static_cast<float>(strongest);
    sky.sun.angular_radius = kSunAngularRadius;
    // Shines along its -Z: +Z points at the sun.
    const glm::dvec3 z = to_sun, helper = std::abs(z.y) < 0.99 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
    const glm::dvec3 x = glm::normalize(glm::cross(helper, z)), y = glm::cross(z, x);
    sky.sun.place.node_from_object = glm::mat4(glm::vec4(x, 0.0f), glm::vec4(y, 0.0f), glm::vec4(z, 0.0f), glm::vec4(0, 0, 0, 1));
    return sky;
}

}  // namespace parhelion
