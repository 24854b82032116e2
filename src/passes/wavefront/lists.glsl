// Lists of slots. A work group appends with one atomic on the list's count: one a subgroup, thousands of them on one word, take longer
// than the kernels that list.
#ifndef PARHELION_WAVEFRONT_LISTS_GLSL
#define PARHELION_WAVEFRONT_LISTS_GLSL
#include "shared/scene.h"
#include "wavefront/state.glsl"
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Lists { uint v[]; };

// Place of a list in the array, and whether it fills it from the end; in order of kList...
const uint kListPlace[kListCount] = uint[](0u, 0u, 1u, 1u, 2u, 2u, 3u);
const bool kListFromEnd[kListCount] = bool[](false, false, false, true, false, true, false);

uint list_at(Control control, uint list, uint i) {
    const uint capacity = control.v.slot_count;
    return kListPlace[list] * capacity + (kListFromEnd[list] ? capacity - 1u - i : i);
}

const uint kMaxBins = kClassCount;
shared uint bin_count[kMaxBins], bin_first[kMaxBins];

// Counts the work group's invocations by bin (those beyond `bins` in none) into bin_count; returns how many of the same bin come
// before this one. Every invocation of the group calls it.
uint count_bins(uint bin, uint bins) {
    barrier();  // whoever still reads the counts of the last call
    if (gl_LocalInvocationIndex < bins) bin_count[gl_LocalInvocationIndex] = 0u;
    barrier();
    uint before = 0u;
    for (uint b = 0u; b < bins; ++b) {
        const uvec4 ballot = subgroupBallot(bin == b);
        const uint count = subgroupBallotBitCount(ballot);
        if (count == 0u) continue;
        uint first = 0u;
        if (subgroupElect()) first = atomicAdd(bin_count[b], count);
        first = subgroupBroadcastFirst(first);
        if (bin == b) before = first + subgroupBallotExclusiveBitCount(ballot);
    }
    barrier();
    return before;
}

// Room for `count` entries in a list, of which those beyond its capacity are lost and counted. By one invocation.
uint reserve(Control control, uint list, uint capacity, uint count) {
    if (count == 0u) return 0u;
    const uint first = atomicAdd(control.v.count[list], count);
    if (first + count > capacity) atomicAdd(control.v.overflow[list], first + count - max(first, capacity));
    return first;
}

// Appends the slots of the invocations that have a bin to the list of that number after `list`.
void list_append(Lists lists, Control control, uint list, uint bin, uint bins, uint slot) {
    const uint capacity = control.v.slot_count, before = count_bins(bin, bins);
    if (gl_LocalInvocationIndex < bins) bin_first[gl_LocalInvocationIndex] = reserve(control, list + gl_LocalInvocationIndex, capacity, bin_count[gl_LocalInvocationIndex]);
    barrier();
    if (bin >= bins) return;
    const uint i = bin_first[bin] + before;
    if (i < capacity) lists.v[list_at(control, list + bin, i)] = slot;
}

// The same for two bins and one list, in which the group's entries of the second come after those of the first.
void list_append_in_order(Lists lists, Control control, uint list, uint bin, uint slot) {
    const uint capacity = control.v.slot_count, before = count_bins(bin, 2u);
    if (gl_LocalInvocationIndex == 0u) bin_first[0] = reserve(control, list, capacity, bin_count[0] + bin_count[1]);
    barrier();
    if (bin >= 2u) return;
    const uint i = bin_first[0] + (bin == 1u ? bin_count[0] : 0u) + before;
    if (i < capacity) lists.v[list_at(control, list, i)] = slot;
}
#endif
