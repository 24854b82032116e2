// How a path begins: at the camera.
#ifndef PARHELION_SCENE_BEGIN_PATH_GLSL
#define PARHELION_SCENE_BEGIN_PATH_GLSL
#include "scene/camera.glsl"
#include "scene/vertex.glsl"

PathState begin_path(ViewData view, PathKey key) {
    PathSampler samples = make_sampler(key.pixel, key.sample_index, key.seed, view.sampler_kind, scene.header.sobol, scene.header.blue_noise);
    PathState path;
    path.ray = sample_camera_ray(view, key.pixel, samples, alpha_key(key, 0u, kRayPath));
    path.throughput = vec3(1.0);
    path.pdf = -1.0;
    path.travelled = 0.0;
    path.radiance_scale = 1.0;
    path.path_class = PathClass(0u, false, vec3(0.0));
    path.cone = first_cone(view);
    path.media = make_medium_stack();
    return path;
}
#endif
