#pragma once
// A clear atmosphere over a spherical planet: how much sunlight arrives, and how much light comes from each direction of the sky.
// Method: Bruneton and Neyret 2008 (model), Hillaire 2020 (multiple scattering as a geometric series of one isotropic order);
// coefficients of the clear Earth from Bruneton 2017, at 680, 550 and 440 nm for red, green and blue. All radiances are in nits of
// linear Rec. 709, by Bruneton 2017's factors from spectral radiance to luminance. Lengths are metres, angles radians.
#include <vector>

#include <glm/glm.hpp>

namespace parhelion {

class Atmosphere {
public:
    // `ground_albedo`: of the whole planet, for light that it sends back into the air.
    explicit Atmosphere(double ground_albedo);

    // Share of light that passes from a point at this altitude to space, towards a direction whose cosine with the vertical is
    // `up`; black where the planet is in the way.
    glm::dvec3 transmittance(double altitude, double up) const;
    // Illuminance of a surface that faces the sun (cosine with the vertical `up`), lux.
    glm::dvec3 sun_illuminance(double altitude, double up) const;
    // What arrives at a viewer at `altitude` along -direction, without the sun's disk; both directions unit, y is up.
    struct Seen {
        glm::dvec3 air;     // radiance of the air in between
        glm::dvec3 ground;  // share of the ground's own radiance that comes through; black if the direction meets none
    };
    Seen look(double altitude, glm::dvec3 direction, glm::dvec3 to_sun) const;

private:
    struct Medium {
        glm::dvec3 rayleigh, scattering, extinction;  // per metre; scattering of both kinds
        double mie;
    };
    struct Exit {
        double distance;
        bool ground;
    };
    static Medium medium_at(double altitude);
    static Exit exit_of(double radius, double up);
    glm::dvec3 integrate_transmittance(double radius, double up) const;
    // Light scattered once or twice into every direction alike, per unit of sunlight (Hillaire 2020, equations 5 to 10).
    glm::dvec3 integrate_multiple(double radius, double sun_up) const;
    glm::dvec3 multiple(double altitude, double sun_up) const;

    double ground_albedo_;
    std::vector<glm::dvec3> transmittance_, multiple_;  // tables over altitude and cosine
};

}  // namespace parhelion
