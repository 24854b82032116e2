// How a path ends in the world cache: where it meets a surface by a broad lobe and from far enough, the light that the surface scatters
// diffusely is what the cache knows; only what its other lobes scatter goes on. After Solari 0.20, with the specular part kept.
#ifndef PARHELION_REALTIME_END_IN_CACHE_GLSL
#define PARHELION_REALTIME_END_IN_CACHE_GLSL
#include "realtime/level_number.glsl"
#include "realtime/paths.glsl"
#include "scene/cache.glsl"
#include "scene/cache_share.glsl"

// To a surface t metres on, and by the lobe of a density from there, which goes through the surface or not.
void advance(inout Footprint f, float t) {
    f.cone.width = cone_width(f.cone, t);
    f.way += t;
}
void spread(inout Footprint f, float pdf, bool through) {
    if (!through) f.reflections += 1u;
    f.flags = f.flags & ~kLobeBroad | (pdf > 0.0 && pdf <= 1.001 / kPi ? kLobeBroad : 0u);
    if (pdf > 0.0) f.cone.spread += min(0.5 * inversesqrt(pdf * kPi), kWidestSpread);
}

// What the cache sends along the path from here; `last`: it must end here, so that all lobes count as diffuse ones. False: it may not end,
// or nothing is known. Of a throughput of 1.
bool end_in_cache(Cache cache, ViewData view, PathKey key, PathState path, Shading shading, VertexNumbers u, Footprint f, bool last, out vec3 light) {
    light = vec3(0.0);
    if (!last && (f.flags & kLobeBroad) == 0u) return false;
    const Surface s = shading.s;
    // A cone that many lobes have widened is no measure of a small room: the last ray is.
    const CachePoint at = cache_point(s, -path.ray.direction_ws, cache_footprint(cache, min(f.cone.width, 2.0 * s.t), view.pixel_width + view.pixel_spread * f.way), level_number(key, path.path_class.bounce));
    if (!last && path.travelled + s.t <= sqrt(3.0) * cache_cell_size(cache, at)) return false;
    vec3 irradiance;
    if (!cache_visit(cache, at, cache.v.life, irradiance)) return false;
    const BsdfSample drawn = sample_bsdf(shading.bsdf, shading.wo, u.scatter.x, u.scatter.yz);
    light = reflected_share(shading, drawn, last) * irradiance / (kPi * cache.v.exposure);
    return true;
}

// After that: the path goes on by the other lobes, as often as they are drawn. False: it ends.
bool keep_glossy(inout PathState path, Shading shading, PathKey key, out float share) {
    const LobeShares shares = lobe_shares(shading.bsdf, shading.wo, bsdf_place(shading.bsdf, shading.wo));
    const uint kGlossySalt = 0x474C4F53u;
    const float u = uint_to_unit_float(hash_combine(alpha_key(key, path.path_class.bounce, kRayPath), kGlossySalt));
    share = 1.0 - shares.wide - shares.sheen;
    if (u >= share) return false;
    path.throughput /= share;
    return true;
}

// Continues by those lobes. Where there is only one, it is drawn each time, and the weight is its own. `density`: of the direction by what drew it.
bool scatter_glossy(inout PathState path, Shading shading, VertexNumbers numbers, float share, uint alpha_key, out float density) {
    vec3 u = numbers.scatter;
    density = 0.0;
    bool alone = true;
#ifdef LAYERS
    alone = !is_layered(shading.bsdf) && !has_glass(shading.bsdf);
#endif
    if (alone) u.x *= share;
    if (!scatter(path, shading, u, false, false, alpha_key)) return false;
    density = share * path.pdf;
    if (!alone) return true;
    if (path.pdf < 0.0) {
        path.throughput *= share;
        return true;
    }
    const float cosine = dot(path.ray.direction_ws, shading.frame[2]);
    const float of_lobe = max(path.pdf - (1.0 - share) * pdf_cosine_hemisphere_solid_angle(cosine), 1e-6 * path.pdf);
    path.throughput *= share * path.pdf / of_lobe;
    density = of_lobe;
    return true;
}
#endif
