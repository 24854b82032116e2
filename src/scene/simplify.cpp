#include "scene/simplify.h"

#include <algorithm>

#include <meshoptimizer.h>

namespace parhelion {

namespace {

constexpr double kMostKept = 0.8;  // of the triangles: else the list is not worth its memory

static_assert(sizeof(glm::uvec3) == 3 * sizeof(unsigned int));

}  // namespace

SimplifiedTriangles simplify_triangles(const Primitive& primitive, const SimplifyLimits& limits) {
    const size_t count = primitive.triangles.size(), kept = static_cast<size_t>(double(limits.ratio) * double(count));
    if (count == 0 || double(kept) > kMostKept * double(count)) return {};
    const float* positions = &primitive.positions.front().x;
    const float extent = meshopt_simplifyScale(positions, primitive.positions.size(), sizeof(glm::vec3));
    if (!(extent > 0.0f)) return {};

    SimplifiedTriangles out{.triangles = std::vector<glm::uvec3>(count)};
    float error = 0.0f;
    const size_t indices = meshopt_simplify(&out.triangles.front().x, &primitive.triangles.front().x, 3 * count, positions, primitive.positions.size(), sizeof(glm::vec3), 3 * kept,
                                            limits.deviation / extent, meshopt_SimplifyLockBorder, &error);
    if (double(indices / 3) > kMostKept * double(count)) return {};
    out.triangles.resize(indices / 3);
    out.triangles.shrink_to_fit();
    out.deviation = error * extent;
    return out;
}

}  // namespace parhelion
