// Lists of slots, and how many invocations at once append to them.
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

// Each invocation with a bin below `bins` gets a number of its own from counter `first` + bin. Every invocation of the work group calls
// it. A subgroup asks the counter once; on GPUs, where subgroups come by the ten thousand, a work group does. The barriers of that make
// Generate three times as slow on a CPU device.
#ifdef FOR_GPU
shared uint bin_count[kClassCount], bin_first[kClassCount];

uint reserve(Control control, uint first, uint bin, uint bins) {
    const uint here = gl_LocalInvocationIndex;
    barrier();  // whoever still reads the numbers of the last call
    if (here < bins) bin_count[here] = 0u;
    barrier();
    uint number = 0u;
    for (uint b = 0u; b < bins; ++b) {
        const uvec4 ballot = subgroupBallot(bin == b);
        const uint count = subgroupBallotBitCount(ballot);
        if (count == 0u) continue;
        uint before = 0u;
        if (subgroupElect()) before = atomicAdd(bin_count[b], count);
        before = subgroupBroadcastFirst(before);
        if (bin == b) number = before + subgroupBallotExclusiveBitCount(ballot);
    }
    barrier();
    if (here < bins && bin_count[here] != 0u) bin_first[here] = atomicAdd(control.v.count[first + here], bin_count[here]);
    barrier();
    return bin < bins ? bin_first[bin] + number : kNone;
}
#else
uint reserve(Control control, uint first, uint bin, uint bins) {
    uint number = kNone;
    for (uint b = 0u; b < bins; ++b) {
        const uvec4 ballot = subgroupBallot(bin == b);
        const uint count = subgroupBallotBitCount(ballot);
        if (count == 0u) continue;
        uint before = 0u;
        if (subgroupElect()) before = atomicAdd(control.v.count[first + b], count);
        before = subgroupBroadcastFirst(before);
        if (bin == b) number = before + subgroupBallotExclusiveBitCount(ballot);
    }
    return number;
}
#endif

uint bin_if(bool wanted) { return wanted ? 0u : kNone; }

// True: the list has room for its entry number i; one that is lost is counted.
bool has_room(Control control, uint list, uint capacity, uint i) {
    if (i >= capacity) atomicAdd(control.v.overflow[list], 1u);
    return i < capacity;
}

// Appends the slots of the invocations that have a bin to list `first` + bin.
void list_append(Lists lists, Control control, uint first, uint bin, uint bins, uint slot) {
    const uint i = reserve(control, first, bin, bins);
    if (bin < bins && has_room(control, first + bin, control.v.slot_count, i)) lists.v[list_at(control, first + bin, i)] = slot;
}
#endif
