#pragma once
// A picture against its reference: every number that `parhelion compare` prints.
#include <optional>
#include <string>

#include "image/flip.h"
#include "image/metrics.h"
#include "image/tonemap.h"

namespace parhelion::image {

struct CompareOptions {
    std::string layer = {};                                        // "" is the beauty
    std::optional<double> exposure_scale = {};                     // for both images; none: see auto_exposure_scale
    ToneCurve curve = ToneCurve::Agx;                              // for PSNR and SSIM
    double pixels_per_degree = kPixelsPerDegree;                   // for FLIP
    std::string test_name = "test", reference_name = "reference";  // for messages
};

// mse, relmse and max_abs_error are of exposed linear values; psnr and ssim are of the display's sRGB values (all three channels;
// luma by Rec.709 weights), where NaN is black. Pictures from eight-bit files are compared as they are: scale 1, no curve,
// LDR-FLIP.
struct Comparison {
    uint32_t width = 0, height = 0;
    bool display_referred = false;
    double exposure_scale = 1.0;
    MeanRatio mean_ratio = {};
    double mse = 0.0, relmse = 0.0, max_abs_error = 0.0;
    double psnr = 0.0;  // infinite for equal pictures
    double ssim = 0.0;
    BadPixels bad = {}, reference_bad = {};  // of test and reference
    Flip flip = {};                          // HDR-FLIP of radiance, LDR-FLIP of display pictures
};

// Throws Error where sizes differ, where one image is a display picture and the other is radiance, or where a layer is missing.
Comparison compare_images(const ImageF& test, const ImageF& reference, const CompareOptions& options = {});

// The scale that brings the geometric mean luminance of the lit pixels to 0.18 (Reinhard et al., "Photographic Tone Reproduction
// for Digital Images", 2002); 1 for a black image. For references that record no exposure.
double auto_exposure_scale(const RgbPlanes& reference);

}  // namespace parhelion::image
