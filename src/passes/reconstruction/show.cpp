#include "passes/reconstruction/reconstruction.h"

namespace parhelion::passes {

namespace {

struct ShowPush {
    uint64_t view, diffuse, specular, emission, distances, planes;
};

}  // namespace

void show_input(Frame& frame, const ReconstructionInput& input, const gpu::Buffer& planes) {
    frame.compute("reconstruction/show")
        .read("view", input.film.view)
        .read("identity", input.gbuffer.identity)
        .read("summary", input.gbuffer.summary)
        .read("motion", input.gbuffer.motion)
        .read("depth", input.gbuffer.depth)
        .read("diffuse", input.signals.diffuse)
        .read("specular", input.signals.specular)
        .read("emission", input.signals.emission)
        .read("distances", input.signals.distances)
        .write("planes", planes)
        .push(ShowPush{})
        .over(input.gbuffer.identity.extent());
}

}  // namespace parhelion::passes
