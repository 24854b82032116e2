// The visibility buffer by raster against the traced one, and culling, which must change nothing but the time.
#include <algorithm>
#include <random>

#include "passes/gbuffer/gbuffer.h"
#include "passes/gbuffer/raster.h"
#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "session/scene_setup.h"
#include "shared/hit.h"
#include "shared/raster.h"
#include "support/render_fixture.h"

namespace parhelion::testing::raster_test {
namespace {

const SceneGpuOptions kRaster{.raster = true};

// Shared by the tests of this file.
Stage& built_in(const std::string& name) {
    shared_device();  // outlives the stages
    static std::map<std::string, std::unique_ptr<Stage>> stages;
    std::unique_ptr<Stage>& stage = stages[name];
    if (!stage) stage = std::make_unique<Stage>(make_builtin("builtin:" + name).scene, kRaster);
    return *stage;
}

CameraView first_camera(const Stage& stage, float aspect = 1.0f) { return view_of((*stage.scene.cameras().begin()).value, aspect); }

// A view of a stage that is rasterised and traced.
class Viewer {
public:
    Viewer(Stage& stage, const CameraView& camera, uint32_t width, uint32_t height, uint32_t seed = 0)
        : stage_(stage),
          aspect_(static_cast<float>(width) / static_cast<float>(height)),
          view_(stage.frame.device(), {.width = width, .height = height, .camera = shader_camera(camera, aspect_), .seed = seed, .filter = PixelFilter::Point}) {}

    void set_camera(const CameraView& camera) { view_.set_camera(shader_camera(camera, aspect_)); }
    gpu::Extent extent() const { return {view_.desc().width, view_.desc().height}; }

    // Identity words, four a pixel.
    std::vector<uint32_t> raster(passes::RasterHistory& history, const passes::RasterOptions& options = {}, uint32_t frame_index = 0) {
        stage_.scene_gpu.finish(stage_.frame);
        view_.prepare(stage_.frame);
        const gpu::Image identity = stage_.frame.image("test/identity", extent(), gpu::Format::Rgba32Uint);
        passes::raster_identity(stage_.frame, stage_.scene_gpu, view_.film(), identity, history, frame_index, options);
        const gpu::Buffer words = stage_.frame.read_back(identity), counts = history.counts ? stage_.frame.read_back(history.counts) : gpu::Buffer();
        stage_.frame.run();
        EXPECT_TRUE(stage_.frame.complaints().empty()) << stage_.frame.complaints().front();
        if (counts) counts_ = *counts.mapped_as<shared::RasterCounts>().data();
        const auto w = words.mapped_as<uint32_t>();
        return {w.begin(), w.end()};
    }
    std::vector<uint32_t> traced(uint32_t frame_index = 0) {
        stage_.scene_gpu.finish(stage_.frame);
        view_.prepare(stage_.frame);
        passes::GBuffer gbuffer{.identity = stage_.frame.image("test/identity", extent(), gpu::Format::Rgba32Uint)};
        passes::trace_identity(stage_.frame, stage_.scene_gpu, gpu::TraceWay::Compute, view_.film(), gbuffer, frame_index);
        const gpu::Buffer words = stage_.frame.read_back(gbuffer.identity);
        stage_.frame.run();
        const auto w = words.mapped_as<uint32_t>();
        return {w.begin(), w.end()};
    }
    // Of the last raster(): geometries drawn in its first and its second pass.
    uint32_t drawn(bool second) const { return counts_.drawn[second ? 3 : 0] + counts_.drawn[second ? 4 : 1] + counts_.drawn[second ? 5 : 2]; }
    const passes::Film& film() const { return view_.film(); }

private:
    Stage& stage_;
    float aspect_;
    View view_;
    shared::RasterCounts counts_{};
};

// Equal ids at a share of at least `least` of the pixels, and at the others a neighbour with another id: they lie at an outline.
void expect_same_ids(const std::vector<uint32_t>& raster, const std::vector<uint32_t>& traced, gpu::Extent extent, const std::string& what, double least = 0.995) {
    const size_t pixels = size_t(extent.width) * extent.height;
    const auto differ = [](const std::vector<uint32_t>& a, size_t p, const std::vector<uint32_t>& b, size_t q) { return !std::equal(a.begin() + 4 * p, a.begin() + 4 * p + 4, b.begin() + 4 * q); };
    size_t same = 0, inside = 0, seen = 0;
    for (size_t p = 0; p < pixels; ++p) {
        seen += traced[4 * p] != shared::kHitMiss;
        if (!differ(raster, p, traced, p)) {
            ++same;
            continue;
        }
        const int x = static_cast<int>(p % extent.width), y = static_cast<int>(p / extent.width);
        bool outline = false;
        for (int v = std::max(y - 1, 0); v <= std::min(y + 1, static_cast<int>(extent.height) - 1); ++v)
            for (int u = std::max(x - 1, 0); u <= std::min(x + 1, static_cast<int>(extent.width) - 1); ++u) outline |= differ(traced, static_cast<size_t>(v) * extent.width + static_cast<size_t>(u), traced, p);
        inside += !outline;
    }
    const double share = double(same) / double(pixels);
    ::testing::Test::RecordProperty(what, std::to_string(share));
    EXPECT_GE(share, least) << what;
    EXPECT_EQ(inside, 0u) << what << ": pixels that differ and touch no outline";
    EXPECT_GT(seen, pixels / 20) << what << " shows next to nothing";
}

glm::mat4 placed(glm::vec3 at, glm::vec3 scale = glm::vec3(1.0f)) {
    return glm::mat4(glm::vec4(scale.x, 0, 0, 0), glm::vec4(0, scale.y, 0, 0), glm::vec4(0, 0, scale.z, 0), glm::vec4(at, 1));
}

// A sheet of 2 x 2 metres that faces +Z, of many triangles; its alpha is noise.
Mesh sheet(SceneEdit& edit, AlphaMode mode, bool double_sided) {
    std::mt19937 random(5);
    Image noise{.name = "noise", .width = 64, .height = 64, .texels = std::vector<uint8_t>(64 * 64 * 4, 255)};
    for (size_t i = 3; i < noise.texels.size(); i += 4) noise.texels[i] = static_cast<uint8_t>(random() >> 24);
    Material material = builtin::lambert("sheet", glm::vec3(0.5f));
    material.double_sided = double_sided;
    material.alpha_mode = mode;
    material.base_color_texture.texture = edit.add(Texture{.image = edit.add(std::move(noise)), .sampler = {.mag = Filter::Nearest, .min = Filter::Nearest}});
    Mesh mesh{.name = "sheet"};
    add_textured_quad(mesh.primitives.emplace_back(), {-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, glm::vec2(1.0f), 8);
    mesh.primitives[0].material = edit.add(std::move(material));
    return mesh;
}

// Sheets of every kind in rows, as they are, mirrored and seen from behind; one that only other rays see; one whose mask has no holes.
Scene sheets() {
    SceneEdit edit;
    float y = -4.0f;
    for (const AlphaMode mode : {AlphaMode::Opaque, AlphaMode::Mask, AlphaMode::Blend})
        for (const bool double_sided : {false, true}) {
            const Handle<Mesh> mesh = edit.add(sheet(edit, mode, double_sided));
            edit.add(Instance{.mesh = mesh, .place = {.node_from_object = placed({-3, y, 0}, {0.7f, 0.7f, 1})}});
            edit.add(Instance{.mesh = mesh, .place = {.node_from_object = placed({-1.5f, y, 0}, {-0.7f, 0.7f, 1})}});
            edit.add(Instance{.mesh = mesh, .place = {.node_from_object = placed({0, y, 0}, {0.7f, 0.7f, -1})}});
            edit.add(Instance{.mesh = mesh, .place = {.node_from_object = placed({1.5f, y, 0}, {-0.7f, 0.7f, -1})}, .ray_mask = 0xFF});
            edit.add(Instance{.mesh = mesh, .place = {.node_from_object = placed({3, y, 0}, {0.7f, 0.7f, 1})}, .opacity = InstanceOpacity::Opaque});
            edit.add(Instance{.mesh = mesh, .place = {.node_from_object = placed({4.5f, y, 0}, {0.7f, 0.7f, 1})}, .ray_mask = 0});
            y += 1.6f;
        }
    // Behind all of them, so that holes show something.
    Primitive wall;
    add_quad(wall, {-6, -6, -2}, {12, 0, 0}, {0, 12, 0});
    builtin::add_object(edit, "wall", std::move(wall), edit.add(builtin::lambert("wall", glm::vec3(0.5f))));
    builtin::add_camera(edit, "front", {0.3f, 0.2f, 9.0f}, {0, 0, 0}, 1.1f);
    return make_scene(std::move(edit));
}

// Boxes in a grid of 6 x 6 x 6, and in front of them a wall with a gap.
struct Crowd {
    Scene scene;
    Handle<Node> wall;
};
Crowd crowd() {
    SceneEdit edit;
    Mesh box{.name = "box"};
    add_box(box.primitives.emplace_back(), glm::vec3(-0.3f), glm::vec3(0.3f));
    box.primitives[0].material = edit.add(builtin::lambert("box", glm::vec3(0.5f)));
    const Handle<Mesh> mesh = edit.add(std::move(box));
    for (uint32_t i = 0; i < 216; ++i) edit.add(Instance{.mesh = mesh, .place = {.node_from_object = placed({float(i % 6) - 2.5f, float(i / 6 % 6) - 2.5f, -float(i / 36)})}});
    Primitive wall;
    add_quad(wall, {-4, -4, 2}, {5, 0, 0}, {0, 8, 0});
    Crowd out;
    const Handle<Node> node = builtin::place_object(edit, "wall", std::move(wall), edit.add(builtin::lambert("wall", glm::vec3(0.5f))));
    builtin::add_camera(edit, "front", {0.1f, 0.2f, 8.0f}, {0, 0, 0}, 1.0f);
    out.wall = out.scene.apply(std::move(edit)).resolve(node);
    return out;
}

class RasterIdentity : public GpuTest {
protected:
    void SetUp() override {
        GpuTest::SetUp();
        if (!IsSkipped() && !device()->caps().raster) GTEST_SKIP() << "this device does not rasterise";
    }
    void compare(Stage& stage, const CameraView& camera, const std::string& what, uint32_t width = 160, uint32_t height = 120) {
        Viewer viewer(stage, camera, width, height);
        passes::RasterHistory history;
        expect_same_ids(viewer.raster(history, {}, 3), viewer.traced(3), viewer.extent(), what);
    }
};

}  // namespace

TEST_F(RasterIdentity, is_the_traced_one_but_for_outlines_in_the_built_in_scenes) {
    for (const char* name : {"cornell", "diorama", "reflections", "leak-box", "glass", "forest"}) {
        Stage& stage = built_in(name);
        compare(stage, first_camera(stage, 4.0f / 3.0f), name);
    }
}

TEST_F(RasterIdentity, is_the_traced_one_through_an_orthographic_camera) {
    for (const char* name : {"cornell", "diorama"}) {
        Stage& stage = built_in(name);
        CameraView camera = first_camera(stage, 4.0f / 3.0f);
        camera.orthographic = true;
        camera.half_extents = {1.2f, 0.9f};  // wider, coplanar faces in the diorama's outer wall would fight
        compare(stage, camera, std::string(name) + " orthographic");
    }
}

TEST_F(RasterIdentity, sees_masks_blending_sides_and_mirrored_instances_as_rays_do) {
    Stage culled(sheets(), kRaster), all(sheets(), {.culling = false, .raster = true});
    for (Stage* stage : {&culled, &all})
        for (const bool from_behind : {false, true}) {
            CameraView camera = first_camera(*stage, 4.0f / 3.0f);
            if (from_behind) camera = look_at({0.3f, 0.2f, -9.0f}, {0, 0, 0}, 1.1f);
            compare(*stage, camera, from_behind ? "from behind" : "from the front");
        }
}

TEST_F(RasterIdentity, is_there_when_the_camera_stands_within_a_surfaces_box_or_close_to_it) {
    Stage& stage = built_in("cornell");
    const CameraView first = first_camera(stage);
    CameraView close = look_at(first.position + 0.9f * first.forward, first.position + 5.0f * first.forward + first.up, 1.8f);
    compare(stage, close, "inside", 120, 120);
    // A tenth of a millimetre above a floor of four metres.
    SceneEdit edit;
    Primitive floor;
    add_quad(floor, {-2, 0, 2}, {4, 0, 0}, {0, 0, -4});
    builtin::add_object(edit, "floor", std::move(floor), edit.add(builtin::lambert("floor", glm::vec3(0.5f))));
    Stage flat(make_scene(std::move(edit)), kRaster);
    compare(flat, look_at({0.1f, 1e-4f, 0.2f}, {0.1f, -0.3f, -1.0f}, 1.2f), "on the floor", 120, 120);
}

TEST_F(RasterIdentity, draws_another_choice_of_blended_triangles_with_every_frame_and_seed) {
    Stage stage(sheets(), kRaster);
    const CameraView camera = first_camera(stage);
    Viewer viewer(stage, camera, 96, 96), other(stage, camera, 96, 96, 1);
    passes::RasterHistory history;
    const auto first = viewer.raster(history), again = viewer.raster(history), second = viewer.raster(history, {}, 1), seed = other.raster(history);
    EXPECT_EQ(first, again);
    EXPECT_NE(first, second);
    EXPECT_NE(first, seed);
    expect_same_ids(seed, other.traced(), other.extent(), "another seed");
}

TEST_F(RasterIdentity, is_the_same_with_and_without_occlusion_culling_whatever_moves) {
    Crowd scene = crowd();
    Stage stage(std::move(scene.scene), kRaster);
    Viewer viewer(stage, first_camera(stage), 128, 128);
    passes::RasterHistory history, none;
    uint32_t second = 0;
    const auto check = [&](const std::string& what) {
        const auto culled = viewer.raster(history);
        second += viewer.drawn(true);
        EXPECT_EQ(culled, viewer.raster(none, {.occlusion = false})) << what;
    };
    check("first");
    check("at rest");
    for (int i = 1; i <= 3; ++i) {  // the wall slides away, and what was behind it shows at once
        SceneEdit edit;
        edit.set_transform(scene.wall, Transform{.translation = {0.8f * static_cast<float>(i), 0, 0}});
        stage.step(std::move(edit));
        check("the wall at " + std::to_string(i));
    }
    EXPECT_GT(second, 0u);
    stage.step({});
    viewer.set_camera(look_at({6.0f, 2.0f, 6.0f}, {0, 0, -2}, 0.9f));
    check("a cut");
    viewer.set_camera(look_at({0.5f, 0.5f, -2.5f}, {0, 0, -9}, 0.9f));
    check("amid the boxes");
    CameraView parallel = look_at({4.0f, 3.0f, 6.0f}, {0, 0, -2}, 0.9f);
    parallel.orthographic = true;
    parallel.half_extents = {4.0f, 4.0f};
    viewer.set_camera(parallel);
    check("orthographic after perspective");
    check("orthographic");
}

TEST_F(RasterIdentity, draws_next_to_nothing_of_what_is_hidden) {
    Crowd scene = crowd();
    Stage stage(std::move(scene.scene), kRaster);
    Viewer viewer(stage, first_camera(stage), 128, 128);
    passes::RasterHistory history;
    viewer.raster(history);
    EXPECT_EQ(viewer.drawn(false), 217u);  // all of them: nothing is known yet
    EXPECT_EQ(viewer.drawn(true), 0u);
    viewer.raster(history);
    EXPECT_LT(viewer.drawn(false), 140u);
    EXPECT_GT(viewer.drawn(false), 36u);
    EXPECT_EQ(viewer.drawn(true), 0u);
    viewer.set_camera(look_at({0, 0, 8}, {0, 0, 20}, 1.0f));  // away from it
    viewer.raster(history);
    EXPECT_EQ(viewer.drawn(false) + viewer.drawn(true), 0u);
}

TEST_F(RasterIdentity, the_pyramid_holds_the_farthest_depth_of_every_square) {
    Stage& stage = built_in("diorama");
    for (const gpu::Extent extent : {gpu::Extent{150, 70}, gpu::Extent{65, 129}, gpu::Extent{7, 3}}) {
        Viewer viewer(stage, first_camera(stage, float(extent.width) / float(extent.height)), extent.width, extent.height);
        passes::RasterHistory history;
        viewer.raster(history);
        const gpu::Buffer depths = stage.frame.read_back(history.depth);
        stage.frame.run();
        const std::vector<float> pyramid = download<float>(history.pyramid);
        const auto depth = depths.mapped_as<float>();
        size_t offset = 1, levels = 0;
        for (uint32_t level = 1;; ++level) {
            const uint32_t side = 1u << level, width = (extent.width + side - 1) >> level, height = (extent.height + side - 1) >> level;
            for (uint32_t y = 0; y < height; ++y)
                for (uint32_t x = 0; x < width; ++x) {
                    float farthest = 1.0f;
                    for (uint32_t v = y * side; v < std::min((y + 1) * side, extent.height); ++v)
                        for (uint32_t u = x * side; u < std::min((x + 1) * side, extent.width); ++u) farthest = std::min(farthest, depth[v * extent.width + u]);
                    ASSERT_EQ(pyramid[offset + y * width + x], farthest) << "level " << level << " at " << x << "," << y;
                }
            offset += size_t(width) * height;
            ++levels;
            if (width == 1 && height == 1) break;
        }
        EXPECT_LE(offset * sizeof(float), passes::depth_pyramid_bytes(extent));
        EXPECT_GE(levels, 3u);
    }
}

TEST_F(RasterIdentity, an_empty_scene_shows_nothing) {
    Stage stage(make_scene({}), kRaster);
    Viewer viewer(stage, look_at({0, 0, 4}, {0, 0, 0}, 1.0f), 32, 32);
    passes::RasterHistory history;
    const std::vector<uint32_t> words = viewer.raster(history);
    for (size_t p = 0; p < words.size(); ++p) ASSERT_EQ(words[p], p % 4 == 0 ? shared::kHitMiss : 0u);
}

TEST_F(RasterIdentity, each_barrier_left_out_draws_a_complaint_and_full_barriers_change_nothing) {
    Crowd scene = crowd();
    const gpu::DevicePtr quiet = gpu::Device::open({});  // the layers would rightly speak up
    Stage stage(std::move(scene.scene), kRaster, {}, quiet);
    Viewer viewer(stage, first_camera(stage), 64, 64);
    passes::RasterHistory history;
    const auto expected = viewer.raster(history);
    const gpu::Image identity = stage.frame.image("test/identity", viewer.extent(), gpu::Format::Rgba32Uint);
    // Recording is enough, and nothing of it runs.
    const auto record = [&](const FrameOptions& options) {
        Frame frame(quiet, options);
        passes::RasterHistory own;
        passes::raster_identity(frame, stage.scene_gpu, viewer.film(), identity, own, 0);
        gpu::CommandList commands(quiet);
        frame.retire(frame.record(commands));
        return std::pair(frame.barrier_count(), frame.complaints().size());
    };
    const auto [barriers, complaints] = record({});
    EXPECT_EQ(complaints, 0u);
    EXPECT_GE(barriers, 7u);
    for (uint32_t skipped = 0; skipped < barriers; ++skipped) EXPECT_GT(record({.skip_barrier = static_cast<int>(skipped)}).second, 0u) << "barrier " << skipped << " of " << barriers;
    Stage full(std::move(crowd().scene), kRaster, {.full_barriers = true});
    Viewer same(full, first_camera(full), 64, 64);
    passes::RasterHistory other;
    EXPECT_EQ(same.raster(other), expected);
}

}  // namespace parhelion::testing::raster_test
