#include "image/tonemap.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"

namespace parhelion::image {

namespace {

using Matrix = std::array<Rgb, 3>;  // rows

Rgb multiply(const Matrix& m, const Rgb& v) {
    Rgb out;
    for (size_t i = 0; i < 3; ++i) out[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
    return out;
}

float saturate(float v) { return std::clamp(v, 0.0f, 1.0f); }

// Rec.709 -> AP1 with the RRT's saturation, a rational fit of RRT and ODT in one, ODT saturation -> Rec.709 (Hill 2016).
Rgb aces(const Rgb& exposed) {
    static constexpr Matrix kInput = {{{0.59719f, 0.35458f, 0.04823f}, {0.07600f, 0.90834f, 0.01566f}, {0.02840f, 0.13383f, 0.83777f}}};
    static constexpr Matrix kOutput = {{{1.60475f, -0.53108f, -0.07367f}, {-0.10208f, 1.10813f, -0.00605f}, {-0.00327f, -0.07276f, 1.07602f}}};
    Rgb v = multiply(kInput, exposed);
    for (float& x : v) x = (x * (x + 0.0245786f) - 0.000090537f) / (x * (0.983729f * x + 0.4329510f) + 0.238081f);
    return multiply(kOutput, v);
}

// AgX: inset to wider primaries, log2 over -12.47..4.03 stops around 18 % grey, the contrast curve as a sixth-order polynomial,
// outset. The result is encoded for a 2.2 power display; it is brought back to linear light here (Wrensch 2023).
Rgb agx(const Rgb& exposed) {
    static constexpr Matrix kInset = {{{0.842479062253094f, 0.0784335999999992f, 0.0792237451477643f},
                                       {0.0423282422610123f, 0.878468636469772f, 0.0791661274605434f},
                                       {0.0423756549057051f, 0.0784336f, 0.879142973793104f}}};
    static constexpr Matrix kOutset = {{{1.19687900512017f, -0.0980208811401368f, -0.0990297440797205f},
                                        {-0.0528968517574562f, 1.15190312990417f, -0.0989611768448433f},
                                        {-0.0529716355144438f, -0.0980434501171241f, 1.15107367264116f}}};
    static constexpr float kMinStops = -12.47393f, kMaxStops = 4.026069f;
    Rgb v = multiply(kInset, exposed);
    for (float& component : v) {
        const float stops = std::clamp(std::log2(std::max(component, 1e-10f)), kMinStops, kMaxStops);
        const float x = (stops - kMinStops) / (kMaxStops - kMinStops);
        const float x2 = x * x, x4 = x2 * x2;
        component = 15.5f * x4 * x2 - 40.14f * x4 * x + 31.96f * x4 - 6.868f * x2 * x + 0.4298f * x2 + 0.1191f * x - 0.00232f;
    }
    v = multiply(kOutset, v);
    for (float& component : v) component = std::pow(std::max(component, 0.0f), 2.2f);
    return v;
}

}  // namespace

double exposure_scale_from_ev100(double ev100) { return 1.0 / (1.2 * std::exp2(ev100)); }

Rgb apply_tone_curve(const Rgb& exposed, ToneCurve curve) {
    // The upper bound keeps the rational fit's squares finite; every curve is white long before.
    static constexpr float kWhite = 1e9f;
    Rgb v;
    for (size_t i = 0; i < 3; ++i) v[i] = exposed[i] > 0.0f ? std::min(exposed[i], kWhite) : 0.0f;
    if (curve == ToneCurve::Aces) v = aces(v);
    if (curve == ToneCurve::Agx) v = agx(v);
    for (float& component : v) component = saturate(component);
    return v;
}

Picture8 tonemap_to_srgb(const ImageF& image, ToneCurve curve, double exposure_scale, std::string_view layer) {
    const RgbPlanes planes = rgb_planes(image, layer);
    const float scale = static_cast<float>(exposure_scale);
    Picture8 out{.width = image.width, .height = image.height};
    out.rgb.resize(3 * image.pixel_count());
    parallel_for(image.pixel_count(), 16384, [&](size_t begin, size_t end) {
        for (size_t p = begin; p < end; ++p) {
            const Rgb display = apply_tone_curve({planes.r[p] * scale, planes.g[p] * scale, planes.b[p] * scale}, curve);
            for (size_t c = 0; c < 3; ++c) out.rgb[3 * p + c] = static_cast<uint8_t>(saturate(srgb_from_linear(display[c])) * 255.0f + 0.5f);
        }
    });
    return out;
}

}  // namespace parhelion::image
