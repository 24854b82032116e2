#include "image/compare.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.h"
#include "base/parallel.h"

namespace parhelion::image {

namespace {

void check_pair(const ImageF& test, const ImageF& reference, const CompareOptions& options) {
    if (test.width != reference.width || test.height != reference.height)
        throw Error(ErrorCode::Failed,
                    fmt::format("is {}x{} pixels; {} is {}x{}", test.width, test.height, escape_name(options.reference_name), reference.width, reference.height),
                    escape_name(options.test_name), "render both at one size");
    if (test.display_referred != reference.display_referred)
        throw Error(ErrorCode::Failed, fmt::format("cannot be compared with {}: one is a display picture, the other radiance", escape_name(options.reference_name)),
                    escape_name(options.test_name), "give two EXR or HDR files, or two PNG or JPEG files");
}

// R, G, B of the layer, scaled.
ImageF exposed(const RgbPlanes& planes, const ImageF& image, double scale) {
    ImageF out = make_image(image.width, image.height, {"R", "G", "B"});
    const std::array<std::span<const float>, 3> in = {planes.r, planes.g, planes.b};
    for (size_t c = 0; c < 3; ++c)
        std::transform(in[c].begin(), in[c].end(), out.plane(c).begin(), [&](float v) { return v * static_cast<float>(scale); });
    return out;
}

// What the display gets: sRGB values in [0,1] of an exposed image.
ImageF display_values(const ImageF& image, ToneCurve curve) {
    const RgbPlanes in = rgb_planes(image);
    ImageF out = make_image(image.width, image.height, {"R", "G", "B", "luma"});
    const size_t pixels = image.pixel_count();
    parallel_for(pixels, 16384, [&](size_t begin, size_t end) {
        for (size_t p = begin; p < end; ++p) {
            const Rgb shown = apply_tone_curve({in.r[p], in.g[p], in.b[p]}, curve);
            for (size_t c = 0; c < 3; ++c) out.data[c * pixels + p] = srgb_from_linear(shown[c]);
            out.data[3 * pixels + p] = luminance(out.data[p], out.data[pixels + p], out.data[2 * pixels + p]);
        }
    });
    return out;
}

}  // namespace

double auto_exposure_scale(const RgbPlanes& reference) {
    double logs = 0;
    uint64_t lit = 0;
    for (size_t p = 0; p < reference.r.size(); ++p) {
        const double value = luminance<double>(reference.r[p], reference.g[p], reference.b[p]);
        if (!std::isfinite(value) || value <= 0) continue;
        logs += std::log(value);
        ++lit;
    }
    return lit == 0 ? 1.0 : 0.18 / std::exp(logs / static_cast<double>(lit));
}

Comparison compare_images(const ImageF& test, const ImageF& reference, const CompareOptions& options) {
    check_pair(test, reference, options);
    const RgbPlanes raw_test = rgb_planes(test, options.layer, options.test_name), raw_reference = rgb_planes(reference, options.layer, options.reference_name);
    Comparison out{.width = test.width, .height = test.height, .display_referred = test.display_referred};
    if (!out.display_referred) out.exposure_scale = options.exposure_scale ? *options.exposure_scale : auto_exposure_scale(raw_reference);
    PARHELION_CHECK(std::isfinite(out.exposure_scale) && out.exposure_scale > 0, "an exposure scale of {}", out.exposure_scale);
    out.bad = count_bad_pixels(raw_test);
    out.reference_bad = count_bad_pixels(raw_reference);

    const ImageF exposed_test = exposed(raw_test, test, out.exposure_scale), exposed_reference = exposed(raw_reference, reference, out.exposure_scale);
    const RgbPlanes t = rgb_planes(exposed_test), r = rgb_planes(exposed_reference);
    out.mean_ratio = mean_ratio(t, r);
    const SquaredErrors errors = squared_errors(t, r);
    out.mse = errors.mse;
    out.relmse = errors.relmse;
    out.max_abs_error = errors.max_abs_error;

    const ToneCurve curve = out.display_referred ? ToneCurve::Linear : options.curve;
    const ImageF shown_test = display_values(exposed_test, curve), shown_reference = display_values(exposed_reference, curve);
    out.psnr = psnr_from_mse(squared_errors(rgb_planes(shown_test), rgb_planes(shown_reference)).mse);
    out.ssim = ssim(shown_test.plane(3), shown_reference.plane(3), out.width, out.height);
    out.flip = out.display_referred ? flip_ldr(r, t, out.width, out.height, options.pixels_per_degree)
                                    : flip_hdr(r, t, out.width, out.height, options.pixels_per_degree);
    return out;
}

}  // namespace parhelion::image
