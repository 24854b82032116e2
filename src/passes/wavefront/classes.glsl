// Which kernel of Shade a hit is for.
#ifndef PARHELION_WAVEFRONT_CLASSES_GLSL
#define PARHELION_WAVEFRONT_CLASSES_GLSL
#include "scene/ray.glsl"
#include "scene/scene.glsl"
#include "shared/wavefront.h"

uint class_of(WavefrontHit hit) {
    if (hit.instance_bits == kHitMiss) return kClassMiss;
    const uint flags = scene_flags(hit.instance_bits & kHitInstanceMask, hit.geometry);
    if ((flags & kMaterialOnlyEmits) != 0u) return kClassEmitter;
    if ((flags & kMaterialTransmits) != 0u) return kClassTransmissive;
    return (flags & (kMaterialCoated | kMaterialSheen)) != 0u ? kClassCoated : kClassPlain;
}
#endif
