#version 460
// Frame tests: writes indirect dispatch arguments. Writes: args.
#extension GL_GOOGLE_include_directive : require
#include "shared/types.h"
layout(local_size_x = 1) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Args { uint v[]; };
layout(push_constant, scalar) uniform Push { Args args; uint groups; } push;
void main() {
    push.args.v[0] = push.groups;
    push.args.v[1] = 1u;
    push.args.v[2] = 1u;
}
