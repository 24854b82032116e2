#pragma once
// From radiance to display on the CPU: exposure, tone curve, sRGB.
#include <array>
#include <cstdint>
#include <string_view>

#include "image/image.h"

namespace parhelion::image {

// Linear: clamp only.
// Aces: Stephen Hill's fit of the ACES 1.0 RRT and sRGB ODT, with saturation (2016), without an exposure of its own: 18 % grey
//       is shown at 10 % as the transform has it. Chosen over Narkowicz (2015), which fits luminance per channel and so skews hues.
// Agx:  Troy Sobotka's AgX base look (2022) by Benjamin Wrensch's polynomial (2023): bright saturated colours fade to white.
enum class ToneCurve : uint32_t { Linear, Aces, Agx };

// 1 / (1.2 * 2^EV100): radiance in nits to display-referred linear light, 1.0 being the sensor's saturation.
// Lagarde and de Rousiers, "Moving Frostbite to Physically Based Rendering", 2014, 5.1.
double exposure_scale_from_ev100(double ev100);

using Rgb = std::array<float, 3>;

// Exposed linear Rec.709 to display-referred linear Rec.709 in [0,1]. Negative and NaN input counts as 0, infinity as white.
Rgb apply_tone_curve(const Rgb& exposed, ToneCurve curve);

// The layer `layer` of `image` (see rgb_planes) x exposure_scale, tone curve, sRGB transfer, rounded to 8 bits.
Picture8 tonemap_to_srgb(const ImageF& image, ToneCurve curve, double exposure_scale, std::string_view layer = {});

}  // namespace parhelion::image
