// Shadow rays.
#ifndef PARHELION_SCENE_TRACE_LIGHT_GLSL
#define PARHELION_SCENE_TRACE_LIGHT_GLSL
#include "scene/panes.glsl"
#include "scene/trace.glsl"
#include "shared/view.h"

// What of a light's radiance arrives over a shadow ray. Refracting glass blocks it.
vec3 trace_light(ViewData view, Ray ray) {
    if (!kLayers || (scene.header.features & kScenePanes) == 0u) return vec3(trace_visible(ray, kNow));
    vec3 passing = vec3(1.0);
    while (max_component(passing) > 0.0) {
        const Hit hit = trace_closest(ray);
        if (is_miss(hit)) return passing;
        Surface s = fetch_surface(hit, ray, kNoCone);
        s.integer_offset = (view.flags & kViewIntegerOffset) != 0u;
        passing *= pane_transmittance(s, ray.direction_ws);
        ray = pass_through(ray, s);
    }
    return vec3(0.0);
}
#endif
