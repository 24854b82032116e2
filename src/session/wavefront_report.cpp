#include "session/wavefront_report.h"

#include <nlohmann/json.hpp>

#include "base/error.h"

namespace parhelion {

using Json = nlohmann::ordered_json;

namespace {

constexpr std::string_view kClassNames[shared::kClassCount] = {"miss", "emitter", "plain", "coated", "transmissive"};  // in order of kClass...

double share(uint64_t part, uint64_t whole) { return whole != 0 ? double(part) / double(whole) : 0; }

Json by_class(const std::array<uint64_t, shared::kClassCount>& counts) {
    Json out = Json::object();
    for (size_t c = 0; c < shared::kClassCount; ++c) out[kClassNames[c]] = counts[c];
    return out;
}

// The last row of the statistics counts all later bounces too.
std::string bounce_label(size_t bounce) { return fmt::format("{}{}", bounce, bounce + 1 == shared::kCountedBounces ? "+" : ""); }

}  // namespace

size_t WavefrontReport::bounce_count() const {
    size_t count = shared::kCountedBounces;
    while (count > 0 && stats.rays_at(count - 1) == 0) --count;
    return count;
}

double WavefrontReport::occupancy(size_t bounce) const { return share(stats.rays_at(bounce), stats.slot_iterations); }

double WavefrontReport::occupancy() const {
    uint64_t rays = 0;
    for (size_t bounce = 0; bounce < shared::kCountedBounces; ++bounce) rays += stats.rays_at(bounce);
    return share(rays, stats.slot_iterations);
}

std::string_view connect_name(ConnectWhen when) { return when == ConnectWhen::Once ? "once" : "each_bounce"; }
std::string_view dispatch_name(WavefrontDispatch dispatch) { return dispatch == WavefrontDispatch::Full ? "full" : "indirect"; }

Json wavefront_json(const WavefrontReport& report) {
    const WavefrontStats& stats = report.stats;
    Json bounces = Json::array();
    for (size_t bounce = 0; bounce < report.bounce_count(); ++bounce)
        bounces.push_back({{"bounce", bounce},
                           {"and_later", bounce + 1 == shared::kCountedBounces},
                           {"rays", stats.rays_at(bounce)},
                           {"misses", stats.rays[bounce][shared::kClassMiss]},
                           {"shadow_rays", stats.shadows_at(bounce)},
                           {"occupancy", report.occupancy(bounce)},
                           {"rays_by_class", by_class(stats.rays[bounce])},
                           {"shadow_rays_by_class", by_class(stats.shadows[bounce])}});
    return {{"connect", connect_name(report.options.connect)},
            {"dispatch", dispatch_name(report.options.dispatch)},
            {"classes", report.classes},
            {"memory_bytes", report.options.memory_bytes},
            {"slots", stats.slots},
            {"round_length", stats.round_length},
            {"state_bytes", stats.state_bytes},
            {"iterations", stats.iterations},
            {"occupancy", report.occupancy()},
            {"bounces", bounces}};
}

std::string wavefront_line(const WavefrontReport& report) {
    const WavefrontStats& stats = report.stats;
    const std::string rounds = report.options.connect == ConnectWhen::Once ? fmt::format(" (after {} bounces)", stats.round_length) : "";
    return fmt::format("{} slots of {} bytes, connect {}{}, dispatch {}, classes {}; {} iterations, in which {:.1f} % of the slots traced a ray", stats.slots, stats.state_bytes,
                       connect_name(report.options.connect), rounds, dispatch_name(report.options.dispatch), report.classes ? "on" : "off", stats.iterations,
                       100 * report.occupancy());
}

std::string wavefront_table(const WavefrontReport& report) {
    const WavefrontStats& stats = report.stats;
    std::string out = wavefront_line(report) + "\n";
    out += fmt::format("{:>6} {:>14} {:>10} {:>14}", "bounce", "rays", "of slots", "shadow rays");
    for (const std::string_view name : kClassNames) out += fmt::format(" {:>14}", name);
    out += '\n';
    for (size_t bounce = 0; bounce < report.bounce_count(); ++bounce) {
        out += fmt::format("{:>6} {:>14} {:>8.2f} % {:>14}", bounce_label(bounce), stats.rays_at(bounce), 100 * report.occupancy(bounce), stats.shadows_at(bounce));
        for (const uint64_t count : stats.rays[bounce]) out += fmt::format(" {:>14}", count);
        out += '\n';
    }
    return out;
}

}  // namespace parhelion
