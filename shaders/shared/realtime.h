// What the realtime renderer keeps of a pixel and of light samples.
#ifndef PARHELION_SHARED_REALTIME_H
#define PARHELION_SHARED_REALTIME_H
#include "shared/types.h"
SHARED_BEGIN

// The identity of a pixel (RGBA32UI): instance bits as in Hit, geometry, primitive, and, once the surface is known, its geometric
// normal (octahedral, 16 bits a component). kHitMiss: sky.

// Nearest distance that reversed-Z depth tells apart: depth = kDepthNear / distance along the axis, 0 infinitely far; of an orthographic
// camera 1 / (1 + distance).
SHARED_CONST float kDepthNear = 1e-3f;

// Flags in the lowest bits of Summary::w.
SHARED_CONST uint kSummaryFrontFacing = 1u;
SHARED_CONST uint kSummaryTransmits = 2u;
SHARED_CONST uint kSummaryDelta = 4u;  // an exact mirror, or smooth glass
SHARED_CONST uint kSummaryFollowed = 8u;  // an exact mirror or a pane: what is seen through it may stand in its place (gbuffer/follow.trace)
SHARED_CONST uint kSummaryIdShift = 16u;  // of Summary::z: a number of the surface, 16 bits; 0: sky

// Mirrors and panes, one behind the other, that a pixel is followed through.
SHARED_CONST uint kMostFollowed = 4u;

// Light tiles: sets of light samples that are drawn before anyone needs them, so that neighbours read the same memory. Wyman and
// Panteleev 2021, "Rearchitecting Spatiotemporal Resampling for Production", section 5.
SHARED_CONST uint kTileCount = 128u;
SHARED_CONST uint kTileSamples = 1024u;

// TileSample::bits: channels of radiance over density, 9 bits each, as code 1 + (log2 + 40) / 80 * 510, 0: none; then a kind.
SHARED_CONST uint kTileMesh = 0u;             // place: position; its triangle shines to the front
SHARED_CONST uint kTileMeshBothSides = 1u;
SHARED_CONST uint kTileInfinite = 2u;         // place: direction to it
SHARED_CONST uint kTileDeltaInfinite = 3u;
SHARED_CONST uint kTilePoint = 4u;            // a delta light at a position
SHARED_CONST uint kTileNone = 5u;
SHARED_CONST uint kTileKindShift = 27u;

// 32 bytes: what choosing between light samples needs, in log2 and octahedral codes. The sample that is chosen is made once more, from
// its light and the numbers of its place in the tile.
struct TileSample {
    vec3 place_ws;
    uint normal;         // of the triangle, octahedral
    uint bits;
    float inverse_pdf;   // per area, per solid angle, or 1 over the probability of a delta light
    uint emitter, triangle;
};

// Three unsigned floats of 8 bits exponent and 13 bits mantissa, rounded to nearest.
struct PackedLight {
    uint low, high;
};

// A frame of the realtime renderer.
struct RealtimeFrame {
    uint frame_index;   // key of all its random numbers, with the view's seed
    float exposure;     // stored radiance is nits times this
    uint candidates;    // light samples that the first surface's one is chosen from
    uint tiles;         // 1: they come from light tiles
    uint path_bounces;  // reflections after which a path ends in the cache whatever it meets, but for glass
    uint follows;       // 1: the signals are of the surface that is seen through mirrors and panes
    uint reservoir_sets;  // 1: one reservoir a pixel; 2: one for direct and one for indirect light
    uint later_candidates;  // light samples that a later vertex' one is chosen from, with tiles; 0: one of all lights
};

// A path of the frame between two of its vertices, beside its ray (WavefrontRay): 48 bytes.
struct LightPath {
    vec3 throughput;
    float pdf;
    vec3 diffuse_share;  // of the path class
    float travelled;
    float cone_width, cone_spread;  // of its footprint in the world cache, with:
    float way;                      // metres from the camera
    uint lobes;                     // reflections so far, and kLobe...
};
SHARED_CONST uint kLobeBroad = 0x80000000u;     // the last lobe was at least as broad as a cosine
SHARED_CONST uint kLobeStraight = 0x40000000u;  // so far mirrors and panes only: what the path meets next is what the pixel shows
SHARED_CONST uint kLobeFirst = 0x20000000u;     // the last scattering was where the pixel's surface is
SHARED_CONST uint kLobeBehind = 0x10000000u;    // a mirror lies before that surface
SHARED_CONST uint kLobeFlags = 0xF0000000u;

// What only scenes with LAYERS add to it: 20 bytes.
struct LightPathInside {
    uvec4 media;
    float radiance_scale;
};

// What a path's vertex asked a light for, and gets if its shadow ray is free: 32 bytes.
struct LightPending {
    vec3 diffuse;   // by what the lobes of the surface that the pixel shows have of it
    uint pixel;
    vec3 specular;
    uint kind;      // kLight...
};
SHARED_CONST uint kLightDirect = 0u;
SHARED_CONST uint kLightIndirect = 1u;
SHARED_CONST uint kLightTransmitted = 2u;
SHARED_CONST uint kLightReflected = 3u;    // by a mirror before the surface that the pixel shows
SHARED_CONST uint kLightOffered = 4u;        // all of it to reservoirs
SHARED_CONST uint kLightStopsAtPanes = 0x100u;  // besides: what comes through panes is another path's

// What a path brought so far, but for what is seen straight: 24 bytes.
struct LightSums {
    vec3 diffuse, specular;
};

// The two kernels of Shade, by what a path met: in scenes of layered materials those and the rest, else sky and surfaces.
SHARED_CONST uint kShadePlain = 0u;
SHARED_CONST uint kShadeRest = 1u;
SHARED_CONST uint kShadeKernels = 2u;

SHARED_END
#endif
