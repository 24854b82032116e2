#include "support/render_fixture.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "session/film_state.h"
#include "session/scene_setup.h"
#include "support/pack_writer.h"

namespace parhelion::testing {

Stage::Stage(Scene first_scene, const SceneGpuOptions& options, const FrameOptions& frame_options, const gpu::DevicePtr& device)
    : scene(std::move(first_scene)), frame(device, frame_options, joint_shader_pack()), scene_gpu(device, options) {
    scene_gpu.sync(scene);
}

View Stage::make_view(const Shot& shot) const {
    ViewDesc desc = shot.view;
    const float aspect = static_cast<float>(desc.width) / static_cast<float>(desc.height);
    const CameraView camera = shot.camera ? *shot.camera : view_of((*scene.cameras().begin()).value, aspect);
    desc.camera = shader_camera(camera, aspect);
    if (shot.camera_at_close) desc.camera_at_close = shader_camera(*shot.camera_at_close, aspect);
    return {frame.device(), desc};
}

// A slice by the wavefront, in frames of equal length.
void Stage::draw(Wavefront& machine, const Shot& shot, View& view, const shared::Slice& slice) {
    machine.start(slice);
    do {
        machine.record(frame, scene_gpu, shot.way, view);
        frame.run();
    } while (!machine.advance(1.0, 1.0));
    machine.finish(frame, view);
}

image::FilmSums Stage::render(const Shot& shot) {
    View view = make_view(shot);
    std::optional<Wavefront> machine;
    if (shot.wavefront) machine.emplace(frame.device(), *shot.wavefront).rounds_per_frame = shot.rounds;
    scene_gpu.finish(frame);
    const uint32_t end = shot.first_sample + shot.sample_count, height = shot.view.height;
    for (uint32_t sample = shot.first_sample; sample < end;) {
        const uint32_t block_end = (sample / shared::kSamplesPerBlock + 1) * shared::kSamplesPerBlock;
        const uint32_t count = std::min({shot.slice_samples, end - sample, block_end - sample});
        for (uint32_t row = 0; row < height; row += std::min(shot.slice_rows, height - row)) {
            const shared::Slice slice{row, std::min(shot.slice_rows, height - row), sample, count};
            const bool ends_range = sample + count == end;
            if (machine) {
                draw(*machine, shot, view, slice);
                end_slice(frame, view, slice, ends_range);
            } else {
                record_reference(frame, scene_gpu, shot.way, view, slice, ends_range);
            }
            frame.run();
        }
        sample += count;
    }
    rays = view.read_rays(frame);
    wavefront = machine ? machine->stats() : WavefrontStats{};
    return make_film_sums(view.read_film(frame), {shot.view.width, shot.view.height}, {shot.first_sample, end}, {});
}

image::FilmSums Stage::play(const Shot& shot, const RealtimeOptions& options) {
    View view = make_view(shot);
    scene_gpu.finish(frame);
    step({});  // the scene stood there before, so that what it shows has a past
    scene_gpu.finish(frame);
    Realtime realtime(frame.device(), view, options);
    realtime.set_frame_index(shot.first_sample);
    for (uint32_t i = 0; i < shot.sample_count; ++i) {
        realtime.record(frame, scene_gpu, shot.way, view, i + 1 == shot.sample_count);
        frame.run();
    }
    rays = view.read_rays(frame);
    return make_film_sums(view.read_film(frame), {shot.view.width, shot.view.height}, {shot.first_sample, shot.first_sample + shot.sample_count}, {});
}

void Stage::record(const Shot& shot) {
    View view = make_view(shot);
    listings_before.clear();
    while (!scene_gpu.update(frame).complete) {
        frame.run();
        listings_before += frame.listing() + "\n";
    }
    const shared::Slice slice{0, shot.view.height, shot.first_sample, shot.sample_count};
    std::optional<Wavefront> machine;
    if (shot.wavefront) {
        machine.emplace(frame.device(), *shot.wavefront).rounds_per_frame = shot.rounds;
        machine->start(slice);
        machine->record(frame, scene_gpu, shot.way, view);
    } else {
        record_reference(frame, scene_gpu, shot.way, view, slice, true);
    }
    gpu::CommandList commands(frame.device());
    frame.retire(frame.record(commands));
}

ChangeSet Stage::step(SceneEdit edit) {
    ChangeSet changes = scene.begin_frame();
    const ChangeSet edited = scene.apply(std::move(edit));
    changes.append(edited);
    scene_gpu.sync(scene, changes);
    return edited;
}

Stage& builtin_stage(const std::string& name, const BuiltinOptions& options) {
    shared_device();  // outlives the stages
    static std::map<std::string, std::unique_ptr<Stage>> stages;
    const auto text = [](glm::vec3 v) { return fmt::format("{} {} {}", v.x, v.y, v.z); };
    std::unique_ptr<Stage>& stage = stages[fmt::format("{} {} {} {} {} {}", name, text(options.albedo), text(options.emission), options.roughness, options.metallic, options.triangles)];
    if (!stage) stage = std::make_unique<Stage>(make_builtin(name, options).scene);
    return *stage;
}

const image::FilmSums& builtin_film(const std::string& name, const Shot& shot, const BuiltinOptions& options) {
    static std::map<std::string, image::FilmSums> films;
    Stage& stage = builtin_stage(name, options);
    const ViewDesc& v = shot.view;
    std::string key = fmt::format("{} {} {} {} {} {} {} {} {} {} {} {} {} {} {}", static_cast<const void*>(&stage), int(shot.way), v.width, v.height, v.seed, v.max_bounces, int(v.sampler),
                                  int(v.filter), v.roulette_start, v.light_sampling, shot.first_sample, shot.sample_count, shot.slice_rows, shot.slice_samples, v.aovs.size());
    key += fmt::format(" {} {} {} {} {} {}", int(v.texture_lod), int(v.shade_in), v.energy_compensation, v.normal_correction, int(v.spawn_offset), v.firefly_clamp);
    for (const std::string& aov : v.aovs) key += ' ' + aov;
    if (shot.camera || shot.camera_at_close || shot.wavefront) return films[key + " drawn anew"] = stage.render(shot);
    const auto found = films.find(key);
    return found != films.end() ? found->second : films[key] = stage.render(shot);
}

image::ImageF builtin_picture(const std::string& name, const Shot& shot, const BuiltinOptions& options) {
    return image::resolve_film(builtin_film(name, shot, options));
}

const gpu::ShaderPack& joint_shader_pack() {
    static const gpu::ShaderPack pack = [] {
        std::vector<gpu::ShaderCode> shaders(gpu::ShaderPack::builtin().all().begin(), gpu::ShaderPack::builtin().all().end());
        shaders.insert(shaders.end(), test_shader_pack().all().begin(), test_shader_pack().all().end());
        return gpu::ShaderPack(PackWriter().write(shaders));
    }();
    return pack;
}

Scene make_scene(SceneEdit edit) {
    Scene scene;
    scene.apply(std::move(edit));
    return scene;
}

void add_veiled_ground(SceneEdit& edit, float half_extent, float height, float alpha) {
    Primitive ground, sheet;
    for (const auto& [quad, y] : {std::pair(&ground, 0.0f), std::pair(&sheet, height)})
        add_quad(*quad, {-half_extent, y, half_extent}, {2.0f * half_extent, 0.0f, 0.0f}, {0.0f, 0.0f, -2.0f * half_extent});
    Material veil = builtin::lambert("veil", glm::vec3(0.0f));
    veil.double_sided = true;
    veil.alpha_mode = AlphaMode::Blend;
    veil.base_color.a = alpha;
    builtin::add_object(edit, "ground", std::move(ground), edit.add(builtin::lambert("ground", glm::vec3(1.0f))));
    builtin::add_object(edit, "veil", std::move(sheet), edit.add(std::move(veil)));
}

CameraView camera_from_above(float height, float half_extent) {
    return {.position = {0.0f, height, 0.0f},
            .right = {1.0f, 0.0f, 0.0f},
            .up = {0.0f, 0.0f, -1.0f},
            .forward = {0.0f, -1.0f, 0.0f},
            .orthographic = true,
            .half_extents = glm::vec2(half_extent)};
}

glm::vec2 ground_point(uint32_t x, uint32_t y, uint32_t size, float half_extent) {
    return (2.0f * (glm::vec2(x, y) + 0.5f) / static_cast<float>(size) - 1.0f) * half_extent;
}

void expect_sane(const image::ImageF& picture, bool is_signed) {
    size_t bad = 0;
    for (const float v : picture.data) bad += !std::isfinite(v) || (!is_signed && v < 0);
    EXPECT_EQ(bad, 0u) << "values that are not finite or negative";
}

double mean_rgb(const image::ImageF& picture) {
    double sum = 0;
    for (size_t c = 0; c < 3; ++c)
        for (const float v : picture.plane(c)) sum += v;
    return sum / (3.0 * static_cast<double>(picture.pixel_count()));
}

double share_equal(const image::ImageF& a, const image::ImageF& b) {
    const double mean = mean_rgb(b);
    size_t equal = 0;
    for (size_t p = 0; p < a.pixel_count(); ++p) {
        bool all = true;
        for (size_t c = 0; c < 3; ++c) {
            const double x = a.plane(c)[p], y = b.plane(c)[p];
            all &= std::abs(x - y) <= 1e-4 * std::max(x, y) + 1e-4 * mean;
        }
        equal += all;
    }
    return static_cast<double>(equal) / static_cast<double>(a.pixel_count());
}

size_t differing_words(const image::FilmSums& a, const image::FilmSums& b) {
    const auto differing = [](const std::vector<uint32_t>& x, const std::vector<uint32_t>& y) {
        EXPECT_EQ(x.size(), y.size());
        size_t count = 0;
        for (size_t i = 0; i < std::min(x.size(), y.size()); ++i) count += x[i] != y[i];
        return count;
    };
    EXPECT_EQ(a.exact.size(), b.exact.size());
    size_t count = differing(a.limbs, b.limbs);
    for (size_t i = 0; i < std::min(a.exact.size(), b.exact.size()); ++i) count += differing(a.exact[i].words, b.exact[i].words);
    return count;
}

double share_bit_equal(const image::ImageF& a, const image::ImageF& b) {
    size_t equal = 0;
    for (size_t p = 0; p < a.pixel_count(); ++p) {
        bool all = true;
        for (size_t c = 0; c < a.channels.size(); ++c) all &= std::bit_cast<uint32_t>(a.plane(c)[p]) == std::bit_cast<uint32_t>(b.plane(c)[p]);
        equal += all;
    }
    return static_cast<double>(equal) / static_cast<double>(a.pixel_count());
}

void expect_mean(const std::vector<double>& values, double expected, double margin, const std::string& what) {
    const double n = static_cast<double>(values.size());
    double sum = 0, squares = 0;
    for (const double v : values) sum += v;
    const double mean = sum / n;
    for (const double v : values) squares += (v - mean) * (v - mean);
    const double error = std::sqrt(squares / (n - 1) / n);
    EXPECT_LE(4 * error, margin * std::abs(expected)) << what << ": too noisy for this margin";
    EXPECT_LE(std::abs(mean - expected), 4 * error + 1e-5 * std::abs(expected)) << what << ": mean " << mean << ", expected " << expected << ", standard error " << error;
}

}  // namespace parhelion::testing
