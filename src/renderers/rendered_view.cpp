#include "renderers/rendered_view.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.h"

namespace parhelion {

gpu::Extent rendered_extent(gpu::Extent picture, double upscale) {
    if (!(upscale >= 1.0 && upscale <= kMostUpscale))
        throw Error(ErrorCode::Usage, fmt::format("{} is out of range", upscale), "--upscale", fmt::format("from 1 to {}", kMostUpscale));
    const auto length = [&](uint32_t pixels) { return static_cast<uint32_t>(std::ceil(pixels / upscale)); };
    return {length(picture.width), length(picture.height)};
}

void check_upscaled_layers(std::span<const std::string> aovs) {
    constexpr std::array<std::string_view, 4> kOfThePicture = {"depth", "ids", "motion", "variance"};
    for (const std::string& aov : aovs)
        if (std::ranges::find(kOfThePicture, aov) == kOfThePicture.end())
            throw Error(ErrorCode::Usage, fmt::format("{} has a value a traced pixel, and --upscale traces fewer than the picture has", escape_name(aov)), "--aov",
                        "leave --upscale out, or ask for depth, ids, motion and variance alone");
}

RenderedView::RenderedView(const gpu::DevicePtr& device, const View& picture, gpu::Extent size) : film_(picture.film()) {
    check_upscaled_layers(picture.desc().aovs);
    film_.view = gpu::Buffer(device, "view/rendered", sizeof(shared::ViewData));
    film_.width = size.width;
    film_.height = size.height;
    film_.channel_count = 0;
}

void RenderedView::prepare(Frame& frame, const View& picture) {
    shared::ViewData data = picture.data();
    const float wider = std::sqrt(static_cast<float>(data.width) * static_cast<float>(data.height) / (static_cast<float>(film_.width) * static_cast<float>(film_.height)));
    data.width = film_.width;
    data.height = film_.height;
    data.pixel_width *= wider;
    data.pixel_spread *= wider;
    std::ranges::fill(data.channel, shared::kNoChannel);
    data.channel_count = 0;
    frame.upload(film_.view, 0, std::as_bytes(std::span(&data, 1)));
}

}  // namespace parhelion
