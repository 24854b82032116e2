// What a path carries from one vertex to the next.
#ifndef PARHELION_SCENE_PATH_STATE_GLSL
#define PARHELION_SCENE_PATH_STATE_GLSL
#include "lib/bsdf.glsl"
#include "lib/hash.glsl"
#include "lib/ray_cone.glsl"
#include "scene/media.glsl"
#include "scene/path_class.glsl"
#include "scene/ray.glsl"
#include "shared/view.h"

// Names one sample of one pixel: key of all its random numbers.
struct PathKey {
    uvec2 pixel;
    uint sample_index;
    uint seed;
};
uint alpha_key(PathKey key, uint bounce, uint ray_kind) { return hash_ray(key.pixel, key.sample_index, key.seed, bounce, ray_kind); }

struct PathState {
    Ray ray;
    vec3 throughput;
    float pdf;             // of the last BSDF sample per solid angle; < 0: no light sample could have found this ray (camera, mirrors)
    float travelled;       // metres from the last scattering to the ray's origin: more than 0 behind panes
    float radiance_scale;  // what refraction has done to the throughput, which is no loss and does not count for roulette
    PathClass path_class;
    RayCone cone;          // how finely textures are read; of the ray
    MediumStack media;     // volumes around the ray
};

// The firefly clamp (an option, biased): the share of a contribution that is kept, so that light is dimmed, not recoloured.
float firefly_share(ViewData view, uint bounce, vec3 value) {
    if (view.firefly_clamp <= 0.0 || bounce == 0u) return 1.0;
    return min(1.0, view.firefly_clamp / max(luminance(value), 1e-30));
}
#endif
