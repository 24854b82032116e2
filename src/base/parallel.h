#pragma once
// Data-parallel loops on the host over all cores.
#include <cstddef>
#include <functional>

namespace parhelion {

// Calls body(begin, end) for disjoint pieces of [0, count), each at most `grain` long, from several threads; returns when all
// are done. The first exception thrown by a body is rethrown here. Results must not depend on the order.
void parallel_for(size_t count, size_t grain, const std::function<void(size_t begin, size_t end)>& body);

unsigned hardware_threads();

}  // namespace parhelion
