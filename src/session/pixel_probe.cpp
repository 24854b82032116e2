#include "session/pixel_probe.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "base/error.h"
#include "renderers/reference.h"
#include "session/film_state.h"
#include "shared/reservoir.h"

namespace parhelion {

namespace {

constexpr float kLastLeg = 1.0f;  // of a path that leaves the scene, in distances from the camera to its first surface

// The camera of a picture of that one pixel.
shared::Camera camera_of(const ViewDesc& view, glm::uvec2 pixel) {
    shared::Camera camera = view.camera;
    const glm::vec2 size(view.width, view.height), p = (glm::vec2(pixel) + 0.5f) / size;
    const glm::vec3 offset = (2.0f * p.x - 1.0f) * camera.right_ws + (1.0f - 2.0f * p.y) * camera.up_ws;
    (camera.orthographic != 0 ? camera.position_ws : camera.forward_ws) += offset;
    camera.right_ws /= size.x;
    camera.up_ws /= size.y;
    camera.lens_radius = 0;
    return camera;
}

std::string text_of(const glm::vec3& v) { return fmt::format("{:.4g}, {:.4g}, {:.4g}", v.x, v.y, v.z); }

// The values of a film of one pixel.
struct OnePixel {
    const FilmReadback& film;
    uint64_t samples;

    float mean(std::string_view channel) const {
        const auto found = std::ranges::find(film.channels, channel);
        PARHELION_CHECK(found != film.channels.end(), "the probe has no channel {}", channel);
        const uint32_t* limbs = film.limbs.data() + 3 * (found - film.channels.begin());
        return image::fixed_mean({limbs[0], limbs[1], limbs[2]}, samples);
    }
    glm::vec3 mean3(const std::string& layer, std::string_view suffixes = "RGB") const {
        const auto one = [&](int i) { return mean((layer.empty() ? "" : layer + ".") + suffixes[static_cast<size_t>(i)]); };
        return {one(0), one(1), one(2)};
    }
    uint32_t word(std::string_view channel) const {
        const auto found = std::ranges::find_if(film.first_hits, [&](const FirstHitLayer& layer) { return layer.plane->channel == channel; });
        PARHELION_CHECK(found != film.first_hits.end(), "the probe has no layer {}", channel);
        return found->words.front();
    }
};

PixelReport::Section surface_section(const OnePixel& pixel, const SceneGpu& scene, float depth) {
    PixelReport::Section out{"surface", {}};
    const auto row = [&](const char* what, std::string value) { out.rows.emplace_back(what, std::move(value)); };
    row("instance", scene.instance_text(pixel.word("ids.instance")));
    row("primitive", fmt::format("{}, triangle {}", pixel.word("ids.geometry"), pixel.word("ids.primitive")));
    row("material", scene.material_text(pixel.word("ids.material")));
    row("depth", fmt::format("{:.5g} m", depth));
    row("normal", text_of(pixel.mean3("normal", "XYZ")));
    row("albedo", text_of(pixel.mean3("albedo")));
    row("roughness", fmt::format("{:.4g}", pixel.mean("roughness")));
    return out;
}

PixelReport::Section light_section(const OnePixel& pixel) {
    PixelReport::Section out{fmt::format("light, nits ({} samples)", pixel.samples), {{"all", text_of(pixel.mean3(""))}}};
    for (const char* name : {"emission", "direct_diffuse", "direct_specular", "indirect_diffuse", "indirect_specular", "transmission"}) {
        const glm::vec3 value = pixel.mean3(std::string("path.") + name);
        if (value != glm::vec3(0)) out.rows.emplace_back(name, text_of(value));
    }
    return out;
}

// Rays of a path begin at its vertices; a shadow ray that began at one comes before the path's next ray.
PixelReport::Section path_section(std::span<const shared::DumpedRay> rays, std::vector<glm::vec3>& vertices) {
    PixelReport::Section out{"path of the first sample", {}};
    glm::vec3 direction(0);
    for (const shared::DumpedRay& ray : rays) {
        if (ray.reach == 0) break;
        if (ray.reach < 0) {
            out.rows.emplace_back("asks for light", (-ray.reach < kLargestCoordinate ? fmt::format("{:.4g} m along ", -ray.reach) : "infinitely far along ") + text_of(ray.direction_ws));
            continue;
        }
        out.rows.emplace_back(vertices.empty() ? "camera" : fmt::format("vertex {}", vertices.size()), text_of(ray.origin_ws));
        vertices.push_back(ray.origin_ws);
        direction = ray.direction_ws;
    }
    if (vertices.empty()) return out;
    const float scale = vertices.size() > 1 ? glm::distance(vertices[0], vertices[1]) : 1.0f;
    vertices.push_back(vertices.back() + direction * (kLastLeg * scale));
    out.rows.emplace_back("goes on along", text_of(direction));
    return out;
}

}  // namespace

std::string PixelReport::text() const {
    std::string out = fmt::format("pixel {}, {}\n", pixel.x, pixel.y);
    for (const Section& section : sections) {
        out += section.title + "\n";
        for (const auto& [what, value] : section.rows) out += fmt::format("  {}: {}\n", what, value);
    }
    return out;
}

PixelReport probe_pixel(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const ViewDesc& view, glm::uvec2 pixel) {
    ViewDesc desc = view;
    desc.width = desc.height = 1;
    desc.camera = camera_of(view, pixel);
    desc.camera_at_close.reset();
    desc.filter = PixelFilter::Point;
    desc.texture_lod = TextureLod::Full;
    desc.shade_in = ShadeIn::Raygen;
    desc.aovs = {"albedo", "normal", "roughness", "depth", "ids", "path.*"};
    View small(frame.device(), desc);
    record_reference(frame, scene, way, small, {0, 1, 0, kProbeSamples}, true);
    frame.run();
    const FilmReadback film = small.read_film(frame);
    const gpu::Buffer dump(frame.device(), "probe/rays", shared::kMaxDumpedRays * sizeof(shared::DumpedRay));
    frame.fill(dump, 0);
    passes::path_trace_dumping(frame, scene, way, small.film(), {0, 1, 0, 1}, dump);
    const gpu::Buffer read = frame.read_back(dump);
    frame.run();

    const OnePixel values{film, kProbeSamples};
    PixelReport report{.pixel = pixel};
    // Along the camera's own direction, of which the small camera's has another length.
    const float along = std::bit_cast<float>(values.word("depth"));
    report.meets_surface = std::isfinite(along);
    if (report.meets_surface) {
        const shared::Camera& camera = desc.camera;
        const float steps = along / glm::dot(camera.forward_ws, camera.forward_ws);
        report.position_ws = camera.position_ws + camera.forward_ws * steps;
        report.sections.push_back(surface_section(values, scene, glm::dot(report.position_ws - view.camera.position_ws, view.camera.forward_ws)));
        report.sections.back().rows.emplace_back("position", text_of(report.position_ws));
    }
    report.sections.push_back(light_section(values));
    report.sections.push_back(path_section(read.mapped_as<shared::DumpedRay>(), report.path_ws));
    return report;
}

// ---- realtime ----

std::vector<std::string> realtime_probe_layers() {
    std::vector<std::string> layers;
    for (const FilmGroup& group : film_groups())
        if (group.aov.starts_with("debug.")) layers.emplace_back(group.aov);
    return layers;
}

RealtimeProbe::RealtimeProbe(Frame& frame, const View& view, const gpu::Buffer& reservoirs, glm::uvec2 pixel) {
    const passes::Film& film = view.film();
    const uint64_t plane = uint64_t(film.width) * film.height, at = uint64_t(pixel.y) * film.width + pixel.x;
    std::vector<uint64_t> offsets;
    for (size_t c = 0; c < view.channels().size(); ++c) {
        if (!view.channels()[c].starts_with("debug.")) continue;
        channels_.push_back(view.channels()[c]);
        offsets.push_back((c * plane + at) * sizeof(float));
    }
    const gpu::Buffer values(frame.device(), "probe/values", std::max<uint64_t>(1, offsets.size()) * sizeof(float));
    for (size_t i = 0; i < offsets.size(); ++i) frame.copy(film.block, offsets[i], values, i * sizeof(float), sizeof(float));
    values_ = frame.read_back(values);
    if (!reservoirs) return;
    const gpu::Buffer one(frame.device(), "probe/reservoir", sizeof(shared::PackedReservoir));
    frame.copy(reservoirs, at * sizeof(shared::PackedReservoir), one, 0, sizeof(shared::PackedReservoir));
    reservoir_ = frame.read_back(one);
}

std::vector<PixelReport::Section> RealtimeProbe::sections(const SceneGpu& scene) const {
    const auto values = values_.mapped_as<float>();
    const auto value = [&](std::string_view channel) {
        const auto found = std::ranges::find(channels_, channel);
        return found == channels_.end() ? 0.0f : values[static_cast<size_t>(found - channels_.begin())];
    };
    std::vector<PixelReport::Section> out;
    const auto asked = static_cast<uint32_t>(value("debug.light"));
    out.push_back({"realtime, this frame", {{"light asked for", asked == 0 ? "none" : fmt::format("{}: {}", asked - 1, scene.emitter_text(asked - 1))}, {"rays", fmt::format("{}", value("debug.rays"))}}});
    PixelReport::Section cell{"cell of the world cache", {}};
    if (value("debug.count") > 0 || value("debug.life") > 0) {
        cell.rows = {{"level", fmt::format("{}", value("debug.level"))}, {"samples", fmt::format("{}", value("debug.count"))}, {"age", fmt::format("{} frames", value("debug.age"))},
                     {"lives on", fmt::format("{} frames", value("debug.life"))},
                     {"irradiance", text_of({value("debug.irradiance.R"), value("debug.irradiance.G"), value("debug.irradiance.B")})}};
    } else cell.rows = {{"cell", "none"}};
    out.push_back(std::move(cell));
    if (!reservoir_) return out;
    const shared::PackedReservoir kept = reservoir_.mapped_as<shared::PackedReservoir>().front();
    constexpr std::array<const char*, 8> kKinds = {"nothing", "a light's point", "the sky's direction", "a glowing triangle", "out of the scene", "a lit point", "a point with radiosity", "?"};
    const uint32_t kind = kept.point.bits >> 24 & 7u;
    PixelReport::Section reservoir{"reservoir", {{"sample", kKinds[kind]}, {"W", fmt::format("{:.4g}", kept.weight)}, {"confidence", fmt::format("{}", kept.point.bits >> 16 & 255u)}}};
    if (kind == shared::kSampleLight || kind == shared::kSampleSky) reservoir.rows.emplace_back("of", scene.emitter_text(kept.point.reference));
    else if (kind != shared::kSampleNone && kind != shared::kSampleOutside) reservoir.rows.emplace_back("on", scene.instance_text(kept.point.reference));
    out.push_back(std::move(reservoir));
    return out;
}

}  // namespace parhelion
