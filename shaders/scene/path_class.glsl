// The classes into which a path's light is sorted (docs/path-space.md), and what it gathers of each.
#ifndef PARHELION_SCENE_PATH_CLASS_GLSL
#define PARHELION_SCENE_PATH_CLASS_GLSL
#include "lib/bsdf_types.glsl"

// How the path left the first surface. Its light is split by the shares of the lobes, whichever of them drew the direction.
struct PathClass {
    uint bounce;         // scatterings so far
    bool transmitted;    // the first of them went through the surface
    vec3 diffuse_share;  // of the throughput: what the first surface's diffuse lobe has; the specular one has the rest
};

// What a path gathers, and the same by path class.
struct PathRadiance {
    vec3 beauty;
    vec3 emission, direct_diffuse, direct_specular, indirect_diffuse, indirect_specular, transmission;
};
PathRadiance make_path_radiance() { return PathRadiance(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0)); }

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
    radiance.beauty += value;
    if (path_class.transmitted) radiance.transmission += value;
    else if (path_class.bounce == 0u) radiance.emission += value;
    else if (path_class.bounce == 1u) {
        radiance.direct_diffuse += path_class.diffuse_share * value;
        radiance.direct_specular += (1.0 - path_class.diffuse_share) * value;
    } else add_indirect(radiance, path_class, value);
}

// Light-sampled radiance: `sum`, split by lobe at the surface where it was sampled.
void add_sampled(inout PathRadiance radiance, PathClass path_class, vec3 sum, BsdfValue value) {
    radiance.beauty += sum;
    if (path_class.transmitted) radiance.transmission += sum;
    else if (path_class.bounce == 0u) {
        radiance.direct_diffuse += value.diffuse;
        radiance.direct_specular += value.specular;
        radiance.transmission += value.transmission;
    } else add_indirect(radiance, path_class, sum);
}
#endif
