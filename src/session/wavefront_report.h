#pragma once
// What the wavefront did, as JSON and as a table. docs/wavefront.md says how to read it.
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "renderers/wavefront.h"

namespace parhelion {

struct WavefrontReport {
    WavefrontOptions options;
    WavefrontStats stats;
    bool classes = false;  // a kernel of Shade for each class: options.classes, or what Auto became

    // Share of the rays that the machine could have traced; of the rays after so many scatterings alone. 0 before anything was drawn.
    double occupancy() const;
    double occupancy(size_t bounce) const;
    size_t bounce_count() const;  // rows of the statistics: up to the last one with a ray
};

std::string_view connect_name(ConnectWhen when);           // as wavefront.connect takes them
std::string_view dispatch_name(WavefrontDispatch dispatch);  // as wavefront.dispatch does

nlohmann::ordered_json wavefront_json(const WavefrontReport& report);
std::string wavefront_line(const WavefrontReport& report);   // how it was built and how full it was
std::string wavefront_table(const WavefrontReport& report);  // that, and a row a bounce

}  // namespace parhelion
