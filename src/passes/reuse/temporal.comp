#version 460
// Temporal reuse (reuse/temporal.glsl); samples are weighed without what hides them.
// variants: LAYERS
#extension GL_GOOGLE_include_directive : require
#include "reuse/temporal.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

bool is_seen(ViewData view, Shifted shifted, uint moment) { return true; }

void main() { reuse_before(gl_GlobalInvocationID.xy); }
