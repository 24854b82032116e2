// Shadow rays.
#ifndef PARHELION_SCENE_TRACE_LIGHT_GLSL
#define PARHELION_SCENE_TRACE_LIGHT_GLSL
#include "scene/panes.glsl"
#include "scene/path_state.glsl"
#include "scene/trace.glsl"
#include "shared/view.h"

// Told of every ray before it is traced; the pass that includes this file defines it, to count or keep them.
void note_ray(Ray ray, uint kind);

// What of a light's radiance arrives over a shadow ray. Refracting glass blocks it.
vec3 trace_light(ViewData view, Ray ray) {
    note_ray(ray, kRayShadow);
    if (!kLayers || (scene.header.features & kScenePanes) == 0u) return vec3(trace_visible(ray, kNow));
    vec3 passing = vec3(1.0);
    while (max_component(passing) > 0.0) {
        const Hit hit = trace_closest(ray);
        if (is_miss(hit)) return passing;
        if ((scene_flags(hit_instance(hit), hit.geometry) & kMaterialThin) == 0u) return vec3(0.0);
        Surface s = fetch_surface(hit, ray, kNoCone);
        s.integer_offset = (view.flags & kViewIntegerOffset) != 0u;
        passing *= pane_transmittance(view, s, ray.direction_ws);
        if (max_component(passing) > 0.0) {
            ray = pass_through(ray, s);
            note_ray(ray, kRayShadow);
        }
    }
    return vec3(0.0);
}
#endif
