#include "passes/post/post.h"

namespace parhelion::passes {

namespace {

struct SplitPush {
    uint32_t width, height, line;
};

}  // namespace

void split(Frame& frame, const gpu::Image& left, const gpu::Image& right, const gpu::Image& ldr, uint32_t line) {
    frame.compute("post/split")
        .read("left", left)
        .read("right", right)
        .write("ldr", ldr)
        .push(SplitPush{.width = ldr.extent().width, .height = ldr.extent().height, .line = line})
        .over(ldr.extent());
}

}  // namespace parhelion::passes
