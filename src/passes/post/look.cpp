#include "passes/post/post.h"

namespace parhelion::passes {

namespace {

struct LookPush {
    uint32_t width, height;
    float gain;
    uint32_t channel_count;
};

uint32_t channels_of(gpu::Format format) {
    using F = gpu::Format;
    switch (format) {
        case F::R8Unorm: case F::R16Float: case F::R32Float: case F::R32Uint: case F::Depth32Float: return 1;
        case F::Rg8Unorm: case F::Rg16Float: case F::Rg32Float: return 2;
        default: return 4;
    }
}

}  // namespace

void look(Frame& frame, const gpu::Image& image, const gpu::Image& ldr, float gain) {
    const bool whole = image.desc().format == gpu::Format::R32Uint || image.desc().format == gpu::Format::Rgba32Uint;
    const gpu::Sampler nearest(frame.device(), {.mag = gpu::Filter::Nearest, .min = gpu::Filter::Nearest, .mip = gpu::Filter::Nearest});
    frame.compute("post/look", whole ? "+WHOLE" : "")
        .sample("image", image, nearest)
        .write("ldr", ldr)
        .push(LookPush{.width = ldr.extent().width, .height = ldr.extent().height, .gain = gain, .channel_count = channels_of(image.desc().format)})
        .over(ldr.extent());
}

}  // namespace parhelion::passes
