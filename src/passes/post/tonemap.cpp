#include "passes/post/post.h"

namespace parhelion::passes {

namespace {

struct TonemapPush {
    uint32_t width, height;
    float exposure_scale;
    ToneCurve curve;
};

}  // namespace

void tonemap(Frame& frame, const gpu::Image& hdr, const gpu::Image& ldr, float exposure_scale, ToneCurve curve) {
    const gpu::Extent extent = ldr.extent();
    frame.compute("post/tonemap")
        .read("hdr", hdr)
        .write("ldr", ldr)
        .push(TonemapPush{.width = extent.width, .height = extent.height, .exposure_scale = exposure_scale, .curve = curve})
        .over(extent);
}

}  // namespace parhelion::passes
