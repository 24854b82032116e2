#version 460
// Test shader: cameras while their shutter is open. Reads: moves. Writes: cameras (moves x samples) and moments (one a sample).
#extension GL_GOOGLE_include_directive : require
#include "lib/camera_motion.glsl"

struct Move {
    Camera camera;
    CameraMotion motion;
};
layout(local_size_x = 64) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Moves { Move v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Cameras { Camera v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Moments { float v[]; };
layout(push_constant, scalar) uniform Push {
    Moves moves;
    Cameras cameras;
    Moments moments;
    uint move_count, sample_count, seed;
} push;

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i >= push.sample_count) return;
    const float share = shutter_share(i, push.seed);
    push.moments.v[i] = share;
    for (uint m = 0u; m < push.move_count; ++m) push.cameras.v[m * push.sample_count + i] = camera_at(push.moves.v[m].camera, push.moves.v[m].motion, share);
}
