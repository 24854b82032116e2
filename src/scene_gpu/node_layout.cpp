// Which layout of our own nodes a device gets, and which traversal.
#include "scene_gpu/state.h"

namespace parhelion {

bvh::Layout choose_node_layout(const gpu::DeviceCaps& caps, NodeLayout choice) {
    if (choice == NodeLayout::Auto) choice = gpu::device_class(caps).layout;
    return choice == NodeLayout::Binary ? bvh::Layout::Binary : choice == NodeLayout::Four ? bvh::Layout::Four : bvh::Layout::Compact;
}

uint32_t traversal_variant(const gpu::DeviceCaps& caps, bvh::Layout layout, BvhLoop choice, bool plain) {
    constexpr uint32_t kNvidia = 0x10DE;
    const bool cpu = caps.type == gpu::DeviceType::Cpu, rounds = choice == BvhLoop::Auto ? gpu::device_class(caps).walks_in_rounds : choice == BvhLoop::Rounds;
    return static_cast<uint32_t>(layout) | (rounds ? shared::kBvhRounds : 0u) | (cpu ? shared::kBvhPairs : 0u) | (caps.vendor_id == kNvidia ? shared::kBvhFused : 0u) |
           (plain ? shared::kBvhPlain : 0u);
}

}  // namespace parhelion
