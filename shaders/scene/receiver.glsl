// A pixel's surface as reservoirs see it: what receives light.
#ifndef PARHELION_SCENE_RECEIVER_GLSL
#define PARHELION_SCENE_RECEIVER_GLSL
#include "scene/begin_path.glsl"
#include "scene/previous.glsl"

// Lobes that are narrower than this (perceptual roughness) share no light that other lobes found: their paths are the pixel's own.
const float kRoughEnoughToShare = 0.4;

struct Receiver {
    Shading shading;
    PathState path;      // that arrives there from the camera
    bool rough;          // all its lobes may share
    float bsdf_share;    // samples of the BSDF for each light sample, for the weight of MIS
};

// Whether light at the surface is shared at all: what lies behind it is not.
bool may_share(Surface s) { return !kLayers || s.scattering.transmission == 0.0; }
bool is_rough(Surface s) {
    const float coat = kLayers && s.scattering.coat > 0.0 ? s.scattering.coat_roughness : 1.0;
    return min(s.scattering.roughness, coat) >= kRoughEnoughToShare;
}

// Of light that a lobe narrower than that cannot be trusted with: what is left.
BsdfValue shared_value(BsdfValue value, bool rough) { return BsdfValue(value.diffuse, rough ? value.specular : vec3(0.0), vec3(0.0)); }

// Points of triangles are told in steps of 2^-16 of their edges. From so near that few steps lie between, others would see them elsewhere than the path that found
// them did, and their geometry terms with that: nobody shares a point from there.
bool is_too_near(float squared_distance, float extent) {
    const float kLeast = 64.0 / 65536.0;
    return squared_distance <= kLeast * kLeast * extent * extent;
}

// Of a light sample that was chosen from so many candidates; 0: from none.
float bsdf_share(uint candidates) { return candidates == 0u ? 1.0 : 1.0 / float(candidates); }

Receiver make_receiver(ViewData view, PathState path, Surface s, float bsdf_share) {
    s.integer_offset = (view.flags & kViewIntegerOffset) != 0u;
    return Receiver(make_shading(view, path, s, MediumBoundary(path.media, true, s.scattering.ior)), path, is_rough(s), bsdf_share);
}

// By its identity in this frame (kNow), or in the last one (kBefore), by rows and camera of that.
Receiver receiver_at(ViewData view, PathKey key, uvec4 identity, float bsdf_share, uint moment) {
    uint instance = identity.x;
    if (moment == kBefore) {
        view.camera = view.camera_before;
        view.jitter = view.jitter_before;
        instance = instance_now(identity.x & kHitInstanceMask) | identity.x & ~kHitInstanceMask;
    }
    const PathState path = begin_path(view, key);
    return make_receiver(view, path, fetch_surface_at(Hit(instance, identity.y, identity.z, 0u, 0.0), path.ray, kNoCone, moment), bsdf_share);
}
#endif
