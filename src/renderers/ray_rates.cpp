#include "renderers/ray_rates.h"

#include <algorithm>
#include <cmath>
#include <ctime>

#include "base/error.h"

namespace parhelion {

namespace {

constexpr size_t kLeastRounds = 5, kMostRounds = 25;
constexpr double kTracerSeconds = 0.05;  // what the rounds of one tracer should take at least, together

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values.at(values.size() / 2);
}

template <class T>
std::vector<T> read_all(Frame& frame, const gpu::Buffer& buffer) {
    const gpu::Buffer copy = frame.read_back(buffer);
    frame.run();
    const auto bytes = copy.mapped_as<T>();
    return {bytes.begin(), bytes.end()};
}

bool is_miss(const shared::Hit& hit) { return hit.instance_bits == shared::kHitMiss; }

}  // namespace

std::string_view ray_kind_name(RayKind kind) { return kind == RayKind::Primary ? "primary" : kind == RayKind::Diffuse ? "diffuse" : "shadow"; }

bool same_distance(const shared::DumpedRay& ray, float a, float b) {
    if (std::isinf(a) || std::isinf(b)) return std::isinf(a) == std::isinf(b);
    constexpr float kRoundings = 64.0f * 0x1p-24f;
    const glm::vec3 origin = glm::abs(ray.origin_ws);
    return std::abs(a - b) <= kRoundings * std::max({origin.x, origin.y, origin.z, a, b});
}

bool same_hit(const shared::DumpedRay& ray, const shared::Hit& a, const shared::Hit& b) {
    if (is_miss(a) || is_miss(b)) return is_miss(a) == is_miss(b);
    if (a.instance_bits == b.instance_bits && a.geometry == b.geometry && a.primitive == b.primitive) return true;
    return same_distance(ray, a.t, b.t);
}

RayBench::RayBench(gpu::DevicePtr device, const Tracer& maker, const shared::Camera& camera, const Bounds& box, uint32_t width, uint32_t height)
    : device_(std::move(device)), frame_(device_) {
    if (device_->caps().timestamp_period_ns <= 0) throw Error(ErrorCode::MissingFeature, "the device has no timestamps", escape_name(device_->caps().name));
    const uint64_t count = uint64_t(width) * height, bytes = count * sizeof(shared::DumpedRay);
    rays_ = {.primary = gpu::Buffer(device_, "bench/primary", bytes),
             .diffuse = gpu::Buffer(device_, "bench/diffuse", bytes),
             .shadow = gpu::Buffer(device_, "bench/shadow", bytes),
             .width = width,
             .height = height};
    hits_ = gpu::Buffer(device_, "bench/hits", count * sizeof(shared::Hit));
    passes::make_bench_rays(frame_, *maker.scene, maker.way, camera, box.min, box.max, rays_);
    frame_.run();
}

const gpu::Buffer& RayBench::rays_of(RayKind kind) const {
    return kind == RayKind::Primary ? rays_.primary : kind == RayKind::Diffuse ? rays_.diffuse : rays_.shadow;
}

// Seconds of the pass, or core-seconds.
double RayBench::trace(const Tracer& tracer, RayKind kind) {
    const std::clock_t begin = std::clock();
    passes::trace_bench_rays(frame_, *tracer.scene, tracer.way, rays_of(kind), kind == RayKind::Shadow, hits_, rays_.width, rays_.height);
    frame_.run();
    if (device_->caps().type == gpu::DeviceType::Cpu) return double(std::clock() - begin) / CLOCKS_PER_SEC;
    for (const PassInfo& pass : frame_.passes())
        if (pass.name == "bench/trace_rays") return pass.gpu_ms * 1e-3;
    throw Error(ErrorCode::Failed, "the pass has no time", "bench/trace_rays");
}

// Shadow rays as hits at distance 0.
std::vector<shared::Hit> RayBench::read_hits(RayKind kind) {
    if (kind != RayKind::Shadow) return read_all<shared::Hit>(frame_, hits_);
    const std::vector<uint32_t> words = read_all<uint32_t>(frame_, hits_);
    std::vector<shared::Hit> hits(host_rays_.size());
    for (size_t i = 0; i < hits.size(); ++i) hits[i].instance_bits = words[i] != 0 ? shared::kHitMiss : 0u;
    return hits;
}

RayRates RayBench::measure(RayKind kind, std::span<const Tracer> tracers, const TraceOutside& outside) {
    if (host_rays_.empty() || host_kind_ != kind) host_rays_ = read_all<shared::DumpedRay>(frame_, rays_of(kind));
    host_kind_ = kind;
    const bool any_hit = kind == RayKind::Shadow;
    RayRates rates;
    rates.kind = kind;
    for (const shared::DumpedRay& ray : host_rays_) rates.rays += ray.reach != 0.0f;
    const double none = double(host_rays_.size() - rates.rays), count = double(std::max<uint64_t>(rates.rays, 1));

    std::vector<shared::Hit> first;
    double slowest = 0;
    for (const Tracer& tracer : tracers) {
        trace(tracer, kind);  // compiles
        slowest = std::max(slowest, trace(tracer, kind));
        std::vector<shared::Hit> hits = read_hits(kind);
        if (first.empty()) first = hits;
        double same = -none;
        for (size_t i = 0; i < hits.size(); ++i) same += same_hit(host_rays_[i], first[i], hits[i]);
        rates.tracers.push_back({.name = tracer.name, .mrays_per_s = 0, .agreement = same / count});
    }
    for (const shared::Hit& hit : first) rates.hits += !is_miss(hit);
    std::vector<float> distances(outside ? host_rays_.size() : 0);
    if (outside) {
        outside(host_rays_, any_hit, distances);
        double same = -none;
        for (size_t i = 0; i < distances.size(); ++i)
            same += host_rays_[i].reach == 0.0f || same_distance(host_rays_[i], is_miss(first[i]) ? INFINITY : first[i].t, distances[i]);
        rates.tracers.push_back({.name = {}, .mrays_per_s = 0, .agreement = same / count});
    }
    const size_t rounds = std::clamp(size_t(kTracerSeconds / std::max(slowest, 1e-6)), kLeastRounds, kMostRounds);
    std::vector<std::vector<double>> times(rates.tracers.size());
    for (size_t round = 0; round < rounds; ++round) {
        for (size_t i = 0; i < tracers.size(); ++i) times[i].push_back(trace(tracers[i], kind));
        if (outside) times.back().push_back(outside(host_rays_, any_hit, distances));
    }
    for (size_t i = 0; i < times.size(); ++i) rates.tracers[i].mrays_per_s = double(rates.rays) / std::max(median(times[i]), 1e-9) * 1e-6;
    return rates;
}

}  // namespace parhelion
