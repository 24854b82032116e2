#pragma once
// The wavefront path tracer: the reference's samples drawn by a chain of small kernels over lists of paths. Document 003; Laine et al.
// 2013, "Megakernels Considered Harmful".
#include <algorithm>
#include <array>
#include <functional>
#include <optional>

#include "passes/wavefront/replay.h"
#include "renderers/slice.h"

namespace parhelion {

enum class ConnectWhen : uint32_t { EachBounce, Once };  // shadow rays: inside the bounce loop, or after as many bounces as memory allows
enum class WavefrontDispatch : uint32_t { Indirect, Full };

// Pictures do not depend on these.
struct WavefrontOptions {
    uint32_t slots = 0;  // paths at a time; 0: as fits devices of this class. Never more than the slice has
    ConnectWhen connect = ConnectWhen::Once;
    WavefrontDispatch dispatch = WavefrontDispatch::Indirect;
    bool classes = true;  // a kernel of Shade for each class of materials
    uint64_t memory_bytes = 512ull << 20;  // most that what waits for Connect may take; Connect runs early where it would be more
    uint64_t sample_bytes = 512ull << 20;  // most that a slice's finished samples may take
    uint32_t shadow_capacity = 0;  // tests: room in the list of shadow rays; 0: for all that can come
};
constexpr uint32_t kMaxWavefrontSlots = 1u << 22;

// What happened, by number of scatterings before the ray; the last row counts all later ones too.
struct WavefrontStats {
    std::array<std::array<uint64_t, shared::kClassCount>, shared::kCountedBounces> rays{}, shadows{};  // by what the ray met
    uint64_t iterations = 0;       // of the machine
    uint64_t slot_iterations = 0;  // rays that it could have traced in them
    uint32_t slots = 0, round_length = 0;
    uint64_t state_bytes = 0;      // of one slot

    uint64_t rays_at(size_t bounce) const;
    uint64_t shadows_at(size_t bounce) const;
};

// The machine: draws a slice in as many frames as it takes.
class Wavefront {
public:
    // Throws MissingFeature if the device has no subgroup ballots, a usage Error for slots beyond kMaxWavefrontSlots.
    Wavefront(gpu::DevicePtr device, const WavefrontOptions& options);

    // Makes the device memory for views like this one, which record() would make.
    void allocate(const SceneGpu& scene, const View& view);
    // Most pixel-samples of a slice of such a view, a whole row at least. So many fit WavefrontOptions::sample_bytes.
    uint64_t slice_paths(const View& view) const;
    // The slice to draw next; the one before must be finished.
    void start(const shared::Slice& slice);
    // Gives the running slice up: the film that it was drawn into must be cleared.
    void abandon() { slice_.reset(); }
    // Records some iterations of the running slice. Only records: no submit, no wait. The scene must be drawable.
    void record(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, View& view);
    // After that frame has run, in so many seconds: true if the slice is finished. Frames grow or shrink to about `target_seconds`.
    // Throws Error if a list overflowed: then samples are lost.
    bool advance(double seconds, double target_seconds = 0.06);
    // Adds the finished slice's samples to the film's running block. Only records.
    void finish(Frame& frame, const View& view);

    uint32_t slots() const { return options_.slots; }
    const WavefrontStats& stats() const { return stats_; }
    const passes::WavefrontState& state() const { return state_; }
    uint32_t rounds_per_frame = 1;  // a round: iterations from one Connect to the next
    // Called while a frame is recorded, after Extend and after Connect: to look at what they traced (renderers/replay.h).
    std::function<void(const passes::WavefrontPass&, passes::WavefrontTraced)> after_trace;

private:
    passes::WavefrontShape shape(const SceneGpu& scene, const View& view) const;
    void begin(const passes::WavefrontPass& pass);
    void record_round(passes::WavefrontPass pass);
    uint32_t slots_in_use() const { return static_cast<uint32_t>(std::min<uint64_t>(state_.shape.slots, paths_)); }
    uint64_t iterations_left(const shared::WavefrontControl& control) const;

    gpu::DevicePtr device_;
    WavefrontOptions options_;
    passes::WavefrontState state_;
    std::optional<shared::Slice> slice_;
    bool begun_ = false;
    uint64_t paths_ = 0;  // of the slice
    uint32_t pixels_ = 0;  // of the slice
    gpu::Buffer control_copy_;
    WavefrontStats stats_;
};

}  // namespace parhelion
