// Frames, orientation and spawn points. Pure functions.
#ifndef PARHELION_LIB_GEOMETRY_GLSL
#define PARHELION_LIB_GEOMETRY_GLSL

// The same bits in whatever shader they are compiled: no fused operations.
float precise_dot(vec3 a, vec3 b) {
    precise const float d = (a.x * b.x + a.y * b.y) + a.z * b.z;
    return d;
}
vec3 precise_cross(vec3 a, vec3 b) {
    precise const vec3 c = vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
    return c;
}
vec3 precise_normalize(vec3 v) {
    precise const vec3 n = v / sqrt(precise_dot(v, v));
    return n;
}

// An orthonormal basis around unit n as columns (tangent, bitangent, n). Duff et al. 2017, "Building an Orthonormal Basis, Revisited".
mat3 make_frame(vec3 n) {
    const float s = n.z >= 0.0 ? 1.0 : -1.0;
    const float a = -1.0 / (s + n.z);
    const float b = n.x * n.y * a;
    return mat3(vec3(1.0 + s * n.x * n.x * a, s * b, -s * n.x), vec3(b, s + n.y * n.y * a, -n.y), n);
}

float next_away(float x, float direction) {
    if (direction == 0.0) return x;
    if (x == 0.0) return direction > 0.0 ? 1e-38 : -1e-38;
    const int step = (x > 0.0) == (direction > 0.0) ? 1 : -1;
    return intBitsToFloat(floatBitsToInt(x) + step);
}

// Start of a ray that leaves a surface point towards w: moved along the geometric normal out of the box of rounding errors
// |error|, then rounded away. Pharr, Jakob, Humphreys 2016, section 3.9.5.
vec3 offset_origin(vec3 p, vec3 error, vec3 n_geometric, vec3 w) {
    const float d = dot(abs(n_geometric), error);
    const vec3 offset = dot(w, n_geometric) < 0.0 ? -d * n_geometric : d * n_geometric;
    const vec3 moved = p + offset;
    return vec3(next_away(moved.x, offset.x), next_away(moved.y, offset.y), next_away(moved.z, offset.z));
}

// The same by the document's method, for comparison: the coordinates' bit patterns move by a number of roundings, near zero the
// coordinates by a fixed length, whatever the triangle's size. Wächter and Binder 2019, "A Fast and Robust Method for Avoiding
// Self-Intersection", with their thresholds.
vec3 offset_origin_integer(vec3 p, vec3 n_geometric, vec3 w) {
    const vec3 n = dot(w, n_geometric) < 0.0 ? -n_geometric : n_geometric;
    const ivec3 steps = ivec3(256.0 * n) * ivec3(p.x < 0.0 ? -1 : 1, p.y < 0.0 ? -1 : 1, p.z < 0.0 ? -1 : 1);
    const vec3 far = intBitsToFloat(floatBitsToInt(p) + steps), near = p + n / 65536.0;
    return vec3(abs(p.x) < 1.0 / 32.0 ? near.x : far.x, abs(p.y) < 1.0 / 32.0 ? near.y : far.y, abs(p.z) < 1.0 / 32.0 ? near.z : far.z);
}

// Bends a shading normal so that the reflection of the view direction stays above the geometric surface (both oriented to the
// side of wo). Keeps normal-mapped mirrors from reflecting into their own surface.
vec3 bend_normal(vec3 n_shading, vec3 n_geometric, vec3 wo) {
    const vec3 r = reflect(-wo, n_shading);
    const float below = dot(r, n_geometric);
    const float kMinimum = 1e-3;
    if (below >= kMinimum && dot(n_shading, wo) > 0.0) return n_shading;
    // The half vector of wo and the reflection pushed up to the surface.
    const vec3 lifted = normalize(r + (kMinimum - min(below, 0.0) + kMinimum) * n_geometric);
    const vec3 bent = normalize(wo + lifted);
    return dot(bent, n_geometric) > 0.0 ? bent : n_geometric;
}
#endif
