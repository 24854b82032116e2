// Everything that changes while the shutter is open is seen for the share of the time that it is there: jobs of the path tracers, in process.
#include <glm/gtc/matrix_transform.hpp>

#include "base/error.h"
#include "base/file.h"
#include "image/decode.h"
#include "image/film.h"
#include "scene/gltf/write.h"
#include "scene/shapes.h"
#include "session/job.h"
#include "session/merge.h"
#include "support/process.h"
#include "support/render_fixture.h"

namespace parhelion::testing::shutter_test {
namespace {

constexpr uint32_t kSide = 16, kSamples = 64;

class Shutter : public GpuTest {
protected:
    TemporaryFolder folder;

    // A camera looks at the square of 2 m about the origin from the front; whatever stands there glows with 1 nit.
    struct Maker {
        SceneEdit edit;
        Handle<Material> glow;
        Maker() {
            glow = edit.add(Material{.name = "glow", .base_color = glm::vec4(0, 0, 0, 1), .emission = glm::vec3(1.0f)});
            edit.add(Camera{.name = "front", .kind = CameraKind::Orthographic, .far_plane = 10.0f, .place = {.node_from_object = glm::translate(glm::mat4(1.0f), {0, 0, 5})}});
        }
        Primitive square(float half_width) const {
            Primitive quad{.material = glow};
            add_quad(quad, {-half_width, -2.0f, 0.0f}, {2.0f * half_width, 0.0f, 0.0f}, {0.0f, 4.0f, 0.0f});
            quad.material = glow;
            return quad;
        }
        Handle<Node> add(Primitive primitive, const char* name) {
            const Handle<Node> node = edit.add(Node{.name = name});
            Mesh mesh{.name = name};
            mesh.primitives.push_back(std::move(primitive));
            edit.add(Instance{.mesh = edit.add(std::move(mesh)), .place = {.node = node}});
            return node;
        }
        void animate(AnimationChannel channel) { edit.add(Animation{.name = "move", .channels = {std::move(channel)}}); }
    };
    std::string write(Maker&& maker) const {
        Scene scene;
        scene.apply(std::move(maker.edit));
        const std::filesystem::path file = folder.file("scene.glb");
        write_file(file, write_glb(scene));
        return file.string();
    }
    RenderOptions options(const std::string& scene) const {
        RenderOptions out;
        out.scene = scene;
        out.size = {kSide, kSide};
        out.samples = {0, kSamples};
        out.max_bounces = 1;
        out.exposure_ev = 0;
        out.shutter_seconds = 1;
        out.trace = TraceChoice::Compute;
        out.output.exr_float = true;
        out.output.files = {folder.file("a.exr")};
        return out;
    }
    image::ImageF draw(const RenderOptions& what) const {
        run_render_job(what, device());
        return image::read_linear(what.output.files.front());
    }
    static std::vector<float> row(const image::ImageF& picture) {
        const auto plane = picture.plane(1).subspan(size_t{kSide} * kSide / 2, kSide);
        return {plane.begin(), plane.end()};
    }
};

}  // namespace

TEST_F(Shutter, what_is_there_for_a_quarter_of_the_time_is_seen_as_a_quarter_in_both_path_tracers) {
    Maker maker;
    const Handle<Node> node = maker.add(maker.square(2.0f), "square");
    maker.animate({.node = node, .path = AnimatedPath::Visible, .interpolation = Interpolation::Step, .width = 1, .times = {0.0f, 0.5f, 0.75f}, .values = {0, 1, 0}});
    RenderOptions job = options(write(std::move(maker)));
    for (const RendererKind renderer : {RendererKind::Reference, RendererKind::Wavefront}) {
        job.renderer = renderer;
        // Of 64 moments 16 lie in every quarter: no noise.
        for (const float value : row(draw(job))) EXPECT_FLOAT_EQ(value, 0.25f);
    }
    job.shutter_seconds = 0;
    for (const float value : row(draw(job))) EXPECT_EQ(value, 0.0f);
}

TEST_F(Shutter, a_square_that_moves_and_one_that_deforms_blur_alike) {
    const auto coverage = [](uint32_t x) {  // the share of the time t that [t - 1, t] covers the pixel's middle, of the picture's [-1, 1]
        const double at = -1 + 2 * (x + 0.5) / kSide;
        return at < 0 ? 1 + at : 1 - at;
    };
    std::vector<image::ImageF> pictures;
    for (const bool deforms : {false, true}) {
        Maker maker;
        Primitive square = maker.square(0.5f);
        for (glm::vec3& p : square.positions) p.x -= 0.5f;
        if (deforms) square.targets.push_back({.positions = std::vector<glm::vec3>(square.positions.size(), glm::vec3(1, 0, 0))});
        const Handle<Node> node = maker.add(std::move(square), "square");
        if (deforms) maker.animate({.node = node, .path = AnimatedPath::Weights, .width = 1, .times = {0, 1}, .values = {0, 1}});
        else maker.animate({.node = node, .width = 3, .times = {0, 1}, .values = {0, 0, 0, 1, 0, 0}});
        pictures.push_back(draw(options(write(std::move(maker)))));
        const std::vector<float> values = row(pictures.back());
        for (uint32_t x = 0; x < kSide; ++x) EXPECT_NEAR(values[x], coverage(x), 0.05) << x << (deforms ? ", deforms" : "");
    }
    EXPECT_GT(share_equal(pictures[0], pictures[1]), 0.95);
}

TEST_F(Shutter, a_lamp_that_swells_lights_by_its_mean_and_parts_add_up_bit_for_bit) {
    Maker maker;
    Primitive wall = maker.square(2.0f);
    wall.material = maker.edit.add(Material{.name = "white", .metallic = 0.0f, .specular = 0.0f});
    maker.add(std::move(wall), "wall");
    const Handle<Light> light = maker.edit.add(Light{.name = "sun", .kind = LightKind::Directional, .intensity = 0.0f});
    maker.animate({.path = AnimatedPath::Intensity, .width = 1, .times = {0, 1}, .values = {0, 2}, .light = light});
    RenderOptions job = options(write(std::move(maker)));
    for (const float value : row(draw(job))) EXPECT_NEAR(value, 1 / 3.14159265, 0.002);

    const auto sums_of = [&](IndexRange samples, const char* name) {
        RenderOptions part = job;
        part.samples = samples;
        part.is_part = true;
        part.output.files = {folder.file(name)};
        run_render_job(part, device());
        return image::read_film_exr(part.output.files.front());
    };
    job.samples = {0, 128};
    const image::FilmSums whole = sums_of({0, 128}, "whole.exr");
    sums_of({0, 64}, "first.exr"), sums_of({64, 128}, "second.exr");
    EXPECT_EQ(differing_words(whole, merge_parts(std::vector<std::filesystem::path>{folder.file("first.exr"), folder.file("second.exr")})), 0u);
}

TEST_F(Shutter, a_frame_of_a_sequence_is_what_it_is_alone) {
    RenderOptions job = options("builtin:diorama");
    job.load.animate = "ball";
    job.samples = {0, 4};
    job.shutter_seconds = 0.1;
    job.output.files = {folder.file("a.####.exr")};
    job.play = FramePlay{.frames = {0, 3}, .fps = 5};
    run_render_job(job, device());
    job.play->frames = {2, 3};
    job.output.files = {folder.file("b.####.exr")};
    run_render_job(job, device());
    EXPECT_EQ(read_bytes(folder.file("a.0002.exr")), read_bytes(folder.file("b.0002.exr")));
    job.shutter_seconds = 0;
    job.output.files = {folder.file("c.####.exr")};
    run_render_job(job, device());
    EXPECT_NE(image::read_linear(folder.file("b.0002.exr")).data, image::read_linear(folder.file("c.0002.exr")).data);
}

TEST_F(Shutter, motion_is_refused_where_more_than_the_camera_moves) {
    RenderOptions job = options("builtin:diorama");
    job.load.animate = "ball";
    job.aovs = {"motion"};
    EXPECT_THROW(run_render_job(job, device()), Error);
}

}  // namespace parhelion::testing::shutter_test
