// Which part of a surface's light the world cache can answer for.
#ifndef PARHELION_SCENE_CACHE_SHARE_GLSL
#define PARHELION_SCENE_CACHE_SHARE_GLSL
#include "scene/vertex.glsl"

// Glass sends on what lies behind it, which the irradiance before it does not tell: paths never have to end there.
bool may_end_in_cache(Shading shading) {
#ifdef LAYERS
    return !has_glass(shading.bsdf);
#else
    return true;
#endif
}

// What of the irradiance at a surface leaves it towards wo, as radiance times pi: by its diffuse lobes, or by all as if they were such.
// Exact where light comes alike from everywhere; of layered surfaces one sample of it.
vec3 reflected_share(Shading shading, BsdfSample drawn, bool everything) {
#ifdef LAYERS
    if (is_layered(shading.bsdf) || has_glass(shading.bsdf)) return everything ? total(drawn.weight) : drawn.weight.diffuse;
#endif
    const Glossy base = shading.bsdf.base;
    const vec2 place = shading.outgoing.place.table;
    const vec3 diffuse = diffuse_albedo(base, place);
    return everything ? diffuse + single_albedo(base.glossy, place) + again_albedo(base, place) : diffuse;
}
#endif
