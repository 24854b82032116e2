#include "renderers/view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include "base/error.h"
#include "renderers/camera_motion.h"

namespace parhelion {

std::span<const FilmGroup> film_groups() {
    static const std::vector<FilmGroup> groups = {
        {"beauty", shared::kFilmBeauty, {"R", "G", "B"}},
        {"albedo", shared::kFilmAlbedo, {"R", "G", "B"}},
        {"normal", shared::kFilmNormal, {"X", "Y", "Z"}},
        {"emission", shared::kFilmEmission, {"R", "G", "B"}},
        {"roughness", shared::kFilmRoughness, {""}},
        {"path.emission", shared::kFilmPathEmission, {"R", "G", "B"}},
        {"path.direct_diffuse", shared::kFilmPathDirectDiffuse, {"R", "G", "B"}},
        {"path.direct_specular", shared::kFilmPathDirectSpecular, {"R", "G", "B"}},
        {"path.indirect_diffuse", shared::kFilmPathIndirectDiffuse, {"R", "G", "B"}},
        {"path.indirect_specular", shared::kFilmPathIndirectSpecular, {"R", "G", "B"}},
        {"path.transmission", shared::kFilmPathTransmission, {"R", "G", "B"}},
        {"squares", shared::kFilmSquares, {"R", "G", "B"}, "variance"},
        {"squares_large", shared::kFilmLargeSquares, {"R", "G", "B"}, "variance"},
        {"debug.cells", shared::kFilmDebugCells, {"R", "G", "B"}},
        {"debug.irradiance", shared::kFilmDebugIrradiance, {"R", "G", "B"}},
        {"debug.level", shared::kFilmDebugLevel, {""}},
        {"debug.count", shared::kFilmDebugCount, {""}},
        {"debug.age", shared::kFilmDebugAge, {""}},
        {"debug.life", shared::kFilmDebugLife, {""}},
        {"debug.light", shared::kFilmDebugLight, {""}},
        {"debug.rays", shared::kFilmDebugRays, {""}},
        {"debug.duplicates", shared::kFilmDebugDuplicates, {""}},
    };
    return groups;
}

std::span<const FirstHitPlane> first_hit_planes() {
    static constexpr std::array<FirstHitPlane, shared::kFirstHitPlaneCount> planes = {{
        {"depth", "depth", false},
        {"ids.instance", "ids", true},
        {"ids.geometry", "ids", true},
        {"ids.primitive", "ids", true},
        {"ids.material", "ids", true},
        {"motion.X", "motion", false},
        {"motion.Y", "motion", false},
    }};
    return planes;
}

std::vector<std::string_view> aov_names() {
    std::vector<std::string_view> names;
    const auto add = [&](std::string_view name) {
        if (std::ranges::find(names, name) == names.end()) names.push_back(name);
    };
    for (const FilmGroup& group : film_groups())
        if (group.group != shared::kFilmBeauty) add(group.aov);
    for (const FirstHitPlane& plane : first_hit_planes()) add(plane.aov);
    return names;
}

namespace {

// "path.*" asks for every AOV whose name begins with "path.".
bool asks_for(const std::string& asked, std::string_view name) {
    if (asked.ends_with('*')) return name.starts_with(std::string_view(asked).substr(0, asked.size() - 1));
    return name == asked;
}
bool is_asked_for(std::string_view name, const std::vector<std::string>& aovs) {
    return std::ranges::any_of(aovs, [&](const std::string& aov) { return asks_for(aov, name); });
}

void check_aovs(const std::vector<std::string>& aovs) {
    const std::vector<std::string_view> names = aov_names();
    for (const std::string& aov : aovs) {
        if (std::ranges::any_of(names, [&](std::string_view name) { return asks_for(aov, name); })) continue;
        std::string known;
        for (const std::string_view name : names) known += std::string(name) + ", ";
        throw Error(ErrorCode::Usage, fmt::format("there is no AOV '{}'", escape_name(aov)), "--aov", "choose from " + known + "path.*, debug.*");
    }
}

// The cone of a pixel in the middle of the picture. One width for both axes: the side of a square of the pixel's area.
void set_pixel_cone(shared::ViewData& data) {
    const float side = 2.0f * std::sqrt(glm::length(data.camera.right_ws) * glm::length(data.camera.up_ws) / (static_cast<float>(data.width) * static_cast<float>(data.height)));
    data.pixel_width = data.camera.orthographic != 0 ? side : 0.0f;
    data.pixel_spread = data.camera.orthographic != 0 ? 0.0f : side;
}

}  // namespace

View::View(gpu::DevicePtr device, const ViewDesc& desc) : device_(std::move(device)), desc_(desc) {
    check_aovs(desc.aovs);
    data_.width = desc.width;
    data_.height = desc.height;
    data_.seed = desc.seed;
    data_.sampler_kind = static_cast<uint32_t>(desc.sampler);
    data_.max_bounces = desc.max_bounces;
    data_.pixel_filter = static_cast<uint32_t>(desc.filter);
    data_.roulette_start = desc.roulette_start;
    data_.light_sampling = desc.light_sampling;
    data_.flags = (desc.energy_compensation ? shared::kViewEnergyCompensation : 0) | (desc.normal_correction ? shared::kViewNormalCorrection : 0) |
                  (desc.spawn_offset == SpawnOffset::Integer ? shared::kViewIntegerOffset : 0);
    data_.firefly_clamp = desc.firefly_clamp;
    place_camera();
    data_.camera_before = data_.camera;
    for (const FilmGroup& group : film_groups()) {
        const bool wanted = group.group == shared::kFilmBeauty || is_asked_for(group.aov, desc.aovs);
        data_.channel[group.group] = wanted ? data_.channel_count : shared::kNoChannel;
        if (!wanted) continue;
        for (const std::string_view suffix : group.channels) {
            const bool beauty = group.group == shared::kFilmBeauty;
            channels_.push_back(beauty ? std::string(suffix) : std::string(group.name) + (suffix.empty() ? "" : "." + std::string(suffix)));
            ++data_.channel_count;
        }
    }
    for (const FirstHitPlane& plane : first_hit_planes())
        if (is_asked_for(plane.aov, desc.aovs)) first_hit_planes_.push_back(&plane);
    const uint64_t pixels = uint64_t(desc.width) * desc.height, plane = pixels * sizeof(uint32_t);
    const uint64_t planes = std::max(3 * data_.channel_count, shared::kFirstHitPlaneCount);
    if (pixels * planes > UINT32_MAX)  // shaders count the film's words with 32 bits
        throw Error(ErrorCode::Usage, fmt::format("a picture of {}x{} pixels with {} channels is more than a film holds", desc.width, desc.height, data_.channel_count), "--size",
                    fmt::format("with these layers up to {} pixels", UINT32_MAX / planes));
    film_ = {.view = gpu::Buffer(device_, "view/data", sizeof(shared::ViewData)),
             .block = gpu::Buffer(device_, "film/block", plane * data_.channel_count),
             .sums = gpu::Buffer(device_, "film/sums", 3 * plane * data_.channel_count),
             .rays = gpu::Buffer(device_, "film/rays", 4 * sizeof(uint32_t)),
             .width = desc.width,
             .height = desc.height,
             .channel_count = data_.channel_count};
    if (!first_hit_planes_.empty()) film_.first_hits = gpu::Buffer(device_, "film/first_hits", shared::kFirstHitPlaneCount * plane);
}

FilmReadback View::film_layout() const {
    FilmReadback film{.channels = channels_};
    for (const FirstHitPlane* plane : first_hit_planes_) film.first_hits.push_back({.plane = plane});
    return film;
}

RowRange View::take_first_hit_rows(uint32_t end) {
    if (first_hit_planes_.empty() || end <= first_hit_rows_) return {};
    const uint32_t first = std::exchange(first_hit_rows_, end);
    return {.first = first, .count = end - first};
}

void View::restore_film(FilmReadback film) {
    PARHELION_CHECK(film.limbs.size() * sizeof(uint32_t) == film_.sums.bytes() && film.first_hits.size() == first_hit_planes_.size(), "a restored film has another size");
    restored_ = std::move(film);
    first_hit_rows_ = desc_.height;
}

void View::place_camera() {
    data_.camera = desc_.camera;
    data_.flags &= ~shared::kViewShutter;
    if (desc_.camera_at_close) {
        data_.motion = camera_motion(desc_.camera, *desc_.camera_at_close);
        data_.flags |= shared::kViewShutter;
    }
    set_pixel_cone(data_);
}

void View::set_camera(const shared::Camera& camera, const std::optional<shared::Camera>& at_close, bool keep_film) {
    data_.camera_before = data_.camera;
    desc_.camera = camera;
    desc_.camera_at_close = at_close;
    place_camera();
    upload_ = true;
    if (!keep_film) clear_film();
}

void View::end_frame() {
    if (std::memcmp(&data_.camera_before, &data_.camera, sizeof(data_.camera)) == 0 && data_.jitter_before == data_.jitter) return;
    data_.camera_before = data_.camera;
    data_.jitter_before = data_.jitter;
    upload_ = true;
}

void View::set_jitter(glm::vec2 jitter_px) {
    upload_ = upload_ || data_.jitter != jitter_px;
    data_.jitter = jitter_px;
}

void View::prepare(Frame& frame) {
    if (upload_) frame.upload(film_.view, 0, std::as_bytes(std::span(&data_, 1)));
    if (clear_) {
        frame.fill(film_.block, 0);
        frame.fill(film_.sums, 0);
        frame.fill(film_.rays, 0);
    }
    if (!restored_.limbs.empty()) {
        frame.upload(film_.sums, 0, std::as_bytes(std::span(restored_.limbs)));
        for (const FirstHitLayer& layer : restored_.first_hits)
            frame.upload(film_.first_hits, first_hit_offset(*layer.plane), std::as_bytes(std::span(layer.words)));
        restored_ = {};
    }
    upload_ = clear_ = false;
}

uint64_t View::first_hit_offset(const FirstHitPlane& plane) const {
    return static_cast<uint64_t>(&plane - first_hit_planes().data()) * desc_.width * desc_.height * sizeof(uint32_t);
}

FilmReadback View::read_film(Frame& frame) const {
    const gpu::Buffer sums = frame.read_back(film_.sums), hits = first_hit_planes_.empty() ? gpu::Buffer() : frame.read_back(film_.first_hits);
    frame.run();
    FilmReadback film = film_layout();
    const std::span<uint32_t> limbs = sums.mapped_as<uint32_t>();
    film.limbs.assign(limbs.begin(), limbs.end());
    for (FirstHitLayer& layer : film.first_hits) {
        const auto words = hits.mapped_as<uint32_t>().subspan(first_hit_offset(*layer.plane) / sizeof(uint32_t), size_t{desc_.width} * desc_.height);
        layer.words.assign(words.begin(), words.end());
    }
    return film;
}

RayCounts View::read_rays(Frame& frame) const {
    const gpu::Buffer copy = frame.read_back(film_.rays);
    frame.run();
    const std::span<uint32_t> words = copy.mapped_as<uint32_t>();
    return {.path = uint64_t(words[1]) << 32 | words[0], .shadow = uint64_t(words[3]) << 32 | words[2]};
}

}  // namespace parhelion
