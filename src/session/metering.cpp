#include "session/metering.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "session/film_state.h"

namespace parhelion {

double metered_ev(std::span<const float> luminances) {
    std::vector<float> lit;
    for (const float nits : luminances)
        if (nits > 0 && std::isfinite(nits)) lit.push_back(nits);
    if (lit.empty()) return 0;
    std::sort(lit.begin(), lit.end());
    const size_t cut = lit.size() / 20;
    double sum = 0;
    for (size_t i = cut; i < lit.size() - cut; ++i) sum += std::log2(double(lit[i]));
    const double average = sum / double(lit.size() - 2 * cut);
    constexpr double kIso = 100, kMeter = 12.5;
    return std::clamp(std::round((average + std::log2(kIso / kMeter)) * 100) / 100, -32.0, 32.0);
}

double meter_scene(const gpu::DevicePtr& device, Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const ViewDesc& view) {
    constexpr double kPixels = 2304;
    constexpr uint32_t kSamples = 16;
    const double aspect = double(view.width) / view.height;
    ViewDesc probe = view;
    probe.width = static_cast<uint32_t>(std::clamp(std::round(std::sqrt(kPixels * aspect)), 1.0, kPixels));
    probe.height = static_cast<uint32_t>(std::clamp(std::round(std::sqrt(kPixels / aspect)), 1.0, kPixels));
    probe.seed = 0;
    probe.aovs.clear();
    View small(device, probe);
    for (uint32_t sample = 0; sample < kSamples; ++sample) {
        record_reference(frame, scene, way, small, {0, probe.height, sample, 1}, sample + 1 == kSamples);
        frame.run();
    }
    const image::FilmSums film = make_film_sums(small.read_film(frame), {probe.width, probe.height}, {0, kSamples}, {});
    std::vector<float> luminances(film.pixel_count());
    for (size_t pixel = 0; pixel < luminances.size(); ++pixel) {
        const auto mean = [&](size_t channel) { return image::fixed_mean(film.sum(channel, pixel), kSamples); };
        luminances[pixel] = image::luminance(mean(0), mean(1), mean(2));
    }
    return metered_ev(luminances);
}

}  // namespace parhelion
