// What a path carries from one vertex to the next, and the classes into which its light is sorted (docs/path-space.md).
#ifndef PARHELION_SCENE_PATH_STATE_GLSL
#define PARHELION_SCENE_PATH_STATE_GLSL
#include "lib/bsdf.glsl"
#include "lib/hash.glsl"
#include "lib/ray_cone.glsl"
#include "scene/media.glsl"
#include "scene/ray.glsl"
#include "shared/view.h"

// Random numbers of alpha tests: which ray asks.
const uint kRayPath = 0u;
const uint kRayShadow = 1u;

// Names one sample of one pixel: key of all its random numbers.
struct PathKey {
    uvec2 pixel;
    uint sample_index;
    uint seed;
};
uint alpha_key(PathKey key, uint bounce, uint ray_kind) { return hash_ray(key.pixel, key.sample_index, key.seed, bounce, ray_kind); }

// How the path left the first surface. Its light is split by the shares of the lobes, whichever of them drew the direction.
struct PathClass {
    uint bounce;         // scatterings so far
    bool transmitted;    // the first of them went through the surface
    vec3 diffuse_share;  // of the throughput: what the first surface's diffuse lobe has; the specular one has the rest
};

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

// Radiance by path class; their sum is the beauty.
struct PathRadiance {
    vec3 emission, direct_diffuse, direct_specular, indirect_diffuse, indirect_specular, transmission;
};
PathRadiance make_path_radiance() { return PathRadiance(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0)); }
vec3 total(PathRadiance r) {
    return r.emission + r.direct_diffuse + r.direct_specular + r.indirect_diffuse + r.indirect_specular + r.transmission;
}

// First-hit values that are averaged over the pixel.
struct FirstHit {
    vec3 albedo, normal_ws, emission;
    float roughness;
};

void add_indirect(inout PathRadiance radiance, PathClass path_class, vec3 value) {
    radiance.indirect_diffuse += path_class.diffuse_share * value;
    radiance.indirect_specular += (1.0 - path_class.diffuse_share) * value;
}

// Radiance that arrives over the last BSDF sample, or straight from the camera.
void add_arriving(inout PathRadiance radiance, PathClass path_class, vec3 value) {
    if (path_class.transmitted) radiance.transmission += value;
    else if (path_class.bounce == 0u) radiance.emission += value;
    else if (path_class.bounce == 1u) {
        radiance.direct_diffuse += path_class.diffuse_share * value;
        radiance.direct_specular += (1.0 - path_class.diffuse_share) * value;
    } else add_indirect(radiance, path_class, value);
}

// Light-sampled radiance, split by lobe at the surface where it was sampled.
void add_sampled(inout PathRadiance radiance, PathClass path_class, BsdfValue value) {
    if (path_class.transmitted) radiance.transmission += total(value);
    else if (path_class.bounce == 0u) {
        radiance.direct_diffuse += value.diffuse;
        radiance.direct_specular += value.specular;
        radiance.transmission += value.transmission;
    } else add_indirect(radiance, path_class, total(value));
}

// The firefly clamp (an option, biased): the share of a contribution that is kept, so that light is dimmed, not recoloured.
float firefly_share(ViewData view, uint bounce, vec3 value) {
    if (view.firefly_clamp <= 0.0 || bounce == 0u) return 1.0;
    return min(1.0, view.firefly_clamp / max(luminance(value), 1e-30));
}
#endif
