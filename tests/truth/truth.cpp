#include "truth/truth.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <ostream>

#include "base/error.h"
#include "gpu/device_class.h"
#include "image/tonemap.h"
#include "scene/load.h"
#include "session/film_state.h"
#include "session/metering.h"
#include "session/scene_setup.h"

namespace parhelion::testing {

namespace {

constexpr size_t kMostInFlight = 4;  // frames

constexpr TruthScene kScenes[] = {
    {.name = "cornell", .source = "builtin:cornell", .small = true},
    {.name = "leak_box", .source = "builtin:leak-box"},
    {.name = "spheres", .source = "builtin:spheres", .small = true, .caustics = true},
    {.name = "diorama", .source = "builtin:diorama", .caustics = true, .noisy = true},
    {.name = "many_lights", .source = "builtin:many-lights", .caustics = true, .noisy = true},
    {.name = "reflections", .source = "builtin:reflections", .caustics = true},
    {.name = "glass", .source = "builtin:glass", .caustics = true},
    {.name = "flight_helmet", .source = "flight_helmet/FlightHelmet.gltf", .caustics = true},
    {.name = "amg_gt", .source = "amg_gt/amg.optimized.glb", .caustics = true},
    {.name = "sponza_1000_lights", .source = "asm_sponza_1000_emitters/sponza_lights.glb", .from = {-9.5f, 2.0f, -0.4f}, .at = {6.0f, 3.0f, -0.4f}, .fov_degrees = 60.0f},
};

std::string assets() {
    const char* folder = std::getenv("PARHELION_ASSETS");
    return folder ? folder : "";
}

bool is_file(const TruthScene& scene) { return !is_builtin(scene.source); }

// As much light from a larger disc; lights without an extent stay.
void widen_suns(Scene& scene, float least_radius) {
    SceneEdit edit;
    for (const auto& [handle, light] : scene.lights()) {
        if (light.kind != LightKind::Directional || light.angular_radius == 0.0f) continue;
        Light wide = light;
        wide.angular_radius = std::max(light.angular_radius, least_radius);
        edit.set_light(handle, wide);
    }
    scene.apply(std::move(edit));
}

void write_line(const std::string& line) {
    const char* file = std::getenv("PARHELION_TRUTH_TABLE");
    if (!file) return;
    const bool fresh = !std::filesystem::exists(file);
    std::ofstream out(file, std::ios::app);
    if (fresh) out << "test\tscene\twhat\tvalue\tlow\thigh\tleast\tmost\truns\tframes\tverdict\tnote\n";
    out << line << '\n';
    EXPECT_TRUE(out.good()) << file << " cannot be written";
}

constexpr const char* kLine = "{:<10} {:<20} {:<26} {:>10} [{:>10}, {:>10}] in [{:>8}, {:>8}] {:>4} x {:<4} {:<5} {}\n";

void print(const std::string& line) {
    static const bool headed = [] {
        std::fputs(fmt::format(kLine, "test", "scene", "what", "value", "low", "high", "least", "most", "runs", "frames", "", "").c_str(), stdout);
        return true;
    }();
    static_cast<void>(headed);
    std::fputs(line.c_str(), stdout);
    std::fflush(stdout);
}

}  // namespace

bool small_truth() {
    static const bool small = [] {
        const char* asked = std::getenv("PARHELION_TRUTH_SMALL");
        return asked ? std::string_view(asked) == "1" : shared_device() && shared_device()->caps().type == gpu::DeviceType::Cpu;
    }();
    return small;
}

uint32_t truth_effort() {
    const char* asked = std::getenv("PARHELION_TRUTH_EFFORT");
    return asked ? static_cast<uint32_t>(std::clamp(std::atoi(asked), 1, 64)) : 1;
}

std::string_view truth_reuse() {
    const char* asked = std::getenv("PARHELION_TRUTH_REUSE");
    const std::string_view reuse = asked ? asked : "none";
    if (reuse != "none" && reuse != "full" && reuse != "history") throw Error(ErrorCode::Usage, "is none of none, full, history", fmt::format("PARHELION_TRUTH_REUSE={}", reuse));
    return reuse;
}

void report(const TruthRow& row) {
    const bool inside = row.low >= row.least && row.high <= row.most;  // false for NaN
    const bool passed = inside && row.also, noise = row.also && !inside && row.value >= row.least && row.value <= row.most;
    const char* verdict = passed ? "pass" : noise ? "NOISE" : "FAIL";
    const std::string test = truth_reuse() == "none" ? row.test : fmt::format("{} ({})", row.test, truth_reuse());
    const auto number = [](double v) { return std::abs(v) > 1e-3 || v == 0 ? fmt::format("{:.5f}", v) : fmt::format("{:.3g}", v); };
    print(fmt::format(kLine, test, row.scene, row.what, number(row.value), number(row.low), number(row.high), number(row.least), number(row.most), row.runs, row.frames, verdict,
                      row.note));
    write_line(fmt::format("{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}", test, row.scene, row.what, number(row.value), number(row.low), number(row.high), number(row.least),
                           number(row.most), row.runs, row.frames, verdict, row.note));
    EXPECT_TRUE(passed) << row.test << ", " << row.scene << ", " << row.what << ": " << row.value << " in [" << row.low << ", " << row.high << "], which must lie in [" << row.least << ", "
                        << row.most << "]; " << row.note << (noise ? " (noise: PARHELION_TRUTH_EFFORT=4 draws four times the frames)" : "");
}

void report_skip(const std::string& test, const std::string& scene, const std::string& why) {
    print(fmt::format(kLine, test, scene, "-", "-", "-", "-", "-", "-", 0, 0, "SKIP", why));
    write_line(fmt::format("{}\t{}\t-\t-\t-\t-\t-\t-\t0\t0\tSKIP\t{}", test, scene, why));
}

std::ostream& operator<<(std::ostream& out, const TruthScene& scene) { return out << scene.name; }

std::span<const TruthScene> truth_scenes() { return kScenes; }

std::string why_skipped(const TruthScene& scene) {
    if (small_truth() && !scene.small) return "not in the small truth";
    if (!is_file(scene)) return {};
    if (assets().empty()) return "PARHELION_ASSETS does not name the folder of real scenes";
    const std::string file = assets() + "/" + scene.source;
    return std::filesystem::exists(file) ? std::string() : file + " is not there";
}

TruthStage set_up(LoadedScene loaded, const CameraView& camera) {
    shared_device();  // outlives the stages
    TruthStage out{.stage = std::make_unique<Stage>(std::move(loaded.scene), SceneGpuOptions(), FrameOptions{.timers = Timers::None, .markers = false}), .scripted_edits = std::move(loaded.scripted_edits), .camera = camera};
    const gpu::DevicePtr& device = shared_device();
    out.way = gpu::device_class(device->caps()).way;
    out.stage->scene_gpu.finish(out.stage->frame);
    const double ev = meter_scene(device, out.stage->frame, out.stage->scene_gpu, out.way, truth_view(out, 64, 0, false));
    out.exposure = static_cast<float>(image::exposure_scale_from_ev100(ev));
    return out;
}

TruthStage& truth_stage(const TruthScene& scene, float least_sun_radius) {
    shared_device();
    static std::string name;
    static TruthStage held;
    const std::string asked = fmt::format("{} {}", scene.name, least_sun_radius);
    if (name == asked) return held;
    name.clear();
    held = {};
    LoadedScene loaded = load_scene(is_file(scene) ? assets() + "/" + scene.source : scene.source);
    add_light(loaded.scene, {}, {});
    widen_suns(loaded.scene, least_sun_radius);
    const CameraView camera = scene.from != scene.at           ? look_at(scene.from, scene.at, glm::radians(scene.fov_degrees))
                              : loaded.scene.cameras().empty() ? framing_view(loaded.scene.bounds(), 1.0f)
                                                               : view_of((*loaded.scene.cameras().begin()).value, 1.0f);
    held = set_up(std::move(loaded), camera);
    name = asked;
    return held;
}

ViewDesc truth_view(const TruthStage& on, uint32_t size, uint32_t seed, bool classes) {
    ViewDesc desc{.width = size, .height = size, .camera = shader_camera(on.camera, 1.0f), .seed = seed, .filter = PixelFilter::Point};
    desc.camera.lens_radius = 0.0f;
    if (classes) desc.aovs = {"path.*"};
    return desc;
}

RealtimeOptions truth_options(const TruthStage& on, bool cache) {
    const std::string_view reuse = truth_reuse();
    return {.reuse = reuse == "none" ? RealtimeReuse::None : RealtimeReuse::Full, .reuse_options = {.adapt_confidence = reuse != "history"}, .cache = cache, .exposure = on.exposure};
}

image::ImageF draw_paths(TruthStage& on, const ViewDesc& view, const CameraView& camera, uint32_t samples) {
    // A slice's paths are at most as many as the wavefront has slots.
    const uint32_t slice = std::clamp(kMaxWavefrontSlots / (view.width * view.height), 1u, 64u);
    Shot shot{.way = on.way, .view = view, .camera = camera, .sample_count = samples, .slice_samples = slice, .rounds = 24};
    if (!small_truth()) shot.wavefront = WavefrontOptions{.sample_bytes = uint64_t{1} << 30};
    return on.stage->picture(shot);
}

image::ImageF draw_reference(TruthStage& on, uint32_t size, uint32_t seed, uint32_t samples, bool classes) {
    CameraView pinhole = on.camera;
    pinhole.lens_radius = 0.0f;
    return draw_paths(on, truth_view(on, size, seed, classes), pinhole, samples);
}

TruthRun::TruthRun(TruthStage& on, uint32_t size, uint32_t seed, const RealtimeOptions& options, bool classes) : TruthRun(on, truth_view(on, size, seed, classes), options) {}

TruthRun::TruthRun(TruthStage& on, const ViewDesc& desc, const RealtimeOptions& options)
    : on_(on), view_(on.stage->frame.device(), desc), realtime_(on.stage->frame.device(), view_, options) {
    on.stage->step({});  // the scene stood there before, so that what it shows has a past
    on.stage->scene_gpu.finish(on.stage->frame);
}

void TruthRun::record(bool last) {
    Stage& stage = *on_.stage;
    if (script) {
        stage.step(script(realtime_.frame_index()));
        stage.scene_gpu.finish(stage.frame);
    }
    realtime_.record(stage.frame, stage.scene_gpu, on_.way, view_, last);
    in_flight_.push_back(stage.frame.submit());
    if (in_flight_.size() < kMostInFlight) return;
    stage.frame.wait(in_flight_.front());
    in_flight_.pop_front();
}

void TruthRun::skip(uint32_t frames) {
    view_.clear_film();
    for (uint32_t i = 0; i < frames; ++i) record(i + 1 == frames);
    for (; !in_flight_.empty(); in_flight_.pop_front()) on_.stage->frame.wait(in_flight_.front());
}

image::ImageF TruthRun::average(uint32_t frames) {
    skip(frames);
    const ViewDesc& desc = view_.desc();
    return image::resolve_film(make_film_sums(view_.read_film(on_.stage->frame), {desc.width, desc.height}, {0, frames}, {}));
}

void TruthRun::look(const CameraView& camera) {
    view_.set_camera(shader_camera(camera, 1.0f));
}

std::vector<float> luminance(const image::ImageF& picture, size_t first_channel) {
    const auto r = picture.plane(first_channel), g = picture.plane(first_channel + 1), b = picture.plane(first_channel + 2);
    std::vector<float> out(picture.pixel_count());
    for (size_t p = 0; p < out.size(); ++p) out[p] = 0.2126f * r[p] + 0.7152f * g[p] + 0.0722f * b[p];
    return out;
}

void add_run(ClassRuns& runs, const image::ImageF& picture, uint32_t tile_size) {
    constexpr std::string_view kPrefix = "path.";
    for (size_t c = 0; c + 2 < picture.channels.size(); c += 3) {
        std::string name = picture.channels[c] == "R" ? "picture" : picture.channels[c].substr(0, picture.channels[c].size() - 2);
        if (name.starts_with(kPrefix)) name.erase(0, kPrefix.size());
        runs.try_emplace(std::move(name), picture.width, picture.height, tile_size).first->second.add_run(luminance(picture, c));
    }
}

void TruthTest::SetUp() {
    GpuTest::SetUp();
    if (!IsSkipped() && !LightCache::supported(device()->caps())) GTEST_SKIP() << "no 64-bit atomics on buffers";
}

}  // namespace parhelion::testing
