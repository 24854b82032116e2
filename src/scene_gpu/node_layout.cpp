// Which layout of our own nodes a device gets, and which loop.
#include "scene_gpu/state.h"

namespace parhelion {

bvh::Layout choose_node_layout(const gpu::DeviceCaps& caps, NodeLayout choice) {
    if (choice == NodeLayout::Auto) choice = gpu::device_class(caps).layout;
    return choice == NodeLayout::Binary ? bvh::Layout::Binary : choice == NodeLayout::Four ? bvh::Layout::Four : bvh::Layout::Compact;
}

bool walks_in_rounds(const gpu::DeviceCaps& caps, BvhLoop choice) {
    return choice == BvhLoop::Auto ? gpu::device_class(caps).walks_in_rounds : choice == BvhLoop::Rounds;
}

}  // namespace parhelion
