// Which surfaces a pixel of the picture is made of: two at most, of an edge, eight bits each. Two surfaces of a scene seldom have the same.
#ifndef PARHELION_RECONSTRUCTION_SHOWN_GLSL
#define PARHELION_RECONSTRUCTION_SHOWN_GLSL

const uint kNoSurface = 0u;

// Of a surface's number (kSummaryIdShift; 0: the sky, which is a surface here).
uint short_number(uint number) { return number == 0u ? 1u : 2u + number % 254u; }

// A set of nine, by bytes.
struct Shown {
    uvec3 bytes;
};
const Shown kNothingShown = Shown(uvec3(0u));
void add(inout Shown s, int i, uint surface) { s.bytes[i >> 2] |= surface << (i & 3) * 8; }
bool has(Shown s, uint surface) {
    const uvec3 x = s.bytes ^ (surface * 0x01010101u);  // a byte of zeros where it is
    return any(notEqual((x - 0x01010101u) & ~x & 0x80808080u, uvec3(0u)));
}

// The two surfaces of most weight.
void note(inout uvec2 surfaces, inout vec2 most, uint surface, float weight) {
    if (surface == surfaces.x) most.x = max(most.x, weight);
    else if (weight > most.x) {
        surfaces = uvec2(surface, surfaces.x);
        most = vec2(weight, most.x);
    } else if (weight > most.y) {
        surfaces.y = surface;
        most.y = weight;
    }
}

uvec2 unpack_surfaces(vec2 stored) { return uvec2(round(stored * 255.0)); }
vec2 pack_surfaces(uvec2 surfaces) { return vec2(surfaces) / 255.0; }
#endif
