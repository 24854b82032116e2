#pragma once
// How many rays a second a device traces when a pass does nothing else, by each way to trace, the same rays for all.
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "passes/bench/bench.h"
#include "scene/types.h"
#include "shared/hit.h"

namespace parhelion {

enum class RayKind { Primary, Diffuse, Shadow };  // pinhole; incoherent; any hit ends it
constexpr RayKind kRayKinds[] = {RayKind::Primary, RayKind::Diffuse, RayKind::Shadow};
std::string_view ray_kind_name(RayKind kind);

// A way to trace a scene that is complete on the device.
struct Tracer {
    std::string name;
    gpu::TraceWay way;
    const SceneGpu* scene;
};

// What a tracer outside this program makes of the same rays: one number a ray, of closest hits the distance or infinity, of shadow
// rays 0 where something is in the way, else infinity. Returns the core-seconds that tracing took.
using TraceOutside = std::function<double(std::span<const shared::DumpedRay> rays, bool any_hit, std::span<float> distances)>;

struct TracerRate {
    std::string name;
    double mrays_per_s = 0;  // millions a second; on a CPU device, and outside, a core-second
    double agreement = 1;  // share of the rays for which it says what the first tracer says
};

struct RayRates {
    RayKind kind = RayKind::Primary;
    uint64_t rays = 0, hits = 0;  // hits of the first tracer
    std::vector<TracerRate> tracers;  // in the order given; the outside one last
};

// The rays of one scene, made once.
class RayBench {
public:
    // Makes the rays by this tracer. `box`: where shadow rays end. Needs GPU timestamps: throws MissingFeature. A CPU device's rates
    // are counted in the processor time that this process used: what else the machine does counts little.
    RayBench(gpu::DevicePtr device, const Tracer& maker, const shared::Camera& camera, const Bounds& box, uint32_t width, uint32_t height);

    // Each tracer once to warm up (pipelines compile at the first dispatch), then all in turn, several times; the median counts.
    RayRates measure(RayKind kind, std::span<const Tracer> tracers, const TraceOutside& outside = {});

private:
    const gpu::Buffer& rays_of(RayKind kind) const;
    double trace(const Tracer& tracer, RayKind kind);
    std::vector<shared::Hit> read_hits(RayKind kind);

    gpu::DevicePtr device_;
    Frame frame_;
    passes::BenchRays rays_;
    gpu::Buffer hits_;
    std::vector<shared::DumpedRay> host_rays_;
    RayKind host_kind_ = RayKind::Primary;
};

// Two tracers say the same of a ray if both miss, or meet the same triangle, or at the same distance within a few roundings of the
// ray's origin and length: a ray through a shared edge meets either triangle.
bool same_hit(const shared::DumpedRay& ray, const shared::Hit& a, const shared::Hit& b);
bool same_distance(const shared::DumpedRay& ray, float a, float b);

}  // namespace parhelion
