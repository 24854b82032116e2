// Whether nothing hides a sample, by a ray.
#ifndef PARHELION_REUSE_SEEN_GLSL
#define PARHELION_REUSE_SEEN_GLSL

void note_ray(Ray ray, uint kind) {}

bool is_seen(ViewData view, Shifted shifted, uint moment) {
    if (target_of(shifted) <= 0.0) return false;
    if (shifted.passes && (moment == kNow || scene.header.moving == 0u)) return max_component(trace_light(view, shifted.ray)) > 0.0;
    return trace_visible(shifted.ray, moment);
}
#endif
