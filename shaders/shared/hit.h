// What tracing returns: which triangle. Everything else is recomputed from it (fetch_surface).
#ifndef PARHELION_SHARED_HIT_H
#define PARHELION_SHARED_HIT_H
#include "shared/types.h"
SHARED_BEGIN

// Hit::instance_bits: 29 bits instance, 2 bits geometry kind (0: triangles), 1 bit "deformed".
SHARED_CONST uint kHitInstanceMask = 0x1FFFFFFFu;
SHARED_CONST uint kHitDeformed = 0x80000000u;
SHARED_CONST uint kHitMiss = 0xFFFFFFFFu;  // all of instance_bits

// 20 bytes. Barycentrics (weights of vertex 1 and 2) are 16-bit unorm pairs: good enough to look at; the canonical surface
// recomputes them from the ray.
struct Hit {
    uint instance_bits;
    uint geometry;   // of the mesh
    uint primitive;  // of the geometry
    uint barycentrics;
    float t;
};

SHARED_END
#endif
