// The film: how a sample of a pixel is added to the running block's float sums (planar; View::channel says what is kept).
#ifndef PARHELION_SCENE_FILM_GLSL
#define PARHELION_SCENE_FILM_GLSL
#include "scene/path_class.glsl"
#include "shared/view.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer FilmBlock { float v[]; };

// `pixel` counts along the rows.
void film_add(FilmBlock block, ViewData view, uint group, uint pixel, vec3 value) {
    const uint channel = view.channel[group];
    if (channel == kNoChannel) return;
    const uint plane = view.width * view.height;
    const uint index = channel * plane + pixel;
    block.v[index] += value.x;
    if (group == kFilmRoughness || group >= kFilmDebugLevel) return;  // one number
    block.v[index + plane] += value.y;
    block.v[index + 2u * plane] += value.z;
}

// A sample's beauty, and its squares: a square goes to one of two sums by its size; a negative value never comes here.
void film_add_beauty(FilmBlock block, ViewData view, uint pixel, vec3 value) {
    film_add(block, view, kFilmBeauty, pixel, value);
    if (view.channel[kFilmSquares] == kNoChannel) return;
    const vec3 squares = value * value;
    const bvec3 large = greaterThanEqual(squares, vec3(kLargeSquareFrom));
    film_add(block, view, kFilmSquares, pixel, mix(squares, vec3(0.0), large));
    film_add(block, view, kFilmLargeSquares, pixel, mix(vec3(0.0), squares * kLargeSquareScale, large));
}

void film_add_first_hit(FilmBlock block, ViewData view, uint pixel, FirstHit first) {
    film_add(block, view, kFilmAlbedo, pixel, first.albedo);
    film_add(block, view, kFilmNormal, pixel, first.normal_ws);
    film_add(block, view, kFilmEmission, pixel, first.emission);
    film_add(block, view, kFilmRoughness, pixel, vec3(first.roughness));
}

void film_add_path_classes(FilmBlock block, ViewData view, uint pixel, PathRadiance radiance) {
    film_add(block, view, kFilmPathEmission, pixel, radiance.emission);
    film_add(block, view, kFilmPathDirectDiffuse, pixel, radiance.direct_diffuse);
    film_add(block, view, kFilmPathDirectSpecular, pixel, radiance.direct_specular);
    film_add(block, view, kFilmPathIndirectDiffuse, pixel, radiance.indirect_diffuse);
    film_add(block, view, kFilmPathIndirectSpecular, pixel, radiance.indirect_specular);
    film_add(block, view, kFilmPathTransmission, pixel, radiance.transmission);
}
#endif
