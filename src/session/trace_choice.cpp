#include "session/trace_choice.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/log.h"
#include "base/platform.h"
#include "session/scene_setup.h"
#include "session/trace_bench.h"

namespace parhelion {

using Json = nlohmann::ordered_json;

namespace {

constexpr gpu::TraceWay kDriverWays[] = {gpu::TraceWay::Pipeline, gpu::TraceWay::Query};
constexpr gpu::NodeLayout kOwnLayouts[] = {gpu::NodeLayout::Binary, gpu::NodeLayout::Four, gpu::NodeLayout::Compact};

std::optional<gpu::TraceWay> driver_way(std::string_view tracer) {
    for (const gpu::TraceWay way : kDriverWays)
        if (trace_way_name(way) == tracer) return way;
    return std::nullopt;
}
std::optional<gpu::NodeLayout> own_layout(std::string_view tracer) {
    for (const gpu::NodeLayout layout : kOwnLayouts)
        if (node_layout_name(layout) == tracer) return layout;
    return std::nullopt;
}

std::string device_key(const gpu::DeviceCaps& caps) {
    const std::string text = caps.name + "\n" + caps.driver;
    return fmt::format("{:016x}", hash_bytes(text.data(), text.size()));
}

std::string checksum(const Json& content) {
    const std::string text = content.dump();
    return fmt::format("{:016x}", hash_bytes(text.data(), text.size()));
}

Json content_of(const gpu::DeviceCaps& caps, const MeasuredTrace& measured) {
    Json rates = Json::object();
    for (const MeasuredTrace::Rate& rate : measured.rates) rates[rate.tracer] = rate.mrays_per_s;
    return {{"device", caps.name}, {"driver", caps.driver}, {"mrays_per_s", rates}};
}

// Throws what nlohmann::json throws, or a reason as text.
MeasuredTrace parse(const gpu::DeviceCaps& caps, const std::string& text) {
    const Json root = Json::parse(text);
    const Json& content = root.at("measured");
    if (root.at("schema") != 1 || root.at("checksum") != checksum(content)) throw std::runtime_error("its checksum is wrong");
    if (content.at("device") != caps.name || content.at("driver") != caps.driver) throw std::runtime_error("it belongs to another device or driver");
    MeasuredTrace out;
    for (const auto& [tracer, rate] : content.at("mrays_per_s").items()) {
        const auto way = driver_way(tracer);
        if ((!way && !own_layout(tracer)) || (way && !caps.supports(*way))) throw std::runtime_error("it names a way to trace that the device lacks");
        out.rates.push_back({tracer, rate.get<double>()});
        if (!(out.rates.back().mrays_per_s > 0) || !std::isfinite(out.rates.back().mrays_per_s)) throw std::runtime_error("a rate is not a positive number");
    }
    if (out.rates.empty()) throw std::runtime_error("it is empty");
    return out;
}

}  // namespace

gpu::TraceWay MeasuredTrace::way() const {
    const auto best = std::max_element(rates.begin(), rates.end(), [](const Rate& a, const Rate& b) { return a.mrays_per_s < b.mrays_per_s; });
    return best == rates.end() ? gpu::TraceWay::Compute : driver_way(best->tracer).value_or(gpu::TraceWay::Compute);
}

gpu::NodeLayout MeasuredTrace::layout() const {
    gpu::NodeLayout layout = gpu::NodeLayout::Auto;
    double best = 0;
    for (const Rate& rate : rates)
        if (const auto own = own_layout(rate.tracer); own && rate.mrays_per_s > best) layout = *own, best = rate.mrays_per_s;
    return layout;
}

std::filesystem::path measured_trace_file(const gpu::DeviceCaps& caps) {
    return platform::cache_folder() / "trace" / fmt::format("{:04x}-{:04x}-{}.json", caps.vendor_id, caps.device_id, device_key(caps));
}

std::optional<MeasuredTrace> read_measured_trace(const gpu::DeviceCaps& caps) {
    constexpr uint64_t kMaxBytes = 64 << 10;
    const std::filesystem::path file = measured_trace_file(caps);
    std::error_code ignored;
    if (!std::filesystem::exists(file, ignored)) return std::nullopt;
    std::string flaw;
    try {
        return parse(caps, read_text_file(file, kMaxBytes));
    } catch (const nlohmann::json::exception&) {
        flaw = "it is not what devices --measure writes";
    } catch (const Error& error) {
        flaw = "it " + error.problem;
    } catch (const std::exception& error) {
        flaw = error.what();
    }
    log(LogLevel::Warn, "{}: {}; tracing as for devices of this class (parhelion devices --measure writes it anew)", escape_name(file.string()), flaw);
    return std::nullopt;
}

void store_measured_trace(const gpu::DeviceCaps& caps, const MeasuredTrace& measured) {
    const std::filesystem::path file = measured_trace_file(caps);
    std::error_code error;
    std::filesystem::create_directories(file.parent_path(), error);
    if (error)
        throw Error(ErrorCode::Failed, "cannot make this folder: " + error.message(), escape_name(file.parent_path().string()), "set PARHELION_CACHE_DIR to a folder that can be written");
    const Json content = content_of(caps, measured);
    write_text_file(file, Json{{"schema", 1}, {"measured", content}, {"checksum", checksum(content)}}.dump(2) + "\n");
}

TraceDecision decide_trace(const gpu::DeviceCaps& caps, TraceChoice choice, gpu::NodeLayout layout) {
    TraceDecision out{.way = choose_trace_way(caps, choice), .layout = layout, .source = choice == TraceChoice::Auto ? "table" : "option"};
    const bool asks_for_layout = out.layout == gpu::NodeLayout::Auto && (choice == TraceChoice::Auto || choice == TraceChoice::Compute);
    if (choice == TraceChoice::Auto || asks_for_layout)
        if (const auto measured = read_measured_trace(caps)) {
            if (choice == TraceChoice::Auto) out.way = measured->way(), out.source = "measured";
            if (asks_for_layout) out.layout = measured->layout();
        }
    if (out.layout == gpu::NodeLayout::Auto) out.layout = gpu::device_class(caps).layout;
    return out;
}

MeasuredTrace measure_tracing(const gpu::DevicePtr& device) {
    const gpu::DeviceCaps& caps = device->caps();
    TraceBenchOptions options{.scenes = {"room-m", "room-m-instanced"}, .ways = {}, .each_layout = true, .settings = {}};
    if (caps.type == gpu::DeviceType::Cpu) options.size = Size2{160, 90};
    for (const gpu::TraceWay way : kDriverWays)
        if (caps.supports(way)) options.ways.push_back(way);
    options.ways.push_back(gpu::TraceWay::Compute);
    const TraceBenchReport report = run_trace_bench(options, device, std::nullopt, [](const TraceBenchScene&) {});
    check_agreement(report);
    MeasuredTrace out;
    std::map<std::string, std::pair<double, int>> logs;  // sum, count
    for (const TraceBenchScene& scene : report.scenes)
        for (const RayRates& kind : scene.kinds)
            for (const TracerRate& tracer : kind.tracers) {
                auto& [sum, count] = logs[tracer.name];
                sum += std::log(tracer.mrays_per_s), ++count;
            }
    for (const auto& [name, entry] : logs) out.rates.push_back({name, std::exp(entry.first / entry.second)});
    return out;
}

}  // namespace parhelion
