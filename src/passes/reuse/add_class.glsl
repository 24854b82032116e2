// Light that reservoirs bring, into the film's layers of path classes. A pass that includes it declares push constants with `block`.
#ifndef PARHELION_REUSE_ADD_CLASS_GLSL
#define PARHELION_REUSE_ADD_CLASS_GLSL
#include "scene/film.glsl"

void add_class(ViewData view, uint pixel, bool indirect, BsdfValue light) {
    PathRadiance by_class = make_path_radiance();
    if (indirect) {
        by_class.indirect_diffuse = light.diffuse;
        by_class.indirect_specular = light.specular;
    } else add_sampled(by_class, PathClass(0u, false, vec3(0.0)), total(light), light);
    film_add_path_classes(push.block, view, pixel, by_class);
}
#endif
