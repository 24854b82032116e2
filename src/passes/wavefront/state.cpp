// The wavefront's device memory, and the two kernels that keep its books.
#include <algorithm>

#include "gpu/device_class.h"
#include "passes/wavefront/wavefront.h"

namespace parhelion::passes {

namespace {

// Places of the lists' array (wavefront/lists.glsl): rays, then the classes.
uint32_t list_places(const WavefrontShape& shape) { return shape.classes ? 4 : 1; }

struct BeginPush {
    uint64_t control, status, slots, vertices, class_sums;
    uint32_t round_length;
};
struct PreparePush {
    uint64_t control, sizes, rays;
    uint32_t steps, tracing_group, row;
};

constexpr uint32_t kTracingGroup = 64;  // scene/trace.glsl
constexpr uint32_t kRowGroups = 1 << 15;  // below the 65,535 that every device takes

}  // namespace

uint64_t state_bytes(const WavefrontShape& shape) {
    const uint64_t round = shape.round_length;
    return sizeof(shared::WavefrontRay) + sizeof(shared::WavefrontHit) + sizeof(shared::WavefrontPath) + sizeof(shared::WavefrontSlot) +
           (shape.extra ? sizeof(shared::WavefrontExtra) : 0) + (1 + list_places(shape)) * sizeof(uint32_t) +
           round * (sizeof(shared::WavefrontVertex) + sizeof(shared::WavefrontShadowRay) + sizeof(uint32_t)) +
           (shape.split ? (round + 1) * sizeof(shared::WavefrontSplit) + sizeof(shared::WavefrontClassSums) : 0);
}

uint64_t sample_bytes(const WavefrontShape& shape) {
    return sizeof(glm::vec3) + (shape.firsts ? sizeof(shared::WavefrontFirst) : 0) + (shape.split ? sizeof(shared::WavefrontClassSums) : 0);
}

uint32_t usual_slots(const gpu::DeviceCaps& caps) {
    constexpr uint64_t kSlotBytes = 300, kShare = 8;  // with all that a slot may hold
    return static_cast<uint32_t>(std::clamp<uint64_t>(caps.memory_bytes / (kShare * kSlotBytes), 1, gpu::device_class(caps).wavefront_slots));
}

WavefrontState make_wavefront_state(const gpu::DevicePtr& device, const WavefrontShape& shape) {
    const uint64_t slots = shape.slots, vertices = slots * shape.round_length;
    const auto buffer = [&](const char* name, uint64_t count, uint64_t bytes) {
        return gpu::Buffer(device, std::string("wavefront/") + name, std::max<uint64_t>(count, 1) * bytes);
    };
    return {.shape = shape,
            .control = buffer("control", 1, sizeof(shared::WavefrontControl)),
            .sizes = buffer("sizes", shared::kSizeCount, sizeof(shared::WavefrontSize)),
            .lists = buffer("lists", list_places(shape) * slots, sizeof(uint32_t)),
            .status = buffer("status", slots, sizeof(uint32_t)),
            .rays = buffer("rays", slots, sizeof(shared::WavefrontRay)),
            .hits = buffer("hits", slots, sizeof(shared::WavefrontHit)),
            .paths = buffer("paths", slots, sizeof(shared::WavefrontPath)),
            .extras = buffer("extras", shape.extra ? slots : 0, sizeof(shared::WavefrontExtra)),
            .slots = buffer("slots", slots, sizeof(shared::WavefrontSlot)),
            .vertices = buffer("vertices", vertices, sizeof(shared::WavefrontVertex)),
            .shadow_rays = buffer("shadow_rays", vertices, sizeof(shared::WavefrontShadowRay)),
            .shadow_list = buffer("shadow_list", vertices, sizeof(uint32_t)),
            .splits = buffer("splits", shape.split ? vertices + slots : 0, sizeof(shared::WavefrontSplit)),
            .class_sums = buffer("class_sums", shape.split ? slots : 0, sizeof(shared::WavefrontClassSums)),
            .samples = buffer("samples", shape.paths, sizeof(glm::vec3)),
            .firsts = buffer("firsts", shape.firsts ? shape.paths : 0, sizeof(shared::WavefrontFirst)),
            .sample_classes = buffer("sample_classes", shape.split ? shape.paths : 0, sizeof(shared::WavefrontClassSums))};
}

void begin_wavefront(const WavefrontPass& pass) {
    const WavefrontState& state = pass.state;
    pass.frame.compute("wavefront/begin")
        .read_write("control", state.control)
        .read_write("status", state.status)
        .read_write("slots", state.slots)
        .read_write("vertices", state.vertices)
        .read_write("class_sums", state.class_sums)
        .push(BeginPush{.round_length = state.shape.round_length})
        .over(pass.slots);
}

void prepare_wavefront(const WavefrontPass& pass, uint32_t steps) {
    const uint32_t tracing_group = pass.way == gpu::TraceWay::Pipeline ? 1 : kTracingGroup;
    pass.frame.compute("wavefront/prepare")
        .read_write("control", pass.state.control)
        .write("sizes", pass.state.sizes)
        .read_write("rays", pass.film.rays)
        .push(PreparePush{.steps = steps, .tracing_group = tracing_group, .row = kRowGroups})
        .over(1);
}

}  // namespace parhelion::passes
