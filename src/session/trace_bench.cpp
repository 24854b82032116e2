#include "session/trace_bench.h"

#include <algorithm>
#include <cstdlib>

#include <nlohmann/json.hpp>

#include "base/log.h"
#include "base/platform.h"
#include "scene/load.h"
#include "session/bench.h"
#include "session/results.h"
#include "session/scene_setup.h"

namespace parhelion {

using Json = nlohmann::ordered_json;

namespace {

struct RoomCase {
    std::string_view name, scene;
    uint64_t triangles;
};
constexpr RoomCase kRooms[] = {
    {"room-s", "builtin:room", 10'368},
    {"room-m", "builtin:room", 249'600},
    {"room-l", "builtin:room", 1'997'568},
    {"room-s-instanced", "builtin:room-instanced", 10'368},
    {"room-m-instanced", "builtin:room-instanced", 249'600},
    {"room-l-instanced", "builtin:room-instanced", 1'997'568},
};

LoadedScene load_case(const std::string& name) {
    for (const RoomCase& room : kRooms)
        if (room.name == name) return load_scene(std::string(room.scene), {.builtin = {.triangles = room.triangles}});
    return load_scene(name);
}

constexpr std::pair<NodeLayout, std::string_view> kLayouts[] = {{NodeLayout::Binary, "binary"}, {NodeLayout::Four, "four"}, {NodeLayout::Compact, "compact"}};

// The scene on the device, once for the driver's structures and once for each layout of our own.
struct SceneOnDevice {
    std::vector<std::unique_ptr<SceneGpu>> scenes;
    std::vector<Tracer> tracers;

    const SceneGpu& add(const gpu::DevicePtr& device, const Scene& scene, const SceneGpuOptions& options) {
        scenes.push_back(std::make_unique<SceneGpu>(device, options));
        Frame frame(device);
        scenes.back()->sync(scene);
        scenes.back()->finish(frame);
        frame.run();
        return *scenes.back();
    }
};

SceneOnDevice bring_in(const gpu::DevicePtr& device, const Scene& scene, const TraceBenchOptions& options) {
    SceneOnDevice out;
    const SceneGpuOptions base{.culling = options.settings.culling == Culling::Gltf, .node_layout = options.settings.node_layout, .bvh_loop = options.settings.bvh_loop,
                               .proxy_ratio = options.settings.proxy_ratio, .proxy_error = options.settings.proxy_error};
    const SceneGpu* driver = nullptr;
    for (const gpu::TraceWay way : options.ways) {
        if (way != gpu::TraceWay::Compute) {
            SceneGpuOptions with_driver = base;
            with_driver.own_bvh = false;
            if (!driver) driver = &out.add(device, scene, with_driver);
            out.tracers.push_back({std::string(trace_way_name(way)), way, driver});
            continue;
        }
        SceneGpuOptions own = base;
        own.hardware = false;
        if (!options.each_layout) out.tracers.push_back({std::string(trace_way_name(way)), way, &out.add(device, scene, own)});
        for (const auto& [layout, name] : kLayouts) {
            own.node_layout = layout;
            if (options.each_layout) out.tracers.push_back({std::string(name), way, &out.add(device, scene, own)});
        }
    }
    return out;
}

uint64_t count_triangles(const Scene& scene) {
    uint64_t count = 0;
    for (const auto& [handle, instance] : scene.instances()) count += scene.get(instance.drawn_mesh()).triangle_count;
    return count;
}

TraceBenchScene measure_scene(const std::string& name, const TraceBenchOptions& options, const gpu::DevicePtr& device, const std::optional<OutsideTracer>& outside) {
    const LoadedScene loaded = load_case(name);
    const SceneOnDevice on_device = bring_in(device, loaded.scene, options);
    const RenderOptions view{.size = *options.size};
    std::string camera_name;
    const shared::Camera camera = shader_camera(choose_camera(loaded.scene, view, camera_name), static_cast<float>(view.size.width) / static_cast<float>(view.size.height));
    RayBench bench(device, on_device.tracers.front(), camera, loaded.scene.bounds(), view.size.width, view.size.height);
    const TraceOutside trace_outside = outside ? outside->build(loaded.scene) : TraceOutside{};
    TraceBenchScene result{.name = name, .triangles = count_triangles(loaded.scene), .instances = loaded.scene.instances().size()};
    for (const RayKind kind : kRayKinds) result.kinds.push_back(bench.measure(kind, on_device.tracers, trace_outside));
    return result;
}

}  // namespace

std::vector<std::string> trace_bench_scenes() {
    std::vector<std::string> names;
    for (const RoomCase& room : kRooms) names.emplace_back(room.name);
    return names;
}

TraceBenchOptions read_trace_bench_options(const OptionValues& values, const gpu::DeviceCaps& caps) {
    for (const char* other : {"--spp", "--baseline"})
        if (values.given(other)) throw Error(ErrorCode::Usage, "does not fit bench trace, which takes no samples", values.where(other), "leave it out");
    TraceBenchOptions options;
    options.scenes = values.given("--scene") ? values.texts("--scene") : trace_bench_scenes();
    for (const std::string& scene : values.texts("--also")) options.scenes.push_back(scene);
    if (values.given("--size")) options.size = parse_size(values.text("--size"), "--size");
    options.ways = bench_ways(values, caps);
    options.each_layout = values.flag("--layouts");
    for (const std::string& assignment : values.texts("--set")) apply_assignment(options.settings, assignment);
    return options;
}

TraceBenchReport run_trace_bench(const TraceBenchOptions& given, const gpu::DevicePtr& device, const std::optional<OutsideTracer>& outside,
                                 const std::function<void(const TraceBenchScene&)>& done) {
    TraceBenchOptions options = given;
    const gpu::DeviceCaps& caps = device->caps();
    if (!options.size) options.size = caps.type == gpu::DeviceType::Cpu ? Size2{480, 270} : Size2{1920, 1080};
    TraceBenchReport report{.device = caps.name, .driver = caps.driver, .size = *options.size, .cpu = caps.type == gpu::DeviceType::Cpu, .scenes = {}, .outside = outside ? outside->name : ""};
    for (const std::string& name : options.scenes) {
        if (platform::interrupt_requested() != platform::Interrupt::None) break;
        report.scenes.push_back(measure_scene(name, options, device, outside));
        done(report.scenes.back());
    }
    return report;
}

void check_agreement(const TraceBenchReport& report) {
    for (const TraceBenchScene& scene : report.scenes)
        for (const RayRates& kind : scene.kinds)
            for (const TracerRate& tracer : kind.tracers)
                if (const double share = 1 - (tracer.name.empty() ? kOutsideAgreement : kTraceAgreement); (1 - tracer.agreement) * double(kind.rays) > std::max(2.5, share * double(kind.rays) + 0.5))
                    throw Error(ErrorCode::Failed,
                                fmt::format("{} and {} differ on {:.4f} % of the {} rays", tracer.name.empty() ? report.outside : tracer.name, kind.tracers.front().name,
                                            (1 - tracer.agreement) * 100, ray_kind_name(kind.kind)),
                                escape_name(scene.name), "one of them finds wrong hits: its rates mean nothing");
}

int run_trace_bench_command(const OptionValues& values, const std::optional<OutsideTracer>& outside) {
    const std::string json = values.given("--json") ? values.text("--json") : "";
    check_json_target(json);
    const gpu::DevicePtr device = gpu::Device::open({.selector = values.given("--device") ? values.text("--device") : ""});
    const TraceBenchOptions options = read_trace_bench_options(values, device->caps());
    log(LogLevel::Info, "{} scenes on {}", options.scenes.size(), escape_name(device->caps().name));
    const TraceBenchReport report = run_trace_bench(options, device, outside, [](const TraceBenchScene& scene) {
        log(LogLevel::Info, "{}: {} triangles, {} instances", escape_name(scene.name), scene.triangles, scene.instances);
    });
    if (json != "-") print_result(trace_bench_table(report));
    write_json(json, trace_bench_json(report));
    check_agreement(report);
    const platform::Interrupt interrupt = platform::interrupt_requested();
    if (interrupt == platform::Interrupt::None) return EXIT_SUCCESS;
    return static_cast<int>(interrupt == platform::Interrupt::Terminated ? ErrorCode::Terminated : ErrorCode::Interrupted);
}

}  // namespace parhelion
