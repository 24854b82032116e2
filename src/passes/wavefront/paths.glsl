// What a slot keeps of its path.
#ifndef PARHELION_WAVEFRONT_PATHS_GLSL
#define PARHELION_WAVEFRONT_PATHS_GLSL
#include "scene/path_state.glsl"
#include "wavefront/bits.glsl"
#include "wavefront/pixels.glsl"
#include "wavefront/state.glsl"

#if defined(LAYERS) || defined(RAY_CONES)
const bool kHasExtra = true;
#else
const bool kHasExtra = false;
#endif

Ray to_ray(WavefrontRay kept) { return Ray(kept.origin_ws, 0.0, kept.direction_ws, kInfinity, kept.alpha_key); }

// The path of a slot; its diffuse share is kept only where light is split by class.
PathState unpack_path(WavefrontRay ray, WavefrontPath kept, WavefrontExtra extra) {
    PathState path;
    path.ray = to_ray(ray);
    path.throughput = kept.throughput;
    path.pdf = kept.pdf;
    path.path_class = unpack_class(ray.bits, vec3(0.0));
    path.media = MediumStack(extra.media);
    path.travelled = extra.travelled;
    path.radiance_scale = extra.radiance_scale;
    path.cone = RayCone(extra.cone_width, extra.cone_spread);
    return path;
}

const WavefrontExtra kNoExtra = WavefrontExtra(uvec4(kNone), 0.0, 1.0, kNoCone.width, kNoCone.spread);

WavefrontRay pack_ray(PathState path) { return WavefrontRay(path.ray.origin_ws, path.ray.alpha_key, path.ray.direction_ws, pack_bits(path.path_class)); }
WavefrontExtra pack_extra(PathState path) { return WavefrontExtra(path.media.materials, path.travelled, path.radiance_scale, path.cone.width, path.cone.spread); }

// Which sample of which pixel a path of the slice is.
PathKey path_key(ViewData view, Control control, uint path) {
    const uint count = control.v.pixel_count, sample_offset = path / count;
    return PathKey(pixel_of(view, control.v.slice, path - sample_offset * count), control.v.slice.first_sample + sample_offset, view.seed);
}
#endif
