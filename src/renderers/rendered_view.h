#pragma once
// The pixels that are traced where a picture has more of them than its frames (--upscale).
#include "renderers/view.h"

namespace parhelion {

constexpr double kMostUpscale = 3.0;

// Pixels of a frame whose picture is `upscale` times as wide and high, rounded up. Throws a usage Error for less than 1 and more than kMostUpscale.
gpu::Extent rendered_extent(gpu::Extent picture, double upscale);

// Throws a usage Error for layers that have a value a traced pixel, and so none a pixel of a picture with more of them. First hits have
// rays of their own, and variance is the picture's.
void check_upscaled_layers(std::span<const std::string> aovs);

// A view as the passes of its frames see it: fewer pixels, with wider cones, and a film that keeps nothing.
class RenderedView {
public:
    RenderedView(const gpu::DevicePtr& device, const View& picture, gpu::Extent size);

    // Takes over the camera and the jitter of the picture's view; first of a frame.
    void prepare(Frame& frame, const View& picture);
    const passes::Film& film() const { return film_; }

private:
    passes::Film film_;
};

}  // namespace parhelion
