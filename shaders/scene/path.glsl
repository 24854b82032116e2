// The path tracer's loop, one place for every renderer. Document 002, with its defects mended: shadow rays are traced by the caller
// of the hit, the sampler is fixed per pixel, emission is weighted whatever surface was passed, ray origins move by error bounds.
#ifndef PARHELION_SCENE_PATH_GLSL
#define PARHELION_SCENE_PATH_GLSL
#include "scene/begin_path.glsl"
#include "scene/trace_light.glsl"

// Traces the path's ray and shades what it meets.
#ifdef SHADE_IN_HIT
#include "scene/vertex_in_hit.glsl"
#else
VertexResult next_vertex(ViewData view, PathKey key, inout PathState path, inout FirstHit first) {
    const Hit hit = trace_closest(path.ray);
    if (is_miss(hit)) return end_in_sky(view, path, first);
    return shade_vertex(view, key, hit, path, first);
}
#endif

// One sample of one pixel.
PathRadiance trace_path(ViewData view, uvec2 pixel, uint sample_index, inout FirstHit first) {
    const PathKey key = PathKey(pixel, sample_index, view.seed);
    PathRadiance radiance = make_path_radiance();
    PathState path = begin_path(view, key);
    VertexResult vertex;
    do {
        note_ray(path.ray, kRayPath);
        const PathClass path_class = path.path_class;
        vertex = next_vertex(view, key, path, first);
        add_arriving(radiance, path_class, vertex.arriving);
        if (vertex.event.exists) {
            const vec3 passing = trace_light(view, vertex.event.ray);
            add_sampled(radiance, path_class, total(vertex.event.value) * passing, scale(vertex.event.value, passing));
        }
    } while (vertex.goes_on);
    return radiance;
}
#endif
