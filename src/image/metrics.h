#pragma once
// Numbers for how far a picture is from its reference. All take equally large planes in linear Rec.709; a pixel with a
// non-finite value in either image takes part in none of them (count_bad_pixels tells how many there are). Sums are in double
// and do not depend on the number of threads.
#include <cstdint>
#include <span>

#include "image/image.h"

namespace parhelion::image {

// Pixels with at least one such channel.
struct BadPixels {
    uint64_t nan = 0, infinite = 0, negative = 0;
};
BadPixels count_bad_pixels(const RgbPlanes& image);

// Mean of the test over mean of the reference. NaN where both are 0, infinite where the reference alone is.
struct MeanRatio {
    double r = 0.0, g = 0.0, b = 0.0, luminance = 0.0;
};
MeanRatio mean_ratio(const RgbPlanes& test, const RgbPlanes& reference);

// Over all pixels and the three channels.
struct SquaredErrors {
    double mse = 0.0;            // mean of (t - r)^2
    double relmse = 0.0;         // mean of (t - r)^2 / (r^2 + kRelMseEpsilon)
    double max_abs_error = 0.0;  // largest |t - r|
};
// As in Rousselle, Knaus and Zwicker, "Adaptive Sampling and Reconstruction using Greedy Error Minimization", 2011. The constant
// is meant for values around the display's range, so images are exposed before: then it is a tenth of white, squared, and the
// result does not depend on the unit of the radiance.
inline constexpr double kRelMseEpsilon = 0.01;
SquaredErrors squared_errors(const RgbPlanes& test, const RgbPlanes& reference);

// Peak signal-to-noise ratio in dB; infinite for mse 0.
double psnr_from_mse(double mse, double peak = 1.0);

// Structural similarity of two planes in [0,1]: Wang, Bovik, Sheikh and Simoncelli, "Image Quality Assessment: From Error
// Visibility to Structural Similarity", 2004: Gaussian window 11x11 of deviation 1.5, K1 = 0.01, K2 = 0.03, mean over the windows
// that lie inside the image (over all, with repeated borders, where it is smaller than a window).
double ssim(std::span<const float> test, std::span<const float> reference, uint32_t width, uint32_t height);

}  // namespace parhelion::image
