#include "frame/hazard.h"

namespace parhelion {

// Barriers are applied to a resource when it is next looked at, so a barrier costs nothing by itself.
HazardTracker::State& HazardTracker::current(const void* resource) {
    const auto [it, is_new] = states_.try_emplace(resource);
    State& state = it->second;
    if (is_new) state.next_barrier = barriers_.size();
    const auto apply = [](Pending& pending, const Barrier& barrier) {
        // Reads merged into one Pending are ordered only when the barrier covers all of them.
        const UseMask uncovered = pending.uses & ~barrier.before;
        if (pending.uses != 0 && (uncovered == 0 || (pending.ordered & barrier.before) != 0)) pending.ordered |= barrier.after;
    };
    for (; state.next_barrier < barriers_.size(); ++state.next_barrier) {
        apply(state.write, barriers_[state.next_barrier]);
        apply(state.reads, barriers_[state.next_barrier]);
    }
    return state;
}

Hazard HazardTracker::find(const Access& access) {
    const State& state = current(access.resource);
    const UseMask bit = use_bit(access.use);
    Hazard hazard;
    if (state.write.uses != 0 && (state.write.ordered & bit) == 0) hazard.before |= state.write.uses;
    if (gpu::use_writes(access.use) && state.reads.uses != 0 && (state.reads.ordered & bit) == 0) hazard.before |= state.reads.uses;
    return hazard;
}

void HazardTracker::add_accesses(std::span<const Access> accesses) {
    for (const Access& access : accesses)
        if (gpu::use_writes(access.use)) {
            State& state = current(access.resource);
            state.write = {};
            state.reads = {};
        }
    for (const Access& access : accesses) {
        State& state = current(access.resource);
        const UseMask bit = use_bit(access.use);
        if (gpu::use_writes(access.use)) {
            state.write.uses |= bit;
        } else if ((state.reads.uses & bit) == 0 || state.reads.ordered != 0) {
            // A new read is not covered by barriers before it: those count only for reads that came earlier, which a write
            // must still wait for; merging them keeps the answer on the safe side.
            state.reads.uses |= bit;
            state.reads.ordered = 0;
        }
    }
}

void HazardTracker::compact() {
    constexpr size_t kMaxBarriers = 1024;
    if (barriers_.size() < kMaxBarriers) return;
    for (auto& [resource, state] : states_) current(resource).next_barrier = 0;
    barriers_.clear();
}

}  // namespace parhelion
