#pragma once
// A view: one camera's picture of a scene, with its film. Several views may look at one scene.
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "frame/frame.h"
#include "passes/reference/reference.h"
#include "shared/view.h"

namespace parhelion {

enum class SamplerKind : uint32_t { Owen, Cranley, Pcg, White };
enum class PixelFilter : uint32_t { Box, Point };
enum class SpawnOffset : uint32_t { ErrorBounds, Integer };  // how rays leave surfaces: shaders/lib/geometry.glsl
enum class TextureLod : uint32_t { Full, Cone };  // the finest level everywhere; by ray cones (alpha tests and light samples at the finest)

enum class ShadeIn : uint32_t { Raygen, ClosestHit };  // where the pipeline way shades the vertices of paths

// A group of film channels, by name: "beauty", "albedo", "path.direct_diffuse", ...
struct FilmGroup {
    std::string_view name;
    uint32_t group;                              // shared::kFilm...
    std::vector<std::string_view> channels;      // suffixes: R G B, X Y Z, or one empty
    std::string_view aov = name;                 // that it is kept for
};
std::span<const FilmGroup> film_groups();  // in order of shared::kFilm...

// A plane of what is under the pixel's centre (passes::Film::first_hits), in order of shared::kFirstHit...
struct FirstHitPlane {
    std::string_view channel;  // "depth", "ids.instance", ...
    std::string_view aov;      // that it belongs to
    bool whole;                // whole numbers, else floats
};
std::span<const FirstHitPlane> first_hit_planes();

std::vector<std::string_view> aov_names();  // all that a view may be asked for

struct ViewDesc {
    uint32_t width = 1280, height = 720;
    shared::Camera camera{};
    std::optional<shared::Camera> camera_at_close;  // where it stands when its shutter closes; none: it is still
    uint32_t seed = 0;
    uint32_t max_bounces = 16;  // scatterings of a path; 0xFFFFFFFF: unlimited
    SamplerKind sampler = SamplerKind::Owen;
    PixelFilter filter = PixelFilter::Box;
    uint32_t roulette_start = 2;
    uint32_t light_sampling = 0;  // 0: MIS; 1: light sampling only; 2: BSDF sampling only
    TextureLod texture_lod = TextureLod::Full;
    ShadeIn shade_in = ShadeIn::Raygen;
    bool energy_compensation = true;  // what microfacets scatter more than once is not lost
    bool normal_correction = true;    // shading normals are bent so that reflections leave the surface
    SpawnOffset spawn_offset = SpawnOffset::ErrorBounds;
    float firefly_clamp = 0.0f;       // nits that one contribution after the first scattering may add; 0: no limit
    std::vector<std::string> aovs;  // besides the beauty: aov_names(), "path.*"
};

// A plane of what is under the pixels' centres, as read back.
struct FirstHitLayer {
    const FirstHitPlane* plane = nullptr;
    std::vector<uint32_t> words = {};
};

// The film's exact sums as read back: limb l of channel c of pixel p is limbs[(3 c + l) * width * height + p].
struct FilmReadback {
    std::vector<std::string> channels = {};  // "R", "G", "B", "albedo.R", ...
    std::vector<uint32_t> limbs = {};
    std::vector<FirstHitLayer> first_hits = {};
};

struct RowRange {
    uint32_t first = 0, count = 0;
};

struct RayCounts {
    uint64_t path = 0, shadow = 0;
};

class View {
public:
    // Throws a usage Error for an AOV that does not exist (lists those that do), and for more pixels and channels than a film holds.
    View(gpu::DevicePtr device, const ViewDesc& desc);

    const ViewDesc& desc() const { return desc_; }
    const passes::Film& film() const { return film_; }
    const std::vector<std::string>& channels() const { return channels_; }
    // Channels and first-hit planes of its film, without values.
    FilmReadback film_layout() const;

    // The camera of the coming frames, and where it stands when its shutter closes (none: it is still); the one until now becomes the
    // previous one. Clears the film, unless it is to go on.
    void set_camera(const shared::Camera& camera, const std::optional<shared::Camera>& at_close = {}, bool keep_film = false);
    // Of the coming frames, for PixelFilter::Point: where rays go through pixels, in pixels from their centres.
    void set_jitter(glm::vec2 jitter_px);
    glm::vec2 jitter() const { return data_.jitter; }
    const shared::ViewData& data() const { return data_; }
    // The frame is drawn: what comes is another one, in which the camera stands where it stood, unless it is set anew.
    void end_frame();
    // Uploads what changed and clears the film where that was asked for; the first passes of a frame.
    void prepare(Frame& frame);
    void clear_film() { clear_ = true, accumulation_.samples = 0, first_hit_rows_ = 0; }
    // The rows before `end` whose first hits have not been taken since the film was cleared, none where the view keeps no first hits.
    // They count as taken from now on.
    RowRange take_first_hit_rows(uint32_t end);
    // What a Renderer has drawn into the film: so many samples of one version of the scene (SceneGpu::version).
    struct Accumulation {
        uint64_t samples = 0, scene_version = 0;
    };
    Accumulation& accumulation() { return accumulation_; }
    // Continues from the film of an earlier run (--resume), with the next prepare().
    void restore_film(FilmReadback film);

    // Ends the running block where needed is the renderer's affair; this reads the exact sums and the first hits.
    FilmReadback read_film(Frame& frame) const;
    // Rays traced since the film was cleared.
    RayCounts read_rays(Frame& frame) const;

private:
    void place_camera();
    uint64_t first_hit_offset(const FirstHitPlane& plane) const;  // bytes

    gpu::DevicePtr device_;
    ViewDesc desc_;
    passes::Film film_;
    shared::ViewData data_{};
    std::vector<std::string> channels_;
    std::vector<const FirstHitPlane*> first_hit_planes_;  // that are kept
    uint32_t first_hit_rows_ = 0;                         // taken
    FilmReadback restored_;
    Accumulation accumulation_;
    bool upload_ = true, clear_ = true;
};

}  // namespace parhelion
