#include "passes/post/post.h"

namespace parhelion::passes {

namespace {

struct ResolvePush {
    uint64_t block, sums;
    uint32_t width, height, rows_ahead, first_channel, channel_count;
    float gain, gain_ahead, bias;
};

float gain_of(uint64_t samples, float gain) { return samples == 0 ? 0.0f : gain / static_cast<float>(samples); }

}  // namespace

gpu::Image resolve(Frame& frame, const gpu::Buffer& sums, const gpu::Buffer& block, uint32_t width, uint32_t height, const Shown& shown, const std::string& name) {
    const gpu::Image hdr = frame.image(name, {width, height}, gpu::Format::Rgba32Float);
    frame.compute("post/resolve")
        .read("sums", sums)
        .read("block", block)
        .write("hdr", hdr)
        .push(ResolvePush{.width = width,
                          .height = height,
                          .rows_ahead = shown.rows_ahead,
                          .first_channel = shown.first_channel,
                          .channel_count = shown.channel_count,
                          .gain = gain_of(shown.samples, shown.gain),
                          .gain_ahead = gain_of(shown.samples_ahead, shown.gain),
                          .bias = shown.bias})
        .over(hdr.extent());
    return hdr;
}

}  // namespace parhelion::passes
