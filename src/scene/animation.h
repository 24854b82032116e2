#pragma once
// Animations over time: which of them play, and what a channel says at a moment.
#include <span>
#include <string_view>
#include <vector>

#include "scene/scene.h"

namespace parhelion {

// The value of a channel at `seconds` into `out` (channel.width numbers; a rotation is a unit quaternion x, y, z, w). Before its
// first key it has the first key's value, after the last the last's (glTF 2.0, 3.11); between keys appendix C holds: step, linear
// (rotations by slerp on the shorter way), or cubic Hermite splines (rotations are normalised).
void sample_channel(const AnimationChannel& channel, double seconds, std::span<float> out);

// The slot of what the channel moves: channels of one path and slot move the same.
uint32_t moved_slot(const AnimationChannel& channel);

// By name, else by index in slot order. Empty: every animation, in slot order, that moves no property of an object which one chosen
// before it moves. Throws a usage Error that lists the animations.
std::vector<Handle<Animation>> choose_animations(const Scene& scene, std::string_view name_or_index);

// Seconds until the last key of the last channel; 0 without channels.
float duration_of(const Animation& animation);

}  // namespace parhelion
