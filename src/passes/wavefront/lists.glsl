// Lists of slots, appended to with one atomic a subgroup.
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

// The place of a new entry of a list, kNone where none is wanted or there is no room. Every invocation of the subgroup calls it.
uint reserve(Control control, uint list, uint capacity, bool wanted) {
    const uvec4 ballot = subgroupBallot(wanted);
    const uint count = subgroupBallotBitCount(ballot);
    uint first = 0u;
    if (subgroupElect() && count != 0u) {
        first = atomicAdd(control.v.count[list], count);
        if (first + count > capacity) atomicAdd(control.v.overflow[list], first + count - max(first, capacity));
    }
    const uint i = subgroupBroadcastFirst(first) + subgroupBallotExclusiveBitCount(ballot);
    return wanted && i < capacity ? i : kNone;
}

void list_append(Lists lists, Control control, uint list, bool wanted, uint slot) {
    const uint i = reserve(control, list, control.v.slot_count, wanted);
    if (i != kNone) lists.v[list_at(control, list, i)] = slot;
}
#endif
