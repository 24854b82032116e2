#include "passes/ui/panels.h"

#include <algorithm>
#include <bit>

namespace parhelion::passes {

namespace {

struct PanelsPush {
    uint64_t vertices, indices;
    float clip_from_px[2];
};

// What changes every frame gets a buffer of a size that seldom does.
gpu::Buffer fill_buffer(Frame& frame, const char* name, std::span<const std::byte> bytes) {
    const gpu::Buffer buffer = frame.buffer(name, std::bit_ceil(std::max<uint64_t>(bytes.size(), 1 << 12)));
    frame.upload(buffer, 0, bytes);
    return buffer;
}

}  // namespace

void panels(Frame& frame, const gpu::Image& target, const gpu::Image& font, const PanelMesh& mesh) {
    std::vector<DrawCall> draws;
    for (const PanelDraw& draw : mesh.draws)
        if (draw.index_count != 0 && draw.clip.width != 0 && draw.clip.height != 0)
            draws.push_back({.draw = {.vertex_count = draw.index_count, .first_vertex = draw.first_index}, .scissor = draw.clip});
    if (draws.empty()) return;
    const gpu::Buffer vertices = fill_buffer(frame, "ui/vertices", std::as_bytes(std::span(mesh.vertices)));
    const gpu::Buffer indices = fill_buffer(frame, "ui/indices", std::as_bytes(std::span(mesh.indices)));
    const gpu::Sampler sampler(frame.device(), {.wrap_u = gpu::Wrap::Clamp, .wrap_v = gpu::Wrap::Clamp});
    const gpu::Extent extent = target.extent();
    Pass pass = frame.raster("ui/panels", {.blend = gpu::Blend::Alpha});
    pass.read("vertices", vertices)
        .read("indices", indices)
        .sample("font", font, sampler)
        .color("color", target)
        .push(PanelsPush{.clip_from_px = {2.0f / static_cast<float>(extent.width), 2.0f / static_cast<float>(extent.height)}})
        .draw(std::move(draws));
}

}  // namespace parhelion::passes
