#pragma once
// Inside the image library: separable filters on planes.
#include <cstdint>
#include <span>
#include <vector>

namespace parhelion::image {

using Plane = std::vector<float>;

// 2 radius + 1 weights; the middle one belongs to the pixel itself.
using Kernel = std::vector<float>;

// out(x, y) = sum over k of kernel[k] * in(x + k - radius, y), and the same along y. Outside the image its border pixels repeat.
// Parallel over rows.
void filter_rows(std::span<const float> in, Plane& out, uint32_t width, uint32_t height, const Kernel& kernel);
void filter_columns(std::span<const float> in, Plane& out, uint32_t width, uint32_t height, const Kernel& kernel);

// Gaussian with deviation sigma in pixels, cut at the radius, of sum 1.
Kernel gaussian_kernel(double sigma, int radius);

}  // namespace parhelion::image
