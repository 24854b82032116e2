#include "renderers/view.h"

#include <algorithm>
#include <cmath>

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
    };
    return groups;
}

namespace {

// "path.*" asks for every group whose name begins with "path.".
bool is_asked_for(const FilmGroup& group, const std::string& aov) {
    if (aov.ends_with('*')) return group.name.starts_with(std::string_view(aov).substr(0, aov.size() - 1));
    return group.name == aov;
}

void check_aovs(const std::vector<std::string>& aovs) {
    for (const std::string& aov : aovs) {
        if (std::ranges::any_of(film_groups(), [&](const FilmGroup& group) { return is_asked_for(group, aov); })) continue;
        std::string known;
        for (const FilmGroup& group : film_groups()) known += (known.empty() ? "" : ", ") + std::string(group.name);
        throw Error(ErrorCode::Usage, fmt::format("there is no AOV '{}'", escape_name(aov)), "--aov", "choose from " + known + ", path.*");
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
        const bool wanted = group.group == shared::kFilmBeauty || std::ranges::any_of(desc.aovs, [&](const std::string& aov) { return is_asked_for(group, aov); });
        data_.channel[group.group] = wanted ? data_.channel_count : shared::kNoChannel;
        if (!wanted) continue;
        for (const std::string_view suffix : group.channels) {
            const bool beauty = group.group == shared::kFilmBeauty;
            channels_.push_back(beauty ? std::string(suffix) : std::string(group.name) + (suffix.empty() ? "" : "." + std::string(suffix)));
            ++data_.channel_count;
        }
    }
    const uint64_t plane = uint64_t(desc.width) * desc.height * sizeof(uint32_t);
    film_ = {.view = gpu::Buffer(device_, "view/data", sizeof(shared::ViewData)),
             .block = gpu::Buffer(device_, "film/block", plane * data_.channel_count),
             .sums = gpu::Buffer(device_, "film/sums", 3 * plane * data_.channel_count),
             .rays = gpu::Buffer(device_, "film/rays", 4 * sizeof(uint32_t)),
             .width = desc.width,
             .height = desc.height,
             .channel_count = data_.channel_count};
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

void View::set_camera(const shared::Camera& camera, const std::optional<shared::Camera>& at_close) {
    data_.camera_before = data_.camera;
    desc_.camera = camera;
    desc_.camera_at_close = at_close;
    place_camera();
    upload_ = true;
    clear_film();
}

void View::prepare(Frame& frame) {
    if (upload_) frame.upload(film_.view, 0, std::as_bytes(std::span(&data_, 1)));
    if (clear_) {
        frame.fill(film_.block, 0);
        frame.fill(film_.sums, 0);
        frame.fill(film_.rays, 0);
    }
    if (!restored_.empty()) {
        PARHELION_CHECK(restored_.size() * sizeof(uint32_t) == film_.sums.bytes(), "a restored film has another size");
        frame.upload(film_.sums, 0, std::as_bytes(std::span(restored_)));
        restored_.clear();
    }
    upload_ = clear_ = false;
}

FilmReadback View::read_film(Frame& frame) const {
    const gpu::Buffer copy = frame.read_back(film_.sums);
    frame.run();
    const std::span<uint32_t> limbs = copy.mapped_as<uint32_t>();
    return {channels_, {limbs.begin(), limbs.end()}};
}

RayCounts View::read_rays(Frame& frame) const {
    const gpu::Buffer copy = frame.read_back(film_.rays);
    frame.run();
    const std::span<uint32_t> words = copy.mapped_as<uint32_t>();
    return {.path = uint64_t(words[1]) << 32 | words[0], .shadow = uint64_t(words[3]) << 32 | words[2]};
}

}  // namespace parhelion
