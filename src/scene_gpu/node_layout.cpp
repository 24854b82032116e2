// Which layout of our own nodes a device gets, and which loop.
#include "scene_gpu/state.h"

namespace parhelion {

// A CPU device gathers what a vector of rays reads word by word: the smallest nodes are the fastest. GPUs are fastest with two
// children a node, whose loop needs the fewest registers.
bvh::Layout choose_node_layout(const gpu::DeviceCaps& caps, NodeLayout choice) {
    switch (choice) {
        case NodeLayout::Binary: return bvh::Layout::Binary;
        case NodeLayout::Four: return bvh::Layout::Four;
        case NodeLayout::Compact: return bvh::Layout::Compact;
        case NodeLayout::Auto: break;
    }
    return caps.type == gpu::DeviceType::Cpu ? bvh::Layout::Compact : bvh::Layout::Binary;
}

bool walks_in_rounds(const gpu::DeviceCaps& caps, BvhLoop choice) {
    return choice == BvhLoop::Auto ? caps.type != gpu::DeviceType::Cpu : choice == BvhLoop::Rounds;
}

}  // namespace parhelion
