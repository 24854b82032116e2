// Reservoirs: one light path out of many that a pixel was offered, and how many it stands for. One struct for direct and indirect light.
// Bitterli et al. 2020, "Spatiotemporal reservoir resampling"; Ouyang et al. 2021, "ReSTIR GI"; Lin et al. 2022, "Generalized Resampled
// Importance Sampling".
#ifndef PARHELION_SHARED_RESERVOIR_H
#define PARHELION_SHARED_RESERVOIR_H
#include "shared/types.h"
SHARED_BEGIN

// What the sample is. Each kind has a measure of its own, in which W is 1 over a density and a surface's contribution is taken: so a sample
// keeps its W wherever it is looked at, and there are no Jacobians (docs/resampling.md).
SHARED_CONST uint kSampleNone = 0u;
SHARED_CONST uint kSampleLight = 1u;        // drawn as a light: a point of its unit square, or a delta light. reference: emitter, triangle; place: the point
SHARED_CONST uint kSampleSky = 2u;          // drawn as the environment: a direction (solid angle). reference: emitter; direction as two floats
SHARED_CONST uint kSampleEmitter = 3u;      // drawn by the BSDF: a point of a glowing triangle (area)
SHARED_CONST uint kSampleOutside = 4u;      // drawn by the BSDF: a direction out of the scene (solid angle)
SHARED_CONST uint kSampleReconnection = 5u; // a point of a triangle (area), with the radiance that comes there from a direction
SHARED_CONST uint kSampleRadiosity = 6u;    // a point of a triangle (area), with the radiance that leaves it alike in all directions

SHARED_CONST uint kSampleFront = 1u;   // the point is seen from its triangle's front side
SHARED_CONST uint kSampleGlossy = 2u;  // its light leaves the point by other lobes than the diffuse one alone
SHARED_CONST uint kSampleSeen = 4u;    // nothing hides it from the pixel: a ray of this frame said so
SHARED_CONST uint kSampleFlagBits = 3u;

SHARED_CONST uint kMostConfidence = 255u;
SHARED_CONST uint kMostSampleGeometries = 65536u;  // of a mesh: points of others are not shared

// A sample by reference, packed: 24 bytes.
struct PackedSample {
    uint reference;    // instance or emitter, rows of the frame that wrote it
    uint number;       // triangle
    uint place;        // two of 16 bits: barycentrics, or a point of the unit square. Of directions: octahedral, floats in `number` and here
    uint bits;         // geometry 16, confidence 8, kind 3, flags 3
    uint direction;    // octahedral, 16 bits each: where the light at the point comes from
    uint radiance;     // nits: 8 bits each and 8 of a common exponent
};

// 32 bytes.
struct PackedReservoir {
    PackedSample point;
    float weight;  // W; while samples are offered: the sum of their weights
    float target;  // luminance of the contribution in the measure of its kind, where and when it was kept
};

// The sample by which a slot's pixel is to be lit: the reservoir that has it, a row of all sets' and pixels', and its W there. 8 bytes.
struct ChosenSample {
    uint reservoir;
    float weight;
};

// What a path of the frame keeps of its second vertex, for reservoirs: 48 bytes a slot.
struct LightReuse {
    vec3 prefix;       // throughput until the second vertex and its scattering there, without the density of that: LightPath has the rest
    vec3 share;        // of what is behind the second vertex, by that vertex' lobes: what may be shared
    uint direction;    // in which the path left it, as PackedSample has it
    uint instance, number, place;
    uint bits;         // geometry 16, and kReuse...
    float density;     // with which the path found the point, per area
};
SHARED_CONST uint kReuseFirst = 0x10000u;   // the first surface may share its diffuse light,
SHARED_CONST uint kReuseRough = 0x20000u;   // and what its other lobes scatter
SHARED_CONST uint kReuseFront = 0x40000u;   // of the second vertex: kSampleFront
SHARED_CONST uint kReuseGlossy = 0x80000u;  // kSampleGlossy
SHARED_CONST uint kReuseSecond = 0x100000u; // the second vertex may be a point of reconnection


// How reservoirs are put together.
struct ReuseFrame {
    uint frame_index;
    uint set;               // of two with realtime.reservoirs=split: 0 direct, 1 indirect light
    uint candidates;        // as RealtimeFrame's, for weights of MIS: 0 without tiles
    uint most_confidence;   // of what the last frame knew
    uint neighbours;        // pixels around that are asked
    float radius_px;        // how far off at most, along each axis
    uint permutation;       // 1: near pixels of the last frame are exchanged
    uint reset;             // 1: the last frame has nothing to do with this one
    uint changed;           // 1: points may be lit otherwise than in the last frame
    uint keeps_offered;     // 1: signals hold beside the path's own light what it was offered (realtime/offered.glsl)
};

SHARED_END
#endif
