#pragma once
// The tree over instances, which is made anew in frames in which they have moved far: a millisecond for ten thousand on one thread,
// where build_wide_tree() takes several, for a few percent more expected work of a ray.
#include "bvh/wide_tree.h"

namespace parhelion::bvh {

// Parents come before their children. `parts`: where subtrees begin that know nothing of each other, one after the other up to the last
// node; those before the first part are above them all.
struct TopTree : WideTree {
    std::vector<uint32_t> parts;
};

// One box a leaf; boxes that are empty are in none. At most max_depth levels of nodes; needs boxes.size() <= width^max_depth. The
// result depends on the boxes alone, not on the number of threads.
TopTree build_top_tree(std::span<const Box> boxes, uint32_t width, uint32_t max_depth);

}  // namespace parhelion::bvh
