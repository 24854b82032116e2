// The state of the wavefront path tracer: paths in slots, queues of slots, what Shade left for Connect and Finalize. Document 003.
#ifndef PARHELION_SHARED_WAVEFRONT_H
#define PARHELION_SHARED_WAVEFRONT_H
#include "shared/reference.h"
SHARED_BEGIN

// What a path met, by the kernel that shades it.
SHARED_CONST uint kClassMiss = 0u;
SHARED_CONST uint kClassEmitter = 1u;       // it only emits (KHR_materials_unlit)
SHARED_CONST uint kClassPlain = 2u;         // metal-rough
SHARED_CONST uint kClassCoated = 3u;        // with a clear coat or sheen
SHARED_CONST uint kClassTransmissive = 4u;
SHARED_CONST uint kClassCount = 5u;

// Lists: each lies in a place of its own of one array, but for pairs of classes of which the second fills a place from its end (no slot
// is in both); that of shadow rays is an array of its own.
SHARED_CONST uint kListRays = 0u;
SHARED_CONST uint kListShadows = 1u;  // entries of vertices
SHARED_CONST uint kListClasses = 2u;  // kClassCount of them
SHARED_CONST uint kListCount = 7u;
// One more counter: paths of the slice that were taken.
SHARED_CONST uint kCountPaths = kListCount;
SHARED_CONST uint kCounterCount = kListCount + 1u;

// What a slot is about.
SHARED_CONST uint kSlotFree = 0u;     // Generate gives it a path
SHARED_CONST uint kSlotLives = 1u;    // its path has a next ray
SHARED_CONST uint kSlotRetires = 2u;  // no path is left for it

SHARED_CONST uint kWavefrontGroup = 128u;  // invocations of a work group of the kernels that trace nothing

// One slot's ray, 32 bytes.
struct WavefrontRay {
    vec3 origin_ws;
    uint alpha_key;
    vec3 direction_ws;
    uint bits;  // kPath...
};

// WavefrontRay::bits and WavefrontVertex::bits
SHARED_CONST uint kPathBounces = 0xFFFFFFu;  // scatterings before this ray
SHARED_CONST uint kPathTransmitted = 1u << 24;
SHARED_CONST uint kVertexExists = 1u << 25;  // of a vertex
SHARED_CONST uint kVertexEvent = 1u << 26;   // it asked for light
SHARED_CONST uint kVertexEnds = 1u << 27;    // the path's last
SHARED_CONST uint kVertexPane = 1u << 28;    // its shadow ray met a pane

// Which triangle, 12 bytes: the surface is recomputed from it.
struct WavefrontHit {
    uint instance_bits, geometry, primitive;
};

// PathState, but for its ray: 16 bytes.
struct WavefrontPath {
    vec3 throughput;
    float pdf;
};

// What only scenes with LAYERS, and ray cones, add to it: 32 bytes.
struct WavefrontExtra {
    uvec4 media;
    float travelled, radiance_scale;
    float cone_width, cone_spread;
};

// What a slot's path has gathered so far, and which one it is: 16 bytes.
struct WavefrontSlot {
    vec3 radiance;
    uint path;  // of the slice: all pixels' first samples, then all their next ...
};

// One vertex of a path, 32 bytes: entry number * slot_count + slot, the number counted from the last Connect.
struct WavefrontVertex {
    vec3 arriving;
    uint bits;
    vec3 sampled;  // what its shadow ray adds: if that is free before Connect, after it what is left
    uint path;
};

// Its shadow ray, 32 bytes.
struct WavefrontShadowRay {
    vec3 origin_ws;
    float t_max;
    vec3 direction_ws;
    uint alpha_key;
};

// Kept beside it where the light is split by path class (the layers path.*): 48 bytes.
struct WavefrontSplit {
    vec3 diffuse_share;  // of the path that came here
    vec3 diffuse, specular, transmission;  // of the sampled light
};

// What a slot's path has gathered so far by path class, there too, and in the end a path of the slice: 72 bytes. Floats are added in
// the order of the path, as the reference adds them.
struct WavefrontClassSums {
    vec3 emission, direct_diffuse, direct_specular, indirect_diffuse, indirect_specular, transmission;
};

// What a path of the slice saw first, kept where the film has layers of it: 40 bytes.
struct WavefrontFirst {
    vec3 albedo, normal_ws, emission;
    float roughness;
};

// Bounces that the statistics tell apart; the last one counts all further ones too.
SHARED_CONST uint kCountedBounces = 32u;

struct WavefrontControl {
    // Set when a slice begins.
    Slice slice;
    uint pixel_count;  // of the slice
    uint slot_count;
    uint shadow_capacity;  // of the list of shadow rays: one a vertex that can come between two Connects
    uint split;        // 1: light is kept by path class
    // Since the slice began.
    uint count[kCounterCount];   // entries of the lists, paths taken
    uint overflow[kListCount];   // entries that found no room
    uint live;                   // slots that had a ray in the last iteration
    uint iterations;             // in which a ray was traced
    uint rays[kCountedBounces][kClassCount];     // that met this class
    uint shadows[kCountedBounces][kClassCount];  // asked for at it
};

// Work sizes for vkCmdDispatchIndirect and vkCmdTraceRaysIndirectKHR, one a list, and one for who reads what Extend met.
SHARED_CONST uint kSizeHits = kListCount;
SHARED_CONST uint kSizeCount = kListCount + 1u;
struct WavefrontSize {
    uint x, y, z;
};

// What prepare.comp does between kernels: turn counters into work sizes, add them to the film's rays, empty lists that will be filled.
SHARED_CONST uint kSizeOfRays = 1u;      // for who traces the rays and who reads what they met; they count
SHARED_CONST uint kSizeOfClasses = 2u;
SHARED_CONST uint kSizeOfShadows = 4u;
SHARED_CONST uint kCountShadows = 8u;
SHARED_CONST uint kEmptyRays = 16u;
SHARED_CONST uint kEmptyClasses = 32u;
SHARED_CONST uint kEmptyShadows = 64u;

SHARED_END
#endif
