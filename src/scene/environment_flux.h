#pragma once
// The light of an environment by cells of the sphere: what its light table is made of.
#include <vector>

#include "scene/types.h"

namespace parhelion {

// Radiance's luminance times solid angle, integrated over each of columns x rows cells, which divide azimuth and polar angle evenly;
// rows from the top, without Environment::scale (nit sr). The radiance is the bilinear image as the device reads it, round about in u
// and clamped in v, so the integral is exact whatever the two sizes are, and positive just where something shines. Without an image: of 1.
std::vector<double> environment_flux(const Environment& environment, uint32_t columns, uint32_t rows);

// Solid angle of a cell of that row, sr.
double environment_cell_solid_angle(uint32_t row, uint32_t columns, uint32_t rows);

}  // namespace parhelion
