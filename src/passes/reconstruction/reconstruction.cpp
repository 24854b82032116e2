#include "passes/reconstruction/reconstruction.h"

#include <algorithm>

namespace parhelion::passes {

namespace {

struct AccumulatePush {
    uint64_t view, diffuse, specular, distances, guide_before, diffuse_before, specular_before, state_before, verdicts, guide, diffuse_now, specular_now, normals, state, tiles;
    shared::ReconstructionFrame frame;
};
struct ChangePush {
    uint64_t tiles, verdicts;
    glm::uvec2 size;
    float antilag, history;
};
struct SettlePush {
    uint64_t view, guide, state, diffuse, specular, diffuse_out, specular_out;
    shared::ReconstructionFrame frame;
};
struct FilterPush {
    uint64_t view, guide, normals, state, diffuse_in, specular_in, out, also_out;
    glm::vec2 jitter;
    uint32_t stride;
    float sigmas;
};
struct AntialiasPush {
    uint64_t view, guide, colors, state, verdicts, block;
    glm::uvec2 rendered;
    glm::vec2 jitter;
    float exposure_scale, nits, frames, sharpness, deviations;
    uint32_t has_history, frame_index;
};

gpu::Extent tiles_of(gpu::Extent rendered) {
    const auto tiles = [](uint32_t length) { return (length + shared::kChangeTile - 1) / shared::kChangeTile; };
    return {tiles(rendered.width), tiles(rendered.height)};
}

}  // namespace

ReconstructionHistory make_reconstruction_history(const gpu::DevicePtr& device, gpu::Extent rendered, gpu::Extent picture) {
    const uint64_t pixels = uint64_t{rendered.width} * rendered.height;
    const gpu::Extent tiles = tiles_of(rendered);
    const auto buffer = [&](const char* name, uint64_t bytes) { return gpu::Buffer(device, name, bytes); };
    return {.diffuse = buffer("reconstruction/diffuse", 8 * pixels),
            .specular = buffer("reconstruction/specular", 8 * pixels),
            .state = buffer("reconstruction/state", shared::kStatePlanes * sizeof(uint32_t) * pixels),
            .guide = buffer("reconstruction/guide", 8 * pixels),
            .tiles = buffer("reconstruction/tiles", uint64_t{tiles.width} * tiles.height * sizeof(shared::ChangeTile)),
            .picture = gpu::Image(device, "reconstruction/picture", {.format = gpu::Format::Rgba16Float, .extent = picture}),
            .shown = gpu::Image(device, "reconstruction/shown", {.format = gpu::Format::Rg8Unorm, .extent = picture})};
}

gpu::Buffer judge_changes(const ReconstructionPass& pass) {
    const gpu::Extent tiles = tiles_of(pass.input.gbuffer.identity.extent());
    const gpu::Buffer verdicts = pass.frame.buffer("reconstruction/verdicts", uint64_t{tiles.width} * tiles.height * sizeof(shared::ChangeVerdict));
    pass.frame.compute("reconstruction/change")
        .read("tiles", pass.before.tiles)
        .write("verdicts", verdicts)
        .push(ChangePush{.size = {tiles.width, tiles.height}, .antilag = pass.settings.has_history != 0 ? pass.settings.antilag : 0.0f, .history = static_cast<float>(pass.settings.history)})
        .over(tiles);
    return verdicts;
}

void accumulate_light(const ReconstructionPass& pass, const gpu::Buffer& verdicts) {
    const ReconstructionInput& in = pass.input;
    pass.frame.compute("reconstruction/accumulate")
        .read("view", in.film.view)
        .read("identity", in.gbuffer.identity)
        .read("summary", in.gbuffer.summary)
        .read("motion", in.gbuffer.motion)
        .read("depth", in.gbuffer.depth)
        .read("diffuse", in.signals.diffuse)
        .read("specular", in.signals.specular)
        .read("distances", in.signals.distances)
        .read("guide_before", pass.before.guide)
        .read("diffuse_before", pass.before.diffuse)
        .read("specular_before", pass.before.specular)
        .read("state_before", pass.before.state)
        .read("verdicts", verdicts)
        .write("guide", pass.now.guide)
        .write("diffuse_now", pass.now.diffuse)
        .write("specular_now", pass.now.specular)
        .write("normals", pass.normals)
        .write("state", pass.now.state)
        .write("tiles", pass.now.tiles)
        .push(AccumulatePush{.frame = pass.settings})
        .over(in.gbuffer.identity.extent());
}

void settle_history(const ReconstructionPass& pass) {
    pass.frame.compute("reconstruction/settle")
        .read("view", pass.input.film.view)
        .read("guide", pass.now.guide)
        .read("state", pass.now.state)
        .read_write("diffuse", pass.now.diffuse)
        .read_write("specular", pass.now.specular)
        .write("diffuse_out", pass.input.signals.diffuse)
        .write("specular_out", pass.input.signals.specular)
        .push(SettlePush{.frame = pass.settings})
        .over(pass.input.gbuffer.identity.extent());
}

const gpu::Buffer& filter_light(const ReconstructionPass& pass, uint32_t index) {
    const ReconstructionInput& in = pass.input;
    const bool last = index + 1 >= pass.options.steps, even = index % 2 == 0;
    const gpu::Buffer &diffuse_in = even ? in.signals.diffuse : pass.before.diffuse, &specular_in = even ? in.signals.specular : pass.before.specular;
    const gpu::Buffer &diffuse_out = even ? pass.before.diffuse : in.signals.diffuse, &specular_out = even ? pass.before.specular : in.signals.specular;
    Pass filter = pass.frame.compute("reconstruction/filter", last ? "+COMPOSITE" : "");
    filter.read("view", in.film.view)
        .read("guide", pass.now.guide)
        .read("normals", pass.normals)
        .read("state", pass.now.state)
        .read("diffuse_in", diffuse_in)
        .read("specular_in", specular_in)
        .push(FilterPush{.jitter = in.jitter_px, .stride = pass.options.steps == 0 ? 0u : 1u << index, .sigmas = pass.options.sigmas});
    if (last) filter.read("summary", in.gbuffer.summary).read("emission", in.signals.emission).write("colors", diffuse_out);
    else filter.write("diffuse_out", diffuse_out).write("specular_out", specular_out);
    filter.over(in.gbuffer.identity.extent());
    return diffuse_out;
}

void antialias(const ReconstructionPass& pass, const gpu::Buffer& colors, const gpu::Buffer& verdicts, const gpu::Sampler& sampler) {
    const ReconstructionInput& in = pass.input;
    const Film& film = in.picture != nullptr ? *in.picture : in.film;
    const gpu::Extent rendered = in.gbuffer.identity.extent();
    pass.frame.compute("reconstruction/antialias")
        .read("view", film.view)
        .read("motion", in.gbuffer.motion)
        .read("guide", pass.now.guide)
        .read("state", pass.now.state)
        .read("colors", colors)
        .read("verdicts", verdicts)
        .sample("history", pass.before.picture, sampler)
        .read("shown_before", pass.before.shown)
        .write("picture", pass.now.picture)
        .write("shown", pass.now.shown)
        .read_write("block", film.block)
        .push(AntialiasPush{.rendered = {rendered.width, rendered.height},
                            .jitter = in.jitter_px,
                            .exposure_scale = pass.settings.exposure_scale,
                            .nits = 1.0f / in.exposure,
                            .frames = pass.options.antialias ? static_cast<float>(pass.options.picture_history) : 0.0f,
                            .sharpness = 1.0f / pass.options.kernel,
                            .deviations = pass.options.deviations,
                            .has_history = pass.settings.has_history,
                            .frame_index = pass.settings.frame_index})
        .over(pass.now.picture.extent());
}

}  // namespace parhelion::passes
