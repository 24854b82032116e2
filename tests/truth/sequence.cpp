#include "truth/sequence.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "base/error.h"
#include "base/file.h"
#include "image/decode.h"
#include "image/encode.h"
#include "image/flip.h"
#include "image/tonemap.h"
#include "session/film_state.h"
#include "session/scene_setup.h"

namespace parhelion::testing {

namespace {

const Sequence kSequences[] = {{"cornell", {"torch"}}, {"spheres", {"leave"}}, {"diorama", {"robot", "lamp"}}, {"reflections", {"roll"}}, {"many_lights", {"blink"}}};

}  // namespace

std::span<const Sequence> sequences() { return kSequences; }

const TruthScene& scene_of(const Sequence& sequence) {
    const auto all = truth_scenes();
    const auto scene = std::ranges::find_if(all, [&](const TruthScene& s) { return std::string_view(s.name) == sequence.scene; });
    PARHELION_CHECK(scene != all.end(), "no scene {} among those of the truth", sequence.scene);
    return *scene;
}

double flip_of(const image::ImageF& picture, const image::ImageF& reference) {
    return image::flip_hdr(image::rgb_planes(reference), image::rgb_planes(picture), picture.width, picture.height).mean;
}

namespace {

constexpr double kFramesPerSecond = 30.0;

CameraView camera_at(const CameraView& start, float step_m, uint32_t frame) {
    const uint32_t phase = (frame + 8) % 32;
    CameraView moved = start;
    moved.position += start.right * (step_m * (static_cast<float>(phase < 16 ? phase : 32 - phase) - 8.0f));
    return moved;
}

void change(TruthStage& on, const SequenceScript& script, uint32_t frame) {
    Scene& scene = on.stage->scene;
    ChangeSet changes = scene.begin_frame();
    if (script.change) changes.append(script.change(scene, frame));
    on.stage->scene_gpu.sync(scene, changes);
    on.stage->scene_gpu.finish(on.stage->frame);
}

// In step with others: the scene's frame is the caller's.
struct Played {
    Played(TruthStage& on, const ViewDesc& desc, const RealtimeOptions& options) : view(on.stage->frame.device(), desc), realtime(on.stage->frame.device(), view, options) {}
    View view;
    Realtime realtime;

    void record(TruthStage& on, const CameraView& camera) {
        view.set_camera(shader_camera(camera, 1.0f));
        realtime.record(on.stage->frame, on.stage->scene_gpu, on.way, view, true);
        on.stage->frame.run();
    }
    double rays_per_pixel(TruthStage& on) const {
        const RayCounts rays = view.read_rays(on.stage->frame);
        return static_cast<double>(rays.path + rays.shadow) / (static_cast<double>(view.film().width) * view.film().height);
    }
    image::ImageF picture(TruthStage& on) {
        return image::resolve_film(make_film_sums(view.read_film(on.stage->frame), {view.film().width, view.film().height}, {0, 1}, {}));
    }
};

image::ImageF draw(TruthStage& on, const CameraView& camera, uint32_t size, uint32_t samples) {
    ViewDesc desc = truth_view(on, size, 5, false);
    desc.filter = PixelFilter::Box;
    return draw_paths(on, desc, camera, samples);
}

image::ImageF reference_of(TruthStage& on, const CameraView& camera, uint32_t size, uint32_t samples, const std::string& name) {
    const char* folder = std::getenv("PARHELION_TRUTH_REFERENCES");
    if (!folder) return draw(on, camera, size, samples);
    const std::filesystem::path kept = std::filesystem::path(folder) / fmt::format("{}.{}px.{}spp.exr", name, size, samples);
    if (std::filesystem::exists(kept)) return image::decode_exr(read_file(kept, uint64_t{1} << 30));
    const image::ImageF drawn = draw(on, camera, size, samples);
    image::write_exr(kept, drawn, image::ExrPrecision::Float);
    return drawn;
}

void keep_pictures(const std::string& name, const image::ImageF& reference, std::span<const SequenceRun> runs) {
    const char* folder = std::getenv("PARHELION_TRUTH_PICTURES");
    if (!folder) return;
    const auto keep = [&](const std::string& of, const image::ImageF& picture) { image::write_exr(std::filesystem::path(folder) / fmt::format("{}.{}.exr", name, of), picture, image::ExrPrecision::Half); };
    if (reference.width != 0) keep("reference", reference);
    for (const SequenceRun& run : runs) keep(run.name, run.picture);
}

}  // namespace

CameraView strafing_camera(const TruthStage& on, uint32_t size, float pixels, uint32_t frame) {
    const float distance = glm::length(on.stage->scene.bounds().center() - on.camera.position);
    return camera_at(on.camera, pixels * 2.0f * distance * std::tan(0.5f * on.camera.yfov) / static_cast<float>(size), frame);
}

void play(TruthStage& on, const SequenceScript& script, uint32_t size, std::vector<SequenceRun>& runs, const std::function<void(const SequenceFrame&)>& look) {
    std::vector<std::unique_ptr<Played>> played;
    for (const SequenceRun& run : runs) {
        ViewDesc desc = truth_view(on, size, run.seed, false);
        desc.aovs = run.aovs;
        played.push_back(std::make_unique<Played>(on, desc, run.options));
    }
    for (uint32_t frame = 0; frame <= script.looks.back(); ++frame) {
        change(on, script, frame);
        const CameraView camera = script.camera ? script.camera(frame) : on.camera;
        const bool looks_now = std::ranges::find(script.looks, frame) != script.looks.end();
        SequenceFrame shown{.index = frame};
        const std::string name = fmt::format("{}.{:04}", script.name, frame);
        if (looks_now && std::ranges::find(script.references, frame) != script.references.end()) shown.reference = reference_of(on, camera, size, script.samples, name);
        for (size_t k = 0; k < runs.size(); ++k) {
            if (runs[k].cut_at == frame) played[k]->realtime.cut();
            played[k]->record(on, camera);
            if (!looks_now) continue;
            runs[k].rays_per_pixel = played[k]->rays_per_pixel(on);
            runs[k].picture = played[k]->picture(on);
        }
        if (!looks_now) continue;
        keep_pictures(name, shown.reference, runs);
        look(shown);
    }
}

void play(TruthStage& on, const TruthScene& scene, const Sequence& sequence, uint32_t size, float pixels, uint32_t samples, std::span<const uint32_t> looks, std::vector<SequenceRun>& runs,
          const std::function<void(const SequenceFrame&)>& look) {
    SequenceScript script{.name = scene.name, .looks = {looks.begin(), looks.end()}, .samples = samples};
    if (samples != 0) script.references = script.looks;
    script.change = [&](Scene& changed, uint32_t frame) {
        ChangeSet changes;
        for (const ScriptedEdit& scripted : on.scripted_edits)
            for (const char* name : sequence.scripts)
                if (scripted.name == name) changes.append(changed.apply(scripted.apply(changed, frame / kFramesPerSecond)));
        return changes;
    };
    script.camera = [&](uint32_t frame) { return strafing_camera(on, size, pixels, frame); };
    play(on, script, size, runs, look);
}

std::vector<float> displayed(const image::ImageF& picture, float exposure) {
    std::vector<float> out(picture.pixel_count());
    const auto r = picture.plane(0), g = picture.plane(1), b = picture.plane(2);
    for (size_t p = 0; p < out.size(); ++p) {
        const image::Rgb shown = image::apply_tone_curve({r[p] * exposure, g[p] * exposure, b[p] * exposure}, image::ToneCurve::Aces);
        out[p] = std::pow(0.2126f * shown[0] + 0.7152f * shown[1] + 0.0722f * shown[2], 1.0f / 2.2f);
    }
    return out;
}

std::vector<float> layer(const image::ImageF& picture, std::string_view name) {
    if (const auto channel = picture.find_channel(name)) return {picture.plane(*channel).begin(), picture.plane(*channel).end()};
    for (const image::ExactLayer& exact : picture.exact) {
        if (exact.channel != name) continue;
        std::vector<float> out(exact.words.size());
        std::ranges::transform(exact.words, out.begin(), [](uint32_t word) { return std::bit_cast<float>(word); });
        return out;
    }
    throw Error(ErrorCode::Usage, "a picture lacks a layer", std::string(name), "ask for it");
}

namespace {

bool same_depth(float before, float now) { return std::abs(before - now) < 0.03f * now || (std::isinf(now) && std::isinf(before)); }

// Where pixels of a frame were in the one before: the four around, and their weights; none where another surface was seen.
struct Moved {
    size_t taps[4];
    float weights[4];
    bool visible = false;
};
Moved move_back(size_t here, uint32_t width, uint32_t height, std::span<const float> dx, std::span<const float> dy, std::span<const float> depth_before, float depth) {
    const float x = static_cast<float>(here % width) + dx[here], y = static_cast<float>(here / width) + dy[here];
    if (!(x >= 0 && y >= 0 && x < static_cast<float>(width - 1) && y < static_cast<float>(height - 1))) return {};
    const auto x0 = static_cast<size_t>(x), y0 = static_cast<size_t>(y);
    const float fx = x - static_cast<float>(x0), fy = y - static_cast<float>(y0);
    const size_t first = y0 * width + x0;
    Moved moved{{first, first + 1, first + width, first + width + 1}, {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy}, true};
    for (const size_t tap : moved.taps) moved.visible = moved.visible && same_depth(depth_before[tap], depth);
    return moved;
}

}  // namespace

double flicker(FramePair pictures, FramePair references, FramePair guides, float exposure) {
    const std::vector<float> old = displayed(pictures.before, exposure), current = displayed(pictures.now, exposure);
    const std::vector<float> old_truth = displayed(references.before, exposure), truth = displayed(references.now, exposure);
    const std::vector<float> depth_before = layer(guides.before, "depth"), depth = layer(guides.now, "depth"), dx = layer(guides.now, "motion.X"), dy = layer(guides.now, "motion.Y");
    double sum = 0;
    size_t count = 0;
    for (size_t here = 0; here < current.size(); ++here) {
        const Moved moved = move_back(here, pictures.now.width, pictures.now.height, dx, dy, depth_before, depth[here]);
        if (!moved.visible) continue;
        double change = static_cast<double>(current[here] - truth[here]);
        for (int i = 0; i < 4; ++i) change -= static_cast<double>(moved.weights[i] * (old[moved.taps[i]] - old_truth[moved.taps[i]]));
        sum += std::abs(change);
        ++count;
    }
    return count == 0 ? 0 : sum / static_cast<double>(count);
}

std::vector<InSight> in_sight(const std::vector<InSight>& before, FramePair guides) {
    const std::vector<float> depth_before = layer(guides.before, "depth"), depth = layer(guides.now, "depth"), dx = layer(guides.now, "motion.X"), dy = layer(guides.now, "motion.Y");
    const auto width = static_cast<float>(guides.now.width), height = static_cast<float>(guides.now.height);
    std::vector<InSight> out(depth.size());
    for (size_t here = 0; here < out.size(); ++here) {
        const float x = static_cast<float>(here % guides.now.width) + dx[here], y = static_cast<float>(here / guides.now.width) + dy[here];
        if (std::isinf(depth[here])) continue;
        out[here] = {.frames = 1, .over_edge = !(x >= -0.5f && y >= -0.5f && x < width - 0.5f && y < height - 0.5f)};
        if (out[here].over_edge) continue;
        // Where the nearest of the four around shows it; where none does it is new. What lies along an edge is not.
        float nearest = 2.0f;
        for (int i = 0; i < 4; ++i) {
            const float tap_x = std::clamp(std::floor(x) + static_cast<float>(i % 2), 0.0f, width - 1), tap_y = std::clamp(std::floor(y) + static_cast<float>(i / 2), 0.0f, height - 1);
            const size_t tap = static_cast<size_t>(tap_y) * guides.now.width + static_cast<size_t>(tap_x);
            const float apart = std::abs(x - tap_x) + std::abs(y - tap_y);
            if (apart >= nearest || !same_depth(depth_before[tap], depth[here])) continue;
            nearest = apart;
            const InSight then = before.empty() ? InSight{.frames = kSeenForLong} : before[tap];
            out[here] = {.frames = then.frames + 1, .over_edge = then.over_edge};
        }
    }
    return out;
}

}  // namespace parhelion::testing
