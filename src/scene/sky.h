#pragma once
// A clear sky with its sun, for scenes without light.
#include "scene/types.h"

namespace parhelion {

struct SkyOptions {
    // Radians. Azimuth 0 is +Z (behind a camera that looks along -Z), growing towards +X.
    float sun_elevation = 0.6981317f, sun_azimuth = 0.7853982f;
    float ground_albedo = 0.2f;
    uint32_t rows = 256;  // of the map, which has twice as many columns
};

struct Sky {
    Environment environment;  // without the sun's disk
    Light sun;                // directional, 0.53 degrees wide; its place is set by placement of -Z away from the sun
};

// Physically based (atmosphere.h), seen from 2 m above the ground; nits and lux. With the sun below the horizon it is dusk or night.
Sky make_clear_sky(const SkyOptions& options = {});

}  // namespace parhelion
