#version 460
// Spatial reuse (reuse/spatial.glsl); samples are weighed without what hides them.
// variants: LAYERS
#extension GL_GOOGLE_include_directive : require
#include "reuse/spatial.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

bool is_seen(ViewData view, Shifted shifted, uint moment) { return true; }

void main() { reuse_around(gl_GlobalInvocationID.xy); }
