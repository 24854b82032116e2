// Unit vectors as points of an octahedron unfolded into a square, 16 bits a component. Cigolle et al. 2014, "A Survey of Efficient
// Representations for Independent Unit Vectors".
#ifndef PARHELION_LIB_OCTAHEDRAL_GLSL
#define PARHELION_LIB_OCTAHEDRAL_GLSL

vec2 octahedral_square(vec3 n) {
    const vec2 p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    const vec2 signs = vec2(p.x >= 0.0 ? 1.0 : -1.0, p.y >= 0.0 ? 1.0 : -1.0);
    return n.z < 0.0 ? (1.0 - abs(p.yx)) * signs : p;
}
vec3 octahedral_direction(vec2 p) {
    const vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
    const float fold = max(-n.z, 0.0);
    return normalize(vec3(n.x + (n.x >= 0.0 ? -fold : fold), n.y + (n.y >= 0.0 ? -fold : fold), n.z));
}
uint pack_direction(vec3 n) { return packSnorm2x16(octahedral_square(n)); }
// 12 bits a component.
uint pack_direction_24(vec3 n) {
    const uvec2 p = uvec2(round((octahedral_square(n) * 0.5 + 0.5) * 4095.0));
    return p.x | p.y << 12;
}
vec3 unpack_direction_24(uint bits) { return octahedral_direction(vec2(bits & 4095u, bits >> 12 & 4095u) / 4095.0 * 2.0 - 1.0); }
vec3 unpack_direction(uint bits) { return octahedral_direction(unpackSnorm2x16(bits)); }
#endif
