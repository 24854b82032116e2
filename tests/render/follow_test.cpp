// What stands in the place of exact mirrors and panes, held against plane geometry.
#include <cmath>

#include "renderers/slice.h"
#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "session/scene_setup.h"
#include "support/render_fixture.h"

namespace parhelion::testing::follow_test {
namespace {

constexpr uint32_t kSize = 33;  // the middle pixel looks along the axis
constexpr float kYfov = 0.7f;

// What the pixels of a frame are taken for.
struct Guides {
    std::vector<glm::uvec4> summary;
    std::vector<glm::vec2> motion;
    std::vector<float> depth;

    static size_t at(uint32_t x, uint32_t y) { return size_t{y} * kSize + x; }
    float metres(size_t p) const { return shared::kDepthNear / depth[p]; }
    glm::vec3 color(size_t p) const { return glm::pow(glm::vec3(glm::unpackUnorm4x8(summary[p].x)), glm::vec3(2.2f)); }
    uint32_t id(size_t p) const { return summary[p].z >> shared::kSummaryIdShift; }
};

class Follow : public GpuTest {
protected:
    // The scene, with what is added to it; names of its own for the nodes.
    void stand(SceneEdit edit, std::initializer_list<Handle<Node>*> nodes = {}) {
        Scene scene;
        const ChangeSet changes = scene.apply(std::move(edit));
        for (Handle<Node>* node : nodes) *node = changes.resolve(*node);
        stage_.emplace(std::move(scene));
    }
    // A frame after the edit, seen from here.
    Guides look(const CameraView& camera, SceneEdit edit = {}, bool follow = true) {
        Stage& stage = *stage_;
        Frame& frame = stage.frame;
        if (!view_) {
            view_.emplace(stage.make_view({.view = {.width = kSize, .height = kSize, .filter = PixelFilter::Point}, .camera = camera}));
            gbuffer_.emplace(passes::make_gbuffer(frame.device(), {kSize, kSize}));
        }
        stage.step(std::move(edit));
        stage.scene_gpu.finish(frame);
        view_->set_camera(shader_camera(camera, 1.0f));
        view_->prepare(frame);
        passes::trace_identity(frame, stage.scene_gpu, gpu::TraceWay::Compute, view_->film(), *gbuffer_, 0);
        passes::summarise_surfaces(frame, stage.scene_gpu, view_->film(), *gbuffer_, 0, 1.0f);
        if (follow) passes::follow_mirrors(frame, stage.scene_gpu, gpu::TraceWay::Compute, view_->film(), *gbuffer_, 0, 1.0f);
        const gpu::Buffer summary = frame.read_back(gbuffer_->summary), motion = frame.read_back(gbuffer_->motion), depth = frame.read_back(gbuffer_->depth);
        frame.run();
        view_->end_frame();
        const auto copy = [](auto span) { return std::vector(span.begin(), span.end()); };
        return {copy(summary.mapped_as<glm::uvec4>()), copy(motion.mapped_as<glm::vec2>()), copy(depth.mapped_as<float>())};
    }

private:
    std::optional<Stage> stage_;
    std::optional<View> view_;
    std::optional<passes::GBuffer> gbuffer_;
};

CameraView camera_at(glm::vec3 from) { return look_at(from, from - glm::vec3(0.0f, 0.0f, 1.0f), kYfov); }
// Of what moves by so much across the view at a distance.
float pixels(float metres, float distance) { return metres * 0.5f * kSize / (distance * std::tan(0.5f * kYfov)); }

const glm::vec3 kSilver(0.9f, 0.8f, 0.7f), kOchre(0.6f, 0.4f, 0.2f);
Handle<Node> add_board(SceneEdit& edit, Handle<Material> material, glm::vec3 middle, bool towards_z, float half = 5.0f) {
    Primitive board;
    if (towards_z) add_quad(board, {-half, -half, 0}, {2 * half, 0, 0}, {0, 2 * half, 0});
    else add_quad(board, {half, -half, 0}, {-2 * half, 0, 0}, {0, 2 * half, 0});
    return builtin::place_object(edit, "board", std::move(board), material, {.translation = middle});
}

// The camera two metres before a mirror, a board two metres behind the camera: its image lies six metres off.
TEST_F(Follow, a_flat_mirror_shows_what_is_behind_the_camera_as_far_off_as_its_image) {
    SceneEdit edit;
    add_board(edit, edit.add(builtin::glossy("silver", kSilver, 1.0f, 0.0f)), {0, 0, 0}, true);
    Handle<Node> board = add_board(edit, edit.add(builtin::glossy("ochre", kOchre, 0.0f, 0.5f)), {0, 0, 4}, false);
    stand(std::move(edit), {&board});
    const CameraView camera = camera_at({0, 0, 2});
    const size_t middle = Guides::at(kSize / 2, kSize / 2), side = Guides::at(kSize / 2 + 6, kSize / 2 - 4);
    const Guides glass = look(camera, {}, false), still = look(camera);
    EXPECT_NEAR(glass.metres(side), 2.0f, 1e-4f);
    EXPECT_NE(glass.id(side), still.id(side));
    for (const size_t p : {middle, side}) {
        EXPECT_NEAR(still.metres(p), 6.0f, 1e-3f);
        EXPECT_LT(glm::length(still.color(p) - kSilver * kOchre), 0.01f);
        EXPECT_LT(glm::length(still.motion[p]), 1e-3f);
    }
    SceneEdit moves;
    moves.set_transform(board, Transform{.translation = {0.3f, 0.2f, 4.0f}});
    const Guides moved = look(camera, std::move(moves));
    EXPECT_NEAR(moved.motion[side].x, -pixels(0.3f, 6.0f), 0.01f);
    EXPECT_NEAR(moved.motion[side].y, pixels(0.2f, 6.0f), 0.01f);
}

// It moves towards the camera by a metre: the image comes by two.
TEST_F(Follow, a_mirror_that_moves_takes_its_image_along_twice_as_fast) {
    SceneEdit edit;
    Handle<Node> mirror = add_board(edit, edit.add(builtin::glossy("silver", kSilver, 1.0f, 0.0f)), {0, 0, 0}, true);
    add_board(edit, edit.add(builtin::glossy("ochre", kOchre, 0.0f, 0.5f)), {0, 0, 5}, false);
    stand(std::move(edit), {&mirror});
    const CameraView camera = camera_at({0, 0, 3});
    const uint32_t off = 8;
    const size_t side = Guides::at(kSize / 2 + off, kSize / 2);
    EXPECT_NEAR(look(camera).metres(side), 8.0f, 1e-3f);
    SceneEdit moves;
    moves.set_transform(mirror, Transform{.translation = {0.0f, 0.0f, 1.0f}});
    const Guides moved = look(camera, std::move(moves));
    EXPECT_NEAR(moved.metres(side), 6.0f, 1e-3f);
    EXPECT_NEAR(moved.motion[side].x, off * (6.0f / 8.0f - 1.0f), 0.01f);  // it was nearer to the axis
}

// A ball of a metre's radius, three metres off: the image of what is infinitely far lies half a radius behind its surface.
TEST_F(Follow, a_bent_mirror_has_the_image_of_the_sky_half_a_radius_behind_it) {
    SceneEdit edit;
    builtin::place_object(edit, "ball", make_sphere(1.0f, 96, true), edit.add(builtin::glossy("silver", kSilver, 1.0f, 0.0f)));
    stand(std::move(edit));
    const size_t middle = Guides::at(kSize / 2, kSize / 2);
    look(camera_at({0, 0, 4}));
    const Guides moved = look(camera_at({0.1f, 0, 4}));
    EXPECT_EQ(moved.id(middle), 0u);
    EXPECT_NEAR(moved.motion[middle].x, pixels(0.1f, 3.5f), 0.02f * pixels(0.1f, 3.5f));
}

TEST_F(Follow, a_pane_shows_what_is_behind_it_where_it_is) {
    SceneEdit edit;
    Material glass = builtin::glossy("glass", glm::vec3(0.5f, 1.0f, 1.0f), 0.0f, 0.0f);
    glass.transmission = 1.0f;
    add_board(edit, edit.add(std::move(glass)), {0, 0, 0}, true);
    add_board(edit, edit.add(builtin::glossy("ochre", kOchre, 0.0f, 0.5f)), {0, 0, -3}, true);
    stand(std::move(edit));
    const Guides seen = look(camera_at({0, 0, 2}));
    const size_t side = Guides::at(kSize / 2 + 6, kSize / 2 - 4);
    EXPECT_NEAR(seen.metres(side), 5.0f, 1e-3f);
    const glm::vec3 share = seen.color(side) / kOchre;
    EXPECT_NEAR(share.r / share.g, 0.5f, 0.02f);
    EXPECT_NEAR(share.g, 0.96f, 0.01f);  // by an index of 1.5 four per cent are reflected
}

// What a pane reflects belongs to it where nothing is behind.
TEST_F(Follow, a_pane_before_the_sky_stays_what_it_is) {
    SceneEdit edit;
    Material glass = builtin::glossy("glass", glm::vec3(1.0f), 0.0f, 0.0f);
    glass.transmission = 1.0f;
    add_board(edit, edit.add(std::move(glass)), {0, 0, 0}, true);
    stand(std::move(edit));
    const size_t middle = Guides::at(kSize / 2, kSize / 2);
    EXPECT_NEAR(look(camera_at({0, 0, 2})).metres(middle), 2.0f, 1e-4f);
}

}  // namespace
}  // namespace parhelion::testing::follow_test
