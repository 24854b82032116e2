#include "session/film_state.h"

#include <algorithm>

#include "base/error.h"
#include "base/hash.h"
#include "session/scene_setup.h"

namespace parhelion {

uint64_t hash_render(const Scene& scene, const ViewDesc& view, const RenderSettings& settings, double upscale) {
    RenderSettings shown = settings;
    const RenderSettings standard;  // of what does not belong to the picture, as --trace
    shown.node_layout = standard.node_layout, shown.bvh_loop = standard.bvh_loop;
    shown.wavefront_slots = standard.wavefront_slots, shown.wavefront_connect = standard.wavefront_connect, shown.wavefront_dispatch = standard.wavefront_dispatch;
    shown.wavefront_classes = standard.wavefront_classes, shown.wavefront_memory_mb = standard.wavefront_memory_mb;
    Hasher hasher;
    hasher.add(hash_scene(scene))
        .add(hash_settings(shown))
        .add(view.width)
        .add(view.height)
        .add(view.seed)
        .add(view.max_bounces)
        .add(view.filter);
    for (const shared::Camera& camera : {view.camera, view.camera_at_close.value_or(view.camera)}) {
        for (const glm::vec3& v : {camera.position_ws, camera.right_ws, camera.up_ws, camera.forward_ws}) hasher.add(v.x).add(v.y).add(v.z);
        hasher.add(camera.orthographic).add(camera.lens_radius).add(camera.focus_distance);
    }
    if (upscale != 1) hasher.add(upscale);
    return hasher.value();
}

image::Attributes film_attributes(uint64_t settings_hash, double exposure_ev) {
    return {{kSettingsAttribute, fmt::format("{:016x}", settings_hash)}, {kExposureAttribute, fmt::format("{}", exposure_ev)}};
}

std::optional<double> recorded_exposure(const image::Attributes& attributes) {
    const auto found = attributes.find(kExposureAttribute);
    if (found == attributes.end()) return std::nullopt;
    try {
        return parse_float(found->second, kExposureAttribute, -100, 100);
    } catch (const Error& error) {
        throw Error(ErrorCode::Failed, "the image's recorded exposure is damaged: " + error.problem, kExposureAttribute);
    }
}

image::FilmSums make_film_sums(FilmReadback film, Size2 size, IndexRange samples, image::Attributes attributes) {
    std::vector<image::ExactLayer> exact;
    for (FirstHitLayer& layer : film.first_hits)
        exact.push_back({.channel = std::string(layer.plane->channel), .whole = layer.plane->whole, .words = std::move(layer.words)});
    return {.width = size.width,
            .height = size.height,
            .channels = std::move(film.channels),
            .sample_begin = samples.begin,
            .sample_end = samples.end,
            .limbs = std::move(film.limbs),
            .exact = std::move(exact),
            .attributes = std::move(attributes)};
}

FilmReadback film_readback(image::FilmSums film, FilmReadback layout) {
    layout.limbs = std::move(film.limbs);
    for (size_t i = 0; i < layout.first_hits.size(); ++i) layout.first_hits[i].words = std::move(film.exact.at(i).words);
    return layout;
}

image::FilmSums read_checkpoint(const std::filesystem::path& file, const image::FilmSums& expected, IndexRange wanted) {
    const auto refuse = [&](std::string what, std::string hint) {
        throw Error(ErrorCode::Failed, std::move(what), escape_name(file.string()), std::move(hint));
    };
    image::FilmSums film = image::read_film_exr(file);
    const bool same = film.width == expected.width && film.height == expected.height && film.channels == expected.channels &&
                      std::ranges::equal(film.exact, expected.exact, [](const auto& a, const auto& b) { return a.same_kind(b); }) &&
                      film.attributes == expected.attributes && film.sample_begin == wanted.begin;
    if (!same) refuse("it is the checkpoint of another render", "repeat the command that wrote it, or choose another file");
    if (film.sample_end > wanted.end)
        refuse(fmt::format("it already holds {} samples", film.sample_end - film.sample_begin), "ask for at least as many");
    return film;
}

}  // namespace parhelion
