#pragma once
// Renders in process, without files: a scene on the device (Stage) and pictures of it (Shot). Stages of built-in scenes and their
// films are shared by all tests of a process.
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "image/film.h"
#include "renderers/realtime.h"
#include "renderers/reference.h"
#include "renderers/wavefront.h"
#include "scene/builtin.h"
#include "scene/camera.h"
#include "support/gpu_fixture.h"

namespace parhelion::testing {

constexpr gpu::TraceWay kWays[] = {gpu::TraceWay::Query, gpu::TraceWay::Pipeline, gpu::TraceWay::Compute};

struct Shot {
    gpu::TraceWay way = gpu::TraceWay::Compute;
    ViewDesc view{.width = 32, .height = 32};      // its camera is filled in from `camera`
    std::optional<CameraView> camera = {};          // none: the scene's first
    std::optional<CameraView> camera_at_close = {}; // where it stands when its shutter closes; none: it is still
    uint32_t first_sample = 0, sample_count = 64;
    uint32_t slice_rows = 1u << 20, slice_samples = 64;
    std::optional<WavefrontOptions> wavefront = {};  // what draws; none: the reference
    uint32_t rounds = 8;                             // of the wavefront, recorded in a frame
};

// A scene with its device side in all three ways, and the Frame that draws it.
class Stage {
public:
    explicit Stage(Scene first_scene, const SceneGpuOptions& options = {}, const FrameOptions& frame_options = {}, const gpu::DevicePtr& device = shared_device());

    // Draws the shot in slices and reads its exact sums.
    image::FilmSums render(const Shot& shot);
    image::ImageF picture(const Shot& shot) { return image::resolve_film(render(shot)); }
    // Draws the shot's samples as frames of the realtime renderer, numbered from first_sample: their sums.
    image::FilmSums play(const Shot& shot, const RealtimeOptions& options);
    // Records the shot's first slice with everything before it (scene, film), of a wavefront its first frame, unsubmitted; slices of the
    // scene that must be done before are submitted.
    void record(const Shot& shot);

    // The shot's picture, empty.
    View make_view(const Shot& shot) const;

    // A new frame with this edit, told to the device side in one go, as a viewer does.
    ChangeSet step(SceneEdit edit);

    // The listings of the frames that the last record() submitted.
    std::string listings_before;
    // Of the last render().
    RayCounts rays;
    WavefrontStats wavefront;

    Scene scene;
    Frame frame;
    SceneGpu scene_gpu;

private:
    void draw(Wavefront& machine, const Shot& shot, View& view, const shared::Slice& slice);
};

// Of the whole process.
Stage& builtin_stage(const std::string& name, const BuiltinOptions& options = {});
// The film of a shot of a built-in scene; drawn once.
const image::FilmSums& builtin_film(const std::string& name, const Shot& shot, const BuiltinOptions& options = {});
image::ImageF builtin_picture(const std::string& name, const Shot& shot, const BuiltinOptions& options = {});

// The program's shaders and those of tests/device/shaders in one pack.
const gpu::ShaderPack& joint_shader_pack();

// A scene made by one edit.
Scene make_scene(SceneEdit edit);
// White Lambert ground at y = 0 and, at `height`, a black sheet of this alpha that is blended; squares of the half extent.
void add_veiled_ground(SceneEdit& edit, float half_extent, float height, float alpha);
// Looks straight down on the plane y = 0 from `height`, image rows along +Z: pixel centres are at ground_point().
CameraView camera_from_above(float height, float half_extent);
glm::vec2 ground_point(uint32_t x, uint32_t y, uint32_t size, float half_extent);  // (x, z)

// All pixels of channels [first, first + count) are finite, and not negative unless `is_signed`.
void expect_sane(const image::ImageF& picture, bool is_signed = false);
// Mean of R, G and B over the picture.
double mean_rgb(const image::ImageF& picture);
// Share of pixels whose R, G and B all satisfy |a - b| <= 1e-4 max(a, b) + 1e-4 mean.
double share_equal(const image::ImageF& a, const image::ImageF& b);
// Words of the sums and first hits of two films of one size that are not the same bits.
size_t differing_words(const image::FilmSums& a, const image::FilmSums& b);
// Share of pixels with equal bits in every channel.
double share_bit_equal(const image::ImageF& a, const image::ImageF& b);

// Independent values whose expectation should be `expected`: their mean must lie within `margin` (relative) of it, with four
// standard errors to spare, so that noise fails rather than passes. A true zero bias fails by chance with p < 1e-4.
void expect_mean(const std::vector<double>& values, double expected, double margin, const std::string& what);

}  // namespace parhelion::testing
