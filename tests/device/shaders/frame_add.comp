#version 460
// Frame tests: c[i] = a[i] + b[i]; a by address, b bound. Reads: a, b. Writes: c.
#extension GL_GOOGLE_include_directive : require
#include "shared/types.h"
layout(local_size_x = 64) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer A { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer C { uint v[]; };
layout(set = 1, binding = 0, scalar) readonly buffer B { uint v[]; } b;
layout(push_constant, scalar) uniform Push { A a; C c; uint count; } push;
void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i < push.count) push.c.v[i] = push.a.v[i] + b.v[i];
}
