// One view of a scene: camera, film and path settings, as the passes see them.
#ifndef PARHELION_SHARED_VIEW_H
#define PARHELION_SHARED_VIEW_H
#include "shared/types.h"
SHARED_BEGIN

// Film channel groups; View::channel says where each starts in the film, kNoChannel if it is not kept.
SHARED_CONST uint kFilmBeauty = 0u;
SHARED_CONST uint kFilmAlbedo = 1u;
SHARED_CONST uint kFilmNormal = 2u;
SHARED_CONST uint kFilmEmission = 3u;
SHARED_CONST uint kFilmRoughness = 4u;
SHARED_CONST uint kFilmPathEmission = 5u;
SHARED_CONST uint kFilmPathDirectDiffuse = 6u;
SHARED_CONST uint kFilmPathDirectSpecular = 7u;
SHARED_CONST uint kFilmPathIndirectDiffuse = 8u;
SHARED_CONST uint kFilmPathIndirectSpecular = 9u;
SHARED_CONST uint kFilmPathTransmission = 10u;
SHARED_CONST uint kFilmSquares = 11u;       // of the beauty, below kLargeSquareFrom
SHARED_CONST uint kFilmLargeSquares = 12u;  // the others, times kLargeSquareScale
// What the realtime renderer was doing, for the eye: cells of the world cache at the pixel's surface, and its own work.
SHARED_CONST uint kFilmDebugCells = 13u;       // a colour a cell
SHARED_CONST uint kFilmDebugIrradiance = 14u;
SHARED_CONST uint kFilmDebugLevel = 15u;       // from here on one number each
SHARED_CONST uint kFilmDebugCount = 16u;
SHARED_CONST uint kFilmDebugAge = 17u;
SHARED_CONST uint kFilmDebugLife = 18u;
SHARED_CONST uint kFilmDebugLight = 19u;       // 1 + the emitter that the surface asks; 0: none
SHARED_CONST uint kFilmDebugRays = 20u;        // traced for the pixel after what it sees
SHARED_CONST uint kFilmDebugDuplicates = 21u;  // pixels around whose reservoirs keep the same sample
SHARED_CONST uint kFilmGroupCount = 22u;
SHARED_CONST uint kNoChannel = 0xFFFFFFFFu;

// Squares range twice as far as samples do: two sums, with factors that lose nothing (image/film.h resolves them).
SHARED_CONST float kLargeSquareFrom = 65536.0f;
SHARED_CONST float kLargeSquareScale = 2.3283064365386963e-10f;  // 2^-32

SHARED_CONST uint kFilterBox = 0u;
SHARED_CONST uint kFilterPoint = 1u;

// ViewData::flags
SHARED_CONST uint kViewEnergyCompensation = 1u;  // light that microfacets scatter more than once is not lost
SHARED_CONST uint kViewNormalCorrection = 2u;    // shading normals are bent so that reflections leave the surface
SHARED_CONST uint kViewShutter = 4u;             // the camera moves while the shutter is open (ViewData::motion)
SHARED_CONST uint kViewIntegerOffset = 8u;       // rays leave surfaces by offset_origin_integer() (lib/geometry.glsl)

// Kinds of rays: in the film's counts, and in the random numbers of alpha tests.
SHARED_CONST uint kRayPath = 0u;
SHARED_CONST uint kRayShadow = 1u;

// A film block is 64 samples: summed in float by sample index, then added exactly (lib/fixed_point.glsl).
SHARED_CONST uint kSamplesPerBlock = 64u;

// Pinhole or orthographic camera. A pixel's direction is forward + x * right + y * up with x, y in [-1, 1] (y up):
// `right_ws` and `up_ws` carry the half extents of the image at unit distance (perspective) or in metres (orthographic).
struct Camera {
    vec3 position_ws;
    vec3 right_ws;
    vec3 up_ws;
    vec3 forward_ws;
    uint orthographic;
    float lens_radius;     // metres; 0: everything is sharp
    float focus_distance;  // metres along forward_ws to the plane that a lens shows sharp
};

// What a camera does while its shutter is open, from where it stands when it opens (lib/camera_motion.glsl).
struct CameraMotion {
    vec3 translation_ws;  // metres
    vec3 axis_ws;         // unit; it turns about this by twice half_angle, at an even speed
    float half_angle;     // radians, 0 to pi / 2
    vec2 zoom;            // growth of right_ws and up_ws as a share of them
};

struct ViewData {
    Camera camera;
    Camera camera_before;
    CameraMotion motion;  // of `camera`, if kViewShutter is set
    uint width, height;
    uint seed;
    uint sampler_kind;
    uint max_bounces;  // scatterings of a path; 0xFFFFFFFF: unlimited
    uint pixel_filter;
    uint roulette_start;     // first bounce with Russian roulette
    uint light_sampling;     // 0: MIS of both; 1: light sampling only; 2: BSDF sampling only (tests)
    uint flags;              // kView...
    float firefly_clamp;     // nits: most that one contribution after the first scattering may add; 0: no limit
    float pixel_width, pixel_spread;  // a pixel's ray cone at the camera: metres, radians
    vec2 jitter;             // pixels, x to the right, y down: where kFilterPoint looks through pixels, from their centres
    vec2 jitter_before;      // the previous frame's
    uint channel[kFilmGroupCount];
    uint channel_count;
};

SHARED_END
#endif
