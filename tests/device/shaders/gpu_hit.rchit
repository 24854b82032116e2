#version 460
#extension GL_EXT_ray_tracing : require
layout(location = 0) rayPayloadInEXT int found;
void main() { found = gl_InstanceCustomIndexEXT * 100 + gl_PrimitiveID; }
