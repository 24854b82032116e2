// Which layout of our own nodes a device gets.
#include "scene_gpu/state.h"

namespace parhelion {

bvh::Layout choose_node_layout(const gpu::DeviceCaps& caps, NodeLayout choice) {
    if (choice == NodeLayout::Auto) choice = gpu::device_class(caps).layout;
    return choice == NodeLayout::Binary ? bvh::Layout::Binary : choice == NodeLayout::Four ? bvh::Layout::Four : bvh::Layout::Compact;
}

}  // namespace parhelion
