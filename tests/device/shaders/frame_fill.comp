#version 460
// Frame tests: out[i] = base + i. Writes: out_values.
#extension GL_GOOGLE_include_directive : require
#include "shared/types.h"
layout(local_size_x = 64) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Out { uint v[]; };
layout(push_constant, scalar) uniform Push { Out out_values; uint base; uint count; } push;
void main() {
    if (gl_GlobalInvocationID.x < push.count) push.out_values.v[gl_GlobalInvocationID.x] = push.base + gl_GlobalInvocationID.x;
}
