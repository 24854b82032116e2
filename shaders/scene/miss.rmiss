#version 460
// Miss of a closest-hit ray: the payload was preset to a miss. Reads and writes: nothing.
#extension GL_EXT_ray_tracing : require
void main() {}
