// parhelion-bench-embree: `parhelion bench trace` with Intel's Embree beside the device's ways to trace, on the same rays. Built with
// -DPARHELION_EMBREE=ON where libembree-dev is installed; nothing else uses Embree.
//     parhelion-bench-embree [options of parhelion bench trace]
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <type_traits>
#include <vector>

#include <rtcore.h>

#include "base/error.h"
#include "base/log.h"
#include "base/parallel.h"
#include "base/platform.h"
#include "session/trace_bench.h"

namespace parhelion {

namespace {

template <auto Release>
struct Releaser {
    template <class T>
    void operator()(T* object) const {
        Release(object);
    }
};
using Device = std::unique_ptr<std::remove_pointer_t<RTCDevice>, Releaser<rtcReleaseDevice>>;
using EmbreeScene = std::unique_ptr<std::remove_pointer_t<RTCScene>, Releaser<rtcReleaseScene>>;

// As many as the CPU device works with (Mesa's LP_NUM_THREADS).
unsigned thread_count() {
    const char* limit = std::getenv("LP_NUM_THREADS");
    const int wanted = limit ? std::atoi(limit) : int(hardware_threads());
    return std::clamp(wanted, 1, int(hardware_threads()));
}

void attach(RTCDevice device, RTCScene scene, RTCGeometry geometry) {
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    if (const RTCError error = rtcGetDeviceError(device); error != RTC_ERROR_NONE)
        throw Error(ErrorCode::Failed, fmt::format("refuses a geometry (error {})", int(error)), "Embree");
}

EmbreeScene make_mesh(RTCDevice device, const Mesh& mesh) {
    EmbreeScene scene(rtcNewScene(device));
    for (const Primitive& primitive : mesh.primitives) {
        if (primitive.triangles.empty()) continue;
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        void* positions = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(glm::vec3), primitive.positions.size());
        std::memcpy(positions, primitive.positions.data(), primitive.positions.size() * sizeof(glm::vec3));
        void* triangles = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(glm::uvec3), primitive.triangles.size());
        std::memcpy(triangles, primitive.triangles.data(), primitive.triangles.size() * sizeof(glm::uvec3));
        attach(device, scene.get(), geometry);
    }
    rtcCommitScene(scene.get());
    return scene;
}

bool every_ray_sees(const Scene& scene) {
    for (const auto& [handle, material] : scene.materials())
        if (material.alpha_mode != AlphaMode::Opaque || !material.double_sided) return false;
    return true;
}

// Embree's defaults throughout: medium quality, no robust mode. A scene of one instance that stands at the origin is its mesh alone.
class Tracer {
public:
    explicit Tracer(const Scene& scene) : device_(rtcNewDevice(nullptr)) {
        if (!device_) throw Error(ErrorCode::Failed, "cannot make a device", "Embree");
        for (const auto& [handle, instance] : scene.instances()) {
            EmbreeScene& mesh = meshes_[instance.drawn_mesh().index];
            if (!mesh) mesh = make_mesh(device_.get(), scene.get(instance.drawn_mesh()));
            alone_ = scene.instances().size() == 1 && instance.place.world_from_object == glm::mat4(1.0f) ? mesh.get() : nullptr;
        }
        if (alone_) return;
        top_.reset(rtcNewScene(device_.get()));
        for (const auto& [handle, instance] : scene.instances()) {
            RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_INSTANCE);
            rtcSetGeometryInstancedScene(geometry, meshes_.at(instance.drawn_mesh().index).get());
            rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, &instance.place.world_from_object[0][0]);
            attach(device_.get(), top_.get(), geometry);
        }
        rtcCommitScene(top_.get());
    }

    // Core-seconds.
    double trace(std::span<const shared::DumpedRay> rays, bool any_hit, std::span<float> distances) const {
        const auto begin = std::clock();
        std::atomic<size_t> next = 0;
        constexpr size_t kGrain = 1024;
        const auto work = [&] {
            for (size_t from = next.fetch_add(kGrain); from < rays.size(); from = next.fetch_add(kGrain))
                for (size_t i = from; i < std::min(rays.size(), from + kGrain); ++i) distances[i] = any_hit ? occluded(rays[i]) : closest(rays[i]);
        };
        std::vector<std::jthread> workers;
        for (unsigned i = 1; i < thread_count(); ++i) workers.emplace_back(work);
        work();
        workers.clear();
        return double(std::clock() - begin) / CLOCKS_PER_SEC;
    }

private:
    static RTCRay to_embree(const shared::DumpedRay& ray) {
        RTCRay out{};
        out.org_x = ray.origin_ws.x, out.org_y = ray.origin_ws.y, out.org_z = ray.origin_ws.z;
        out.dir_x = ray.direction_ws.x, out.dir_y = ray.direction_ws.y, out.dir_z = ray.direction_ws.z;
        out.tfar = ray.reach;
        out.mask = 0xFFFFFFFFu;
        return out;
    }

    float closest(const shared::DumpedRay& ray) const {
        if (ray.reach == 0.0f) return INFINITY;
        RTCRayHit query{.ray = to_embree(ray), .hit = {}};
        query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
        rtcIntersect1(scene(), &query);
#else
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcIntersect1(scene(), &context, &query);
#endif
        return query.hit.geomID == RTC_INVALID_GEOMETRY_ID ? INFINITY : query.ray.tfar;
    }

    float occluded(const shared::DumpedRay& ray) const {
        if (ray.reach == 0.0f) return INFINITY;
        RTCRay query = to_embree(ray);
#if RTC_VERSION_MAJOR >= 4
        rtcOccluded1(scene(), &query);
#else
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcOccluded1(scene(), &context, &query);
#endif
        return query.tfar < 0.0f ? 0.0f : INFINITY;
    }

    RTCScene scene() const { return alone_ ? alone_ : top_.get(); }

    Device device_;
    std::map<uint32_t, EmbreeScene> meshes_;  // by the index of their handle
    EmbreeScene top_;
    RTCScene alone_ = nullptr;
};

TraceOutside build(const Scene& scene) {
    if (!every_ray_sees(scene)) return {};
    return [tracer = std::make_shared<Tracer>(scene)](std::span<const shared::DumpedRay> rays, bool any_hit, std::span<float> distances) {
        return tracer->trace(rays, any_hit, distances);
    };
}

int run(std::vector<std::string> words) {
    words.insert(words.begin(), "trace");
    try {
        const OptionValues values = parse_options(Command::Bench, words, [](const char* name) { return std::getenv(name); });
        check_options(values);
        return run_trace_bench_command(values, OutsideTracer{"Embree", build});
    } catch (const Error& error) {
        log_line(LogLevel::Error, error.line);
        return static_cast<int>(error.code);
    } catch (const std::exception& error) {
        log_line(LogLevel::Error, error.what());
        return EXIT_FAILURE;
    }
}

}  // namespace

}  // namespace parhelion

int main(int argc, char** argv) {
    parhelion::platform::install_interrupt_handlers();
    return parhelion::run({argv + (argc > 0 ? 1 : 0), argv + argc});
}
