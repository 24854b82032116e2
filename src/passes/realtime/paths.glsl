// The frame's paths as their kernels see them (shared/realtime.h): slots of a band of pixels, one a pixel.
#ifndef PARHELION_REALTIME_PATHS_GLSL
#define PARHELION_REALTIME_PATHS_GLSL
#include "scene/film.glsl"
#include "shared/realtime.h"
#include "wavefront/paths.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 16) buffer LightPaths { LightPath v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Inside { LightPathInside v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer Pending { LightPending v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer Sums { LightSums v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Distances { uint v[]; };

// The cone that the path sees the scene through, and its length from the camera. As wide as its lobes scatter.
struct Footprint {
    RayCone cone;
    float way;         // metres
    uint flags;        // kLobe...
    uint reflections;  // scatterings so far that did not go through a surface, but for mirrors that are looked through
};

LightPath pack_light_path(PathState path, Footprint f) {
    return LightPath(path.throughput, path.pdf, path.path_class.diffuse_share, path.travelled, f.cone.width, f.cone.spread, f.way, f.reflections | f.flags);
}
Footprint unpack_footprint(LightPath kept) {
    return Footprint(RayCone(kept.cone_width, kept.cone_spread), kept.way, kept.lobes & kLobeFlags, kept.lobes & ~kLobeFlags);
}
PathState unpack_light_path(WavefrontRay ray, LightPath kept, LightPathInside inside) {
    PathState path;
    path.ray = to_ray(ray);
    path.throughput = kept.throughput;
    path.pdf = kept.pdf;
    path.path_class = unpack_class(ray.bits, kept.diffuse_share);
    path.media = MediumStack(inside.media);
    path.travelled = kept.travelled;
    path.radiance_scale = inside.radiance_scale;
    path.cone = kNoCone;
    return path;
}
LightPathInside pack_inside(PathState path) { return LightPathInside(path.media.materials, path.radiance_scale); }
const LightPathInside kOutside = LightPathInside(uvec4(kNone), 1.0);

// Half floats, as reconstruction wants them; what is farther is as good as the sky. First the diffuse lobe's, then the others'; 0: not by it.
uint pack_distance(float metres, PathClass by) {
    const float d = min(metres, 65504.0);
    return packHalf2x16(max_component(by.diffuse_share) > 0.5 ? vec2(d, 0.0) : vec2(0.0, d));
}

void add_light(Sums sums, uint slot, vec3 diffuse, vec3 specular) {
    sums.v[slot].diffuse += diffuse;
    sums.v[slot].specular += specular;
}
#endif
