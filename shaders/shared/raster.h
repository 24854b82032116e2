// The visibility buffer by raster (src/passes/gbuffer): what there is to draw, and what culling makes of it.
#ifndef PARHELION_SHARED_RASTER_H
#define PARHELION_SHARED_RASTER_H
#include "shared/types.h"
SHARED_BEGIN

SHARED_CONST uint kRasterGroup = 64u;  // rows of a work group; rows of one kind begin at multiples of it

// Kinds of what is drawn. Rows lie kind by kind, in this order.
SHARED_CONST uint kRasterOneSided = 0u;  // opaque, invisible from behind
SHARED_CONST uint kRasterTwoSided = 1u;  // opaque
SHARED_CONST uint kRasterAsked = 2u;     // accept_hit() decides (scene/alpha.glsl)
SHARED_CONST uint kRasterKindCount = 3u;

// One geometry of one instance. The box is that of its positions, in object space.
struct DrawnGeometry {
    uint instance;  // 0xFFFFFFFF: fills up its kind's rows
    uint geometry;  // of the mesh
    vec3 lower, upper;
};

// What culling has found in a frame.
struct RasterCounts {
    uint drawn[6];  // of each kind: in the first pass, then in the second
    uint far_bits;  // as a float: metres along the axis that hold everything in front of the camera, a power of two
};

SHARED_END
#endif
