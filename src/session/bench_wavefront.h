#pragma once
// `parhelion bench wavefront`: its structures side by side with the reference.
#include "session/bench.h"

namespace parhelion {

// Of one scene, as `base` (its scene, size, samples and bounces): the reference by every way and in every place to shade, the wavefront by every
// way as it is by default, and by `full_way` with each of its options. Trace shares are measured where `timers` are.
std::vector<BenchCase> wavefront_bench_cases(const BenchCase& base, std::span<const gpu::TraceWay> ways, gpu::TraceWay full_way, bool timers);

std::string wavefront_variant(const WavefrontOptions& options);             // "each_bounce indirect classes"
std::vector<std::string> wavefront_assignments(const WavefrontOptions& options);  // of --set

// How many times as fast as the best of the reference's rows of the same scene and size, by GPU time where there is one; none: there are none.
std::optional<double> to_best_reference(const BenchRow& row, const std::vector<BenchRow>& rows);

std::string wavefront_bench_table(const std::vector<BenchRow>& rows);

}  // namespace parhelion
