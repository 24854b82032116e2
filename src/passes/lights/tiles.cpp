#include "passes/lights/lights.h"
#include "shared/scene.h"

namespace parhelion::passes {

namespace {

constexpr uint32_t kSamples = shared::kTileCount * shared::kTileSamples;
struct TilesPush {
    uint64_t tiles;
    uint32_t frame_index, seed, width, height;
};

}  // namespace

gpu::Buffer make_light_tiles(const gpu::DevicePtr& device) { return {device, "lights/tiles", kSamples * sizeof(shared::TileSample)}; }

void draw_light_tiles(Frame& frame, const SceneGpu& scene, const gpu::Buffer& tiles, uint32_t frame_index, uint32_t seed, glm::uvec2 size) {
    frame.compute("lights/tiles", (scene.features() & shared::kSceneLayers) != 0 ? "+LAYERS" : "")
        .scene(scene.binding())
        .write("tiles", tiles)
        .push(TilesPush{.frame_index = frame_index, .seed = seed, .width = size.x, .height = size.y})
        .over(kSamples);
}

}  // namespace parhelion::passes
