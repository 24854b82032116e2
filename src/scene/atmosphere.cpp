#include "scene/atmosphere.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/parallel.h"

namespace parhelion {

namespace {

constexpr double kGroundRadius = 6'360'000.0, kTopRadius = 6'420'000.0;

// Bruneton 2017: solar irradiance at 680, 550 and 440 nm in W / (m^2 nm) times its factors for the sun's and the sky's luminance.
const glm::dvec3 kSolarIrradiance(1.474000, 1.850400, 1.911980);
const glm::dvec3 kSunLuminance(98242.786222, 69954.398112, 66475.012354);
const glm::dvec3 kSkyLuminance(114974.916437, 71305.954816, 65310.548555);

const glm::dvec3 kRayleigh(5.802e-6, 13.558e-6, 33.1e-6);
const glm::dvec3 kOzone(0.650e-6, 1.881e-6, 0.085e-6);
constexpr double kRayleighHeight = 8000.0, kMieHeight = 1200.0;
// An optical depth of 0.05 straight up, that of clear days (Bruneton 2017 has a tenth of it: mountain air).
constexpr double kMieScattering = 39.96e-6, kMieExtinction = 44.40e-6;
constexpr double kMieAsymmetry = 0.8;

constexpr int kTransmittanceRows = 48, kTransmittanceColumns = 128, kMultipleRows = 24, kMultipleColumns = 48;

double rayleigh_phase(double cosine) { return 3.0 / (16.0 * std::numbers::pi) * (1.0 + cosine * cosine); }

// Cornette and Shanks 1992.
double mie_phase(double cosine) {
    constexpr double g = kMieAsymmetry, g2 = g * g;
    const double k = 3.0 / (8.0 * std::numbers::pi) * (1.0 - g2) / (2.0 + g2);
    return k * (1.0 + cosine * cosine) / std::pow(1.0 + g2 - 2.0 * g * cosine, 1.5);
}

// The i-th of `count` steps along a ray of that length; they grow with the distance, because the air is densest near the ground,
// where rays start.
struct Step {
    double middle, length;
};
Step growing_step(int i, int count, double length) {
    const double begin = double(i) / count, end = double(i + 1) / count;
    return {0.5 * (begin * begin + end * end) * length, (end * end - begin * begin) * length};
}

// Distance from the centre, `distance` further along a ray.
double radius_after(double radius, double up, double distance) {
    return std::sqrt(std::max(0.0, radius * radius + distance * distance + 2.0 * radius * up * distance));
}

// Table coordinates: altitude by its square root, so that the dense layers below have more rows. The cosine likewise near the
// horizon, where transmittance changes fastest.
double altitude_of(double row) { return row * row * (kTopRadius - kGroundRadius); }
double row_of(double altitude) { return std::sqrt(std::clamp(altitude / (kTopRadius - kGroundRadius), 0.0, 1.0)); }
double cosine_of(double column) {
    const double signed_column = 2.0 * column - 1.0;
    return signed_column * std::abs(signed_column);
}
double column_of(double up) { return 0.5 + 0.5 * std::copysign(std::sqrt(std::min(1.0, std::abs(up))), up); }

glm::dvec3 bilinear(const std::vector<glm::dvec3>& table, int rows, int columns, double row, double column) {
    const double y = std::clamp(row, 0.0, 1.0) * (rows - 1), x = std::clamp(column, 0.0, 1.0) * (columns - 1);
    const int y0 = std::min(static_cast<int>(y), rows - 2), x0 = std::min(static_cast<int>(x), columns - 2);
    const auto at = [&](int yy, int xx) { return table[static_cast<size_t>(yy) * static_cast<size_t>(columns) + static_cast<size_t>(xx)]; };
    return glm::mix(glm::mix(at(y0, x0), at(y0, x0 + 1), x - x0), glm::mix(at(y0 + 1, x0), at(y0 + 1, x0 + 1), x - x0), y - y0);
}

template <class Value>
std::vector<glm::dvec3> fill_table(int rows, int columns, Value&& value) {
    std::vector<glm::dvec3> table(static_cast<size_t>(rows) * static_cast<size_t>(columns));
    parallel_for(static_cast<size_t>(rows), 1, [&](size_t begin, size_t end) {
        for (size_t row = begin; row < end; ++row)
            for (int column = 0; column < columns; ++column)
                table[row * static_cast<size_t>(columns) + static_cast<size_t>(column)] =
                    value(kGroundRadius + altitude_of(double(row) / (rows - 1)), cosine_of(double(column) / (columns - 1)));
    });
    return table;
}

}  // namespace

Atmosphere::Atmosphere(double ground_albedo) : ground_albedo_(ground_albedo) {
    transmittance_ = fill_table(kTransmittanceRows, kTransmittanceColumns,
                                [&](double radius, double up) { return integrate_transmittance(radius, up); });
    multiple_ =
        fill_table(kMultipleRows, kMultipleColumns, [&](double radius, double sun_up) { return integrate_multiple(radius, sun_up); });
}

Atmosphere::Medium Atmosphere::medium_at(double altitude) {
    Medium m;
    m.rayleigh = kRayleigh * std::exp(-altitude / kRayleighHeight);
    const double aerosols = std::exp(-altitude / kMieHeight);
    m.mie = kMieScattering * aerosols;
    m.scattering = m.rayleigh + m.mie;
    const double ozone = std::max(0.0, 1.0 - std::abs(altitude - 25'000.0) / 15'000.0);
    m.extinction = m.rayleigh + kMieExtinction * aerosols + kOzone * ozone;
    return m;
}

// Where a ray from this radius leaves the atmosphere, or meets the ground.
Atmosphere::Exit Atmosphere::exit_of(double radius, double up) {
    const double nearest_squared = radius * radius * (1.0 - up * up);  // of the ray to the centre
    const double to_nearest = -radius * up;
    if (up < 0.0 && nearest_squared < kGroundRadius * kGroundRadius)
        return {std::max(0.0, to_nearest - std::sqrt(kGroundRadius * kGroundRadius - nearest_squared)), true};
    return {to_nearest + std::sqrt(std::max(0.0, kTopRadius * kTopRadius - nearest_squared)), false};
}

glm::dvec3 Atmosphere::integrate_transmittance(double radius, double up) const {
    constexpr int kSteps = 48;
    // The ground is left to its own shadow edge: rays that only just meet it are taken as passing, so that the table is smooth.
    const double length = exit_of(radius, std::max(up, -std::sqrt(std::max(0.0, 1.0 - (kGroundRadius / radius) * (kGroundRadius / radius))))).distance;
    glm::dvec3 depth(0.0);
    for (int i = 0; i < kSteps; ++i) {
        const Step step = growing_step(i, kSteps, length);
        depth += medium_at(radius_after(radius, up, step.middle) - kGroundRadius).extinction * step.length;
    }
    return glm::exp(-depth);
}

glm::dvec3 Atmosphere::transmittance(double altitude, double up) const {
    const double radius = kGroundRadius + std::max(0.0, altitude);
    const double sine = kGroundRadius / radius, horizon = -std::sqrt(std::max(0.0, 1.0 - sine * sine));
    if (up < horizon) return glm::dvec3(0.0);
    return bilinear(transmittance_, kTransmittanceRows, kTransmittanceColumns, row_of(altitude), column_of(up));
}

glm::dvec3 Atmosphere::sun_illuminance(double altitude, double up) const {
    return kSolarIrradiance * kSunLuminance * transmittance(altitude, up);
}

glm::dvec3 Atmosphere::integrate_multiple(double radius, double sun_up) const {
    constexpr int kPolar = 8, kAzimuth = 8, kSteps = 20;
    const glm::dvec3 to_sun(std::sqrt(std::max(0.0, 1.0 - sun_up * sun_up)), sun_up, 0.0);
    glm::dvec3 second(0.0), again(0.0);  // second-order light; what one further order keeps
    for (int p = 0; p < kPolar; ++p)
        for (int a = 0; a < kAzimuth; ++a) {
            const double up = 1.0 - 2.0 * (p + 0.5) / kPolar, phi = 2.0 * std::numbers::pi * (a + 0.5) / kAzimuth, across = std::sqrt(1.0 - up * up);
            const glm::dvec3 direction(across * std::cos(phi), up, across * std::sin(phi));
            const Exit exit = exit_of(radius, up);
            glm::dvec3 passed(1.0), light(0.0), kept(0.0);
            for (int i = 0; i < kSteps; ++i) {
                const double step = exit.distance / kSteps, distance = (i + 0.5) * step;
                const glm::dvec3 point = glm::dvec3(0.0, radius, 0.0) + distance * direction;
                const double r = glm::length(point);
                const Medium m = medium_at(r - kGroundRadius);
                const glm::dvec3 through = glm::exp(-m.extinction * step), scattered = m.scattering * (1.0 - through) / m.extinction;
                kept += passed * scattered;
                light += passed * scattered * transmittance(r - kGroundRadius, glm::dot(point, to_sun) / r) / (4.0 * std::numbers::pi);
                passed *= through;
            }
            if (exit.ground) {
                const glm::dvec3 normal = glm::normalize(glm::dvec3(0.0, radius, 0.0) + exit.distance * direction);
                const double facing = glm::dot(normal, to_sun);
                if (facing > 0.0) light += passed * transmittance(0.0, facing) * facing * ground_albedo_ / std::numbers::pi;
            }
            second += light / double(kPolar * kAzimuth);
            again += kept / double(kPolar * kAzimuth);
        }
    return second / (1.0 - again);
}

glm::dvec3 Atmosphere::multiple(double altitude, double sun_up) const {
    return bilinear(multiple_, kMultipleRows, kMultipleColumns, row_of(altitude), column_of(sun_up));
}

Atmosphere::Seen Atmosphere::look(double altitude, glm::dvec3 direction, glm::dvec3 to_sun) const {
    constexpr int kSteps = 40;
    const double radius = kGroundRadius + std::max(1.0, altitude);
    const Exit exit = exit_of(radius, direction.y);
    const double cosine = glm::dot(direction, to_sun), rayleigh = rayleigh_phase(cosine), mie = mie_phase(cosine);
    glm::dvec3 passed(1.0), light(0.0);
    for (int i = 0; i < kSteps; ++i) {
        const Step step = growing_step(i, kSteps, exit.distance);
        const glm::dvec3 point = glm::dvec3(0.0, radius, 0.0) + step.middle * direction;
        const double r = glm::length(point), sun_up = glm::dot(point, to_sun) / r;
        const Medium m = medium_at(r - kGroundRadius);
        const glm::dvec3 source = transmittance(r - kGroundRadius, sun_up) * (m.rayleigh * rayleigh + glm::dvec3(m.mie * mie)) +
                                  m.scattering * multiple(r - kGroundRadius, sun_up);
        const glm::dvec3 through = glm::exp(-m.extinction * step.length);
        light += passed * source * (1.0 - through) / m.extinction;
        passed *= through;
    }
    return {light * kSolarIrradiance * kSkyLuminance, exit.ground ? passed : glm::dvec3(0.0)};
}

}  // namespace parhelion
