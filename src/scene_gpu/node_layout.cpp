// Which layout of our own nodes a device gets, and which traversal.
#include "scene_gpu/state.h"

namespace parhelion {

// A CPU device gathers what a vector of rays reads word by word: the smallest nodes are the fastest. GPUs are fastest with four float
// boxes a node (docs/performance.md).
bvh::Layout choose_node_layout(const gpu::DeviceCaps& caps, NodeLayout choice) {
    switch (choice) {
        case NodeLayout::Binary: return bvh::Layout::Binary;
        case NodeLayout::Four: return bvh::Layout::Four;
        case NodeLayout::Compact: return bvh::Layout::Compact;
        case NodeLayout::Auto: break;
    }
    return caps.type == gpu::DeviceType::Cpu ? bvh::Layout::Compact : bvh::Layout::Four;
}

uint32_t traversal_variant(const gpu::DeviceCaps& caps, bvh::Layout layout, BvhLoop choice, bool plain) {
    constexpr uint32_t kNvidia = 0x10DE;
    const bool cpu = caps.type == gpu::DeviceType::Cpu, rounds = choice == BvhLoop::Auto ? !cpu : choice == BvhLoop::Rounds;
    return static_cast<uint32_t>(layout) | (rounds ? shared::kBvhRounds : 0u) | (cpu ? shared::kBvhPairs : 0u) | (caps.vendor_id == kNvidia ? shared::kBvhFused : 0u) |
           (plain ? shared::kBvhPlain : 0u);
}

}  // namespace parhelion
