#pragma once
// What stays of a mesh's tree while its triangles move (shared/refit.h): made once, on the host, of the mesh at rest; the device then
// puts boxes around the triangles of each deformed form.
#include <span>
#include <vector>

#include "bvh/bvh.h"
#include "shared/refit.h"

namespace parhelion::bvh {

struct RefitPlan {
    std::vector<shared::RefitNode> nodes;
    std::vector<shared::RefitTriangle> triangles;
};

// The plan of nodes of this layout's width. Every triangle is in exactly one leaf, degenerate ones too: they may grow. All positions
// must be finite and within +-1e18. Throws Error beyond 2^31 triangles.
RefitPlan plan_refit(std::span<const BottomGeometry> geometries, Layout layout);

}  // namespace parhelion::bvh
