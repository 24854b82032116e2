#include "passes/post/post.h"

namespace parhelion::passes {

namespace {

struct ResolvePush {
    uint64_t block, sums;
    uint32_t width, height;
    float inv_count;
};

}  // namespace

gpu::Image resolve(Frame& frame, const gpu::Buffer& sums, const gpu::Buffer& block, uint32_t width, uint32_t height, uint64_t sample_count) {
    const gpu::Image hdr = frame.image("post/resolve.hdr", {width, height}, gpu::Format::Rgba32Float);
    frame.compute("post/resolve")
        .read("sums", sums)
        .read("block", block)
        .write("hdr", hdr)
        .push(ResolvePush{.width = width, .height = height, .inv_count = 1.0f / static_cast<float>(sample_count)})
        .over(hdr.extent());
    return hdr;
}

}  // namespace parhelion::passes
