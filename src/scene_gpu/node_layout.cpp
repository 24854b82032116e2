// Which layout of our own nodes a device gets.
#include "scene_gpu/state.h"

namespace parhelion {

// CPU devices like four children a node, which they test as one vector; GPUs two, whose loop needs the fewest registers.
bvh::Layout choose_node_layout(const gpu::DeviceCaps& caps, NodeLayout choice) {
    switch (choice) {
        case NodeLayout::Binary: return bvh::Layout::Binary;
        case NodeLayout::Four: return bvh::Layout::Four;
        case NodeLayout::Compact: return bvh::Layout::Compact;
        case NodeLayout::Auto: break;
    }
    return caps.type == gpu::DeviceType::Cpu ? bvh::Layout::Four : bvh::Layout::Binary;
}

}  // namespace parhelion
