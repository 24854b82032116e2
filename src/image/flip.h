#pragma once
// FLIP: how different two images look when one alternates between them.
//   LDR: Andersson, Nilsson, Akenine-Moller, Oskarsson, Astrom, Fairchild, "FLIP: A Difference Evaluator for Alternating
//        Images", PACMCGIT 3(2), 2020.
//   HDR: Andersson, Nilsson, Shirley, Akenine-Moller, "Visualizing Errors in Rendered High Dynamic Range Images", EGSR 2021.
#include <cstdint>
#include <vector>

#include "image/image.h"

namespace parhelion::image {

// 0.7 m from a screen of 3840 pixels over 0.7 m, the papers' set-up: 67.02.
inline constexpr double kPixelsPerDegree = 3840.0 * 3.14159265358979323846 / 180.0;

struct Flip {
    double mean = 0.0;
    std::vector<float> map = {};  // per pixel, 0 (equal) to 1
    // HDR only: the images were compared at exposures 2^start ... 2^stop; the map is the largest error over them.
    double start_exposure = 0.0, stop_exposure = 0.0;
    uint32_t exposures = 0;
};

// Linear Rec.709 in [0,1]; values outside are clamped. NaN counts as 0.
Flip flip_ldr(const RgbPlanes& reference, const RgbPlanes& test, uint32_t width, uint32_t height, double pixels_per_degree = kPixelsPerDegree);

// Linear Rec.709 of any scale. Negative and non-finite values count as 0; count them apart. The exposures run from where the
// reference's brightest pixel to where its median pixel comes to 85 % of the (ACES) curve, in steps of at most a stop. Where the
// median pixel is black, which would ask for infinite exposure, the median of the pixels that are not black is taken; where the
// reference is black altogether, the test's pixels. Exposures span 40 stops at most.
Flip flip_hdr(const RgbPlanes& reference, const RgbPlanes& test, uint32_t width, uint32_t height, double pixels_per_degree = kPixelsPerDegree);

// The map in colours: black (equal), purple, orange, pale yellow (as different as can be).
Picture8 flip_picture(const Flip& flip, uint32_t width, uint32_t height);

}  // namespace parhelion::image
