// Statistics of Shade: how many rays met what after how many scatterings, and asked for light there. FOR_GPU: summed up in the work group.
#ifndef PARHELION_WAVEFRONT_COUNTS_GLSL
#define PARHELION_WAVEFRONT_COUNTS_GLSL
#include "wavefront/lists.glsl"

#ifdef FOR_GPU
const uint kCounts = kCountedBounces * kClassesHere;  // the kernel's classes are numbered from 0
shared uint group_rays[kCounts], group_shadows[kCounts];

void begin_counts() {
    for (uint c = gl_LocalInvocationIndex; c < kCounts; c += kWavefrontGroup) group_rays[c] = group_shadows[c] = 0u;
    barrier();
}

void count_vertex(Control control, bool lives, uint bounce, uint class_here, bool asks) {
    const uint c = min(bounce, kCountedBounces - 1u) * kClassesHere + class_here;
    if (lives) atomicAdd(group_rays[c], 1u);
    if (asks) atomicAdd(group_shadows[c], 1u);
}

void end_counts(Control control, uint first_class) {
    barrier();
    for (uint c = gl_LocalInvocationIndex; c < kCounts; c += kWavefrontGroup) {
        if (group_rays[c] == 0u) continue;
        atomicAdd(control.v.rays[c / kClassesHere][first_class + c % kClassesHere], group_rays[c]);
        if (group_shadows[c] != 0u) atomicAdd(control.v.shadows[c / kClassesHere][first_class + c % kClassesHere], group_shadows[c]);
    }
}
#else
uint counted_bounce, counted_class;
bool counted_lives, counted_asks;

void begin_counts() {}

void count_vertex(Control control, bool lives, uint bounce, uint class_here, bool asks) {
    counted_lives = lives;
    counted_bounce = min(bounce, kCountedBounces - 1u);
    counted_class = class_here;
    counted_asks = asks;
}

// One atomic a subgroup for each pair of bounce and class in it.
void end_counts(Control control, uint first_class) {
    bool left = counted_lives;
    while (left) {
        const uint bounce = subgroupBroadcastFirst(counted_bounce), met = subgroupBroadcastFirst(counted_class);
        const bool same = counted_bounce == bounce && counted_class == met;
        const uint rays = subgroupBallotBitCount(subgroupBallot(same)), shadows = subgroupBallotBitCount(subgroupBallot(same && counted_asks));
        if (subgroupElect()) {
            atomicAdd(control.v.rays[bounce][first_class + met], rays);
            atomicAdd(control.v.shadows[bounce][first_class + met], shadows);
        }
        left = !same;
    }
}
#endif
#endif
