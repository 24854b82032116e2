// What reconstruction keeps of a pixel, and how a frame of it is set (docs/reconstruction.md).
#ifndef PARHELION_SHARED_RECONSTRUCTION_H
#define PARHELION_SHARED_RECONSTRUCTION_H
#include "shared/types.h"
SHARED_BEGIN

// Pixels along the side of a tile, over which change is told from noise.
SHARED_CONST uint kChangeTile = 8u;
// History lengths are kept in eight bits, in quarters of a frame.
SHARED_CONST float kMostFrames = 63.0f;

// Planes of a pixel's state, a word each.
SHARED_CONST uint kStateFast = 0u;    // half2: luminance over the last few frames, diffuse and specular
SHARED_CONST uint kStateHits = 1u;    // half2: metres to what the paths met after the surface, diffuse and specular; 0: not known
SHARED_CONST uint kStateFrames = 2u;  // quarters of frames that the two signals' histories are worth (8 bits each), then the surface's id (16 bits; 0: sky)
SHARED_CONST uint kStateDeviations = 3u;  // half2: of a frame's tone (reconstruction/tone.glsl), diffuse and specular; the tones' means are with the light
SHARED_CONST uint kStatePlanes = 4u;
// Length of a history that begins with this frame.
SHARED_CONST uint kStateFresh = 4u;

// Planes of what reconstruction gets of a frame, unpacked to be written (reconstruction/show.comp): floats, but for the last four.
SHARED_CONST uint kInputDiffuse = 0u;         // light: pre-exposed R, G, B
SHARED_CONST uint kInputSpecular = 3u;
SHARED_CONST uint kInputEmission = 6u;
SHARED_CONST uint kInputAlbedo = 9u;          // what diffuse light is multiplied by
SHARED_CONST uint kInputSpecularAlbedo = 12u;
SHARED_CONST uint kInputNormal = 15u;         // shading normal; 0 in the sky, as all up to the hits
SHARED_CONST uint kInputGeometricNormal = 18u;
SHARED_CONST uint kInputRoughness = 21u;
SHARED_CONST uint kInputHits = 22u;           // metres, of the diffuse and the specular lobe
SHARED_CONST uint kInputDepth = 24u;          // metres along the camera's axis
SHARED_CONST uint kInputMotion = 25u;         // pixels
SHARED_CONST uint kInputSurface = 27u;        // number of the surface that all the above are of; 0: sky
SHARED_CONST uint kInputIds = 28u;            // what the ray met first: row of the instance, primitive of its mesh, triangle; kNone: sky
SHARED_CONST uint kInputPlanes = 31u;

// Sums over a tile's pixels that have a history, of tones: a frame's variance; how fast light drifts away from the histories, by the frame and over
// the last frames; and the variance of what one frame says of that, if pixels had each their own noise, and how many times that it is (lights are chosen by the tile).
struct ChangeSums {
    float variance, drift_now, drift, drift_variance, shared_noise;
};
struct ChangeTile {
    ChangeSums diffuse, specular;
    float count;
};
// What follows for a tile, diffuse and specular.
struct ChangeVerdict {
    uint worth;  // half2: frames that histories are worth while light drifts so fast
    uint drift;  // half2: of the tile's pixels, stops a frame
    uint shared_noise;  // half2: of the tile
};
// Share of a frame in a tile's drift.
SHARED_CONST float kDriftShare = 0.1875f;
// Share of a frame in its shared noise; of what is off by more than this many deviations no more counts, for that is no noise.
SHARED_CONST float kNoiseShare = 0.0625f, kMostNoise = 3.0f;

// Settings of a frame. `vec2`s are pixels of the rendered picture.
struct ReconstructionFrame {
    vec2 jitter, jitter_before;  // ViewData::jitter of this frame and the last
    float exposure_scale;        // stored light times this is light in this frame's exposure
    uint frame_index;            // key of its random numbers
    uint has_history;            // 0: everything begins anew
    uint history;                // frames that a history is worth at most
    uint fast_history;           // those of the fast one
    float firefly;               // times the brightest neighbour: what a pixel may have more is shared with them; 0: all
    float antilag;               // standard errors that a drift must stand out by; 0: none does
    float clamp_width;           // standard deviations of the fast history that the slow one may lie off; 0: any
    uint virtual_motion;         // 1: reflections are looked for where they were seen
};

SHARED_END
#endif
