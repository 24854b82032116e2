#pragma once
// Passes of the wavefront path tracer: the kernels of document 003 over lists of slots. shared/wavefront.h describes the state.
#include "passes/reference/reference.h"
#include "shared/wavefront.h"

namespace parhelion::passes {

// How a machine is built; pictures do not depend on it. `slots` x `round_length` <= 2^32 - 1.
struct WavefrontShape {
    uint32_t slots = 0;         // paths at a time
    uint32_t round_length = 1;  // vertices of a path between two Connects: 1 is the document's first structure
    bool classes = true;        // a kernel of Shade for each class of materials, else one for all
    bool indirect = true;       // work sizes from the GPU, else every kernel runs over all slots and most invocations end at once
    bool extra = false;         // the scene has layered materials, or textures are read by ray cones
    bool split = false;         // light is kept by path class too
    bool firsts = false;        // what paths see first is kept
    uint64_t paths = 0;         // most of a slice

    bool operator==(const WavefrontShape&) const = default;
};

// Device memory of a machine, at most 200 bytes a slot with a round of one vertex (state_bytes), and 168 more where light is split.
struct WavefrontState {
    WavefrontShape shape;
    gpu::Buffer control;  // shared::WavefrontControl
    gpu::Buffer sizes;    // shared::WavefrontSize[kSizeCount]
    gpu::Buffer lists;    // uint[places][slots]
    gpu::Buffer status, rays, hits, paths, extras, slots;  // [slots]
    gpu::Buffer vertices, shadow_rays, shadow_list; // [round_length][slots]
    gpu::Buffer splits;      // [round_length + 1][slots]
    gpu::Buffer class_sums;  // [slots]
    gpu::Buffer samples, firsts, sample_classes;  // [paths]: what finished paths brought
};
WavefrontState make_wavefront_state(const gpu::DevicePtr& device, const WavefrontShape& shape);
uint64_t state_bytes(const WavefrontShape& shape);  // of one slot
uint64_t sample_bytes(const WavefrontShape& shape);  // of one path of a slice
uint32_t usual_slots(const gpu::DeviceCaps& caps);   // as suit devices of its class, in an eighth of its memory

// What kernels of an iteration have in common.
struct WavefrontPass {
    Frame& frame;
    const SceneGpu& scene;
    gpu::TraceWay way;
    const Film& film;
    const WavefrontState& state;
    bool ray_cones = false;
    uint32_t slots = 0;  // of the machine that are in use
    uint32_t round = 0;  // vertices of every slot since the last Connect
};

void begin_wavefront(const WavefrontPass& pass);
void prepare_wavefront(const WavefrontPass& pass, uint32_t steps);  // of shared/wavefront.h
void generate(const WavefrontPass& pass);
void extend(const WavefrontPass& pass);
void sort_hits(const WavefrontPass& pass);
void shade(const WavefrontPass& pass);  // one kernel, or one for each class that the scene has
void connect(const WavefrontPass& pass);  // with a second kernel for rays that meet panes
void finalize(const WavefrontPass& pass);
void deposit(Frame& frame, const WavefrontState& state, const Film& film, uint32_t pixels);  // of the slice: its samples into the film

}  // namespace parhelion::passes
