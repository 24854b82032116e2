#include "renderers/kept_input.h"

#include <array>

#include "base/error.h"

namespace parhelion {

std::span<const InputPlane> input_planes() {
    using enum InputForm;
    static constexpr std::array<InputPlane, shared::kInputPlanes> planes = {{
        {"reconstruction.diffuse.R", Number},
        {"reconstruction.diffuse.G", Number},
        {"reconstruction.diffuse.B", Number},
        {"reconstruction.specular.R", Number},
        {"reconstruction.specular.G", Number},
        {"reconstruction.specular.B", Number},
        {"reconstruction.emission.R", Number},
        {"reconstruction.emission.G", Number},
        {"reconstruction.emission.B", Number},
        {"reconstruction.albedo.R", Number},
        {"reconstruction.albedo.G", Number},
        {"reconstruction.albedo.B", Number},
        {"reconstruction.specular_albedo.R", Number},
        {"reconstruction.specular_albedo.G", Number},
        {"reconstruction.specular_albedo.B", Number},
        {"reconstruction.normal.X", Number},
        {"reconstruction.normal.Y", Number},
        {"reconstruction.normal.Z", Number},
        {"reconstruction.normal_geometric.X", Number},
        {"reconstruction.normal_geometric.Y", Number},
        {"reconstruction.normal_geometric.Z", Number},
        {"reconstruction.roughness", Number},
        {"reconstruction.hit.diffuse", Number},
        {"reconstruction.hit.specular", Number},
        {"reconstruction.depth", Exact},
        {"reconstruction.motion.X", Exact},
        {"reconstruction.motion.Y", Exact},
        {"reconstruction.surface", Whole},
        {"reconstruction.ids.instance", Whole},
        {"reconstruction.ids.geometry", Whole},
        {"reconstruction.ids.primitive", Whole},
    }};
    return planes;
}

void KeptInput::record(Frame& frame, const passes::ReconstructionInput& input, const shared::ViewData& view) {
    about_ = {.size = input.gbuffer.identity.extent(), .camera = view.camera, .camera_before = view.camera_before, .jitter_px = input.jitter_px, .exposure = input.exposure, .cut = input.cut};
    const uint64_t bytes = sizeof(uint32_t) * shared::kInputPlanes * about_.size.width * about_.size.height;
    if (!planes_ || planes_.bytes() != bytes) planes_ = gpu::Buffer(frame.device(), "reconstruction/input", bytes);
    passes::show_input(frame, input, planes_);
}

InputReadback KeptInput::read(Frame& frame) const {
    PARHELION_CHECK(bool(planes_), "no frame's input has been kept");
    const gpu::Buffer copy = frame.read_back(planes_);
    frame.run();
    InputReadback input = about_;
    const std::span<uint32_t> words = copy.mapped_as<uint32_t>();
    input.words.assign(words.begin(), words.end());
    return input;
}

}  // namespace parhelion
