#pragma once
// Reconstruction: one frame's few paths a pixel, and what earlier frames brought, into a clean picture. docs/reconstruction.md.
#include "passes/realtime/realtime.h"
#include "shared/reconstruction.h"

namespace parhelion::passes {

// What reconstruction gets of a frame, whatever body it has. Pixels count along rows from the top left; film positions are pixels, x to the
// right, y down, centres at .5. World space is right-handed, +Y up, metres. Light is linear Rec.709 in nits times `exposure`.
struct ReconstructionInput {
    // The cameras of this frame and of the last (ViewData::camera, camera_before) and this frame's jitter: pixel (i, j) looks through film
    // position (i + 0.5, j + 0.5) + jitter.
    const Film& film;
    const Film* picture = nullptr;  // whose film takes the picture, of as many pixels or more; null: `film` itself
    glm::vec2 jitter_px{0.0f};
    // gbuffer.identity: which surface, and its geometric normal towards the camera. gbuffer.summary: base colour, roughness, reflectance and
    // metallic, which demodulate (realtime/demodulate.glsl), and the shading normal. gbuffer.motion: where the surface was on the last frame's
    // film, minus where it is, without jitter; +infinity: nowhere. gbuffer.depth: reversed. All have a value at every pixel in every
    // frame, whatever lobe its path drew.
    const GBuffer& gbuffer;
    // Noisy light, divided by the surface's colours, and what is seen straight. Passes use `diffuse` and `specular` up: they hold what they
    // like afterwards.
    const Signals& signals;
    float exposure = 1.0f;
    bool cut = false;  // nothing of the last frame is in this one
};

// The input in planes of words, kInput... of shared/reconstruction.h: uint[kInputPlanes][pixels]. Before the passes below.
void show_input(Frame& frame, const ReconstructionInput& input, const gpu::Buffer& planes);

// Settings; ranges in session/render_settings.h.
struct ReconstructionOptions {
    uint32_t history = 32;       // frames that a history is worth at most
    uint32_t fast_history = 6;
    uint32_t steps = 5;          // of the spatial filter: it reaches 2^steps - 1 pixels
    float sigmas = 1.5f;         // deviations that the tones of neighbours may differ by
    float firefly = 1.0f;        // times the brightest neighbour's light; 0: fireflies stay
    float antilag = 3.25f;       // standard errors; 0: histories never shorten
    float clamp_width = 2.0f;    // deviations of the fast history; 0: no clamp
    bool virtual_motion = true;
    bool follow = true;          // what is seen through exact mirrors and panes stands in their place
    bool antialias = true;       // jitter and temporal anti-aliasing
    uint32_t picture_history = 16;
    float kernel = 0.25f;        // deviation of the reconstruction kernel: pixels of the frame in motion, 1.25 times those of the picture where it stands still
    float deviations = 1.35f;    // of the colours around that the picture's history may lie off; twice as many where it stands still
};

// What a frame leaves to the next: 40 bytes a rendered pixel, twice, and 4; 10 bytes a pixel of the picture, twice.
struct ReconstructionHistory {
    gpu::Buffer diffuse, specular;  // half4[pixels]: light, and the deviation of a frame's luminance
    gpu::Buffer state;              // uint[kStatePlanes][pixels]
    gpu::Buffer guide;              // uvec2[pixels] (reconstruction/surfaces.glsl)
    gpu::Buffer tiles;              // ChangeTile[]
    gpu::Image picture;             // RGBA16F: pre-exposed, and the frames that it is worth
    gpu::Image shown;               // RG8: the surfaces that it is made of (reconstruction/shown.glsl)
};
ReconstructionHistory make_reconstruction_history(const gpu::DevicePtr& device, gpu::Extent rendered, gpu::Extent picture);

struct ReconstructionPass {
    Frame& frame;
    const ReconstructionInput& input;
    const ReconstructionHistory& before;
    const ReconstructionHistory& now;
    const gpu::Buffer& normals;  // uint[pixels]: geometric
    const ReconstructionOptions& options;
    shared::ReconstructionFrame settings;
};
gpu::Buffer judge_changes(const ReconstructionPass& pass);  // ChangeVerdict[tiles], by the last frame's tiles
void accumulate_light(const ReconstructionPass& pass, const gpu::Buffer& verdicts);
void settle_history(const ReconstructionPass& pass);   // its result is in input.signals' diffuse and specular
// Step `index` of options.steps, the result being in before's light and in input.signals' by turns; the last step (with none, the only one)
// leaves the picture's colours. Returns where: half4[pixels].
const gpu::Buffer& filter_light(const ReconstructionPass& pass, uint32_t index);
void antialias(const ReconstructionPass& pass, const gpu::Buffer& colors, const gpu::Buffer& verdicts, const gpu::Sampler& sampler);

}  // namespace parhelion::passes
