// What the two shaders of gbuffer/visible share.
#include "gbuffer/raster.glsl"
#include "scene/scene.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Counts { RasterCounts data; };
layout(push_constant, scalar) uniform Push {
    ViewBlock view;
    DrawnArray drawn;
    Counts counts;
    uint frame_index;
} push;

// Corners of a triangle, counter-clockwise on its front side: a mirroring instance turns their order over.
uint front_corner(uint instance_flags, uint corner) { return (instance_flags & kInstanceFlipsFacing) != 0u && corner != 0u ? 3u - corner : corner; }
