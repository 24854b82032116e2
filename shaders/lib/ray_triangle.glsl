// Ray against triangle: the watertight test of our traversal, and the canonical recomputation of a hit that is already known.
// Woop, Benthin, Wald 2013, "Watertight Ray/Triangle Intersection". Also compiled as C++ (shared/functions.h).
#ifndef PARHELION_LIB_RAY_TRIANGLE_GLSL
#define PARHELION_LIB_RAY_TRIANGLE_GLSL
#include "shared/functions.h"
SHARED_BEGIN

// A ray prepared for triangles: axes permuted so that z is its largest direction component, sheared onto that axis.
struct ShearedRay {
    vec3 origin;
    uint axis;   // the one that becomes z
    vec3 shear;  // direction (x, y, 1) / z after the permutation
};

// Corners as the ray sees them: the ray is the line x = y = 0; t = shear.z * z.
struct ShearedTriangle {
    vec3 a, b, c;
    float u, v, w;  // twice the signed areas opposite a, b, c
};

struct TriangleHit {
    float t;
    vec2 barycentrics;  // weights of corners 1 and 2
    bool front_facing;  // the corners run counter-clockwise as seen from the ray's origin
};

// A cyclic permutation, so handedness stays. Selects instead of indexing: registers cannot be indexed.
SHARED_FN vec3 permute_axes(vec3 v, uint axis) { return axis == 0u ? vec3(v.y, v.z, v.x) : axis == 1u ? vec3(v.z, v.x, v.y) : v; }

SHARED_FN ShearedRay make_sheared_ray(vec3 origin, vec3 direction) {
    const vec3 length = abs(direction);
    ShearedRay ray;
    ray.origin = origin;
    ray.axis = length.x >= length.y && length.x >= length.z ? 0u : length.y >= length.z ? 1u : 2u;
    const vec3 d = permute_axes(direction, ray.axis);
    SHARED_PRECISE const vec3 shear = vec3(d.x, d.y, 1.0f) / d.z;
    ray.shear = shear;
    return ray;
}

// What rounding took from a product, exactly: a b - p for p = round(a b). `fused`: the device's fma() rounds once, which not all
// promise. Otherwise by Veltkamp's splitting, Dekker 1971.
SHARED_FN float product_error(float a, float b, float p, bool fused) {
    if (fused) {
        SHARED_PRECISE const float at_once = fma(a, b, -p);
        return at_once;
    }
    SHARED_PRECISE const float ca = 4097.0f * a, cb = 4097.0f * b;
    SHARED_PRECISE const float a_high = ca - (ca - a), b_high = cb - (cb - b);
    SHARED_PRECISE const float a_low = a - a_high, b_low = b - b_high;
    SHARED_PRECISE const float error = (((a_high * b_high - p) + a_high * b_low) + a_low * b_high) + a_low * b_low;
    return error;
}

// a.x b.y - a.y b.x, good to a rounding or two even where the products cancel. Exactly antisymmetric.
SHARED_FN float edge_area_accurate(vec3 a, vec3 b, bool fused) {
    SHARED_PRECISE const float left = a.x * b.y, right = a.y * b.x;
    SHARED_PRECISE const float area = (left - right) + (product_error(a.x, b.y, left, fused) - product_error(a.y, b.x, right, fused));
    return area;
}

// The same with the right sign only, or 0: rounding is monotonic, so only equal products hide it. Exactly antisymmetric: both
// triangles at an edge take the same decision.
SHARED_FN float edge_area(vec3 a, vec3 b) {
    SHARED_PRECISE const float left = a.x * b.y, right = a.y * b.x;
    SHARED_PRECISE const float area = left - right;
    return area;
}

SHARED_FN vec3 shear_point(ShearedRay ray, vec3 p) {
    SHARED_PRECISE const vec3 q = p - ray.origin;
    const vec3 r = permute_axes(q, ray.axis);
    SHARED_PRECISE const vec3 sheared = vec3(r.x - ray.shear.x * r.z, r.y - ray.shear.y * r.z, r.z);
    return sheared;
}

SHARED_FN ShearedTriangle shear_triangle(ShearedRay ray, vec3 p0, vec3 p1, vec3 p2) {
    ShearedTriangle s;
    s.a = shear_point(ray, p0);
    s.b = shear_point(ray, p1);
    s.c = shear_point(ray, p2);
    s.u = edge_area(s.c, s.b);
    s.v = edge_area(s.a, s.c);
    s.w = edge_area(s.b, s.a);
    return s;
}

SHARED_FN void make_accurate(SHARED_INOUT(ShearedTriangle) s, bool fused) {
    s.u = edge_area_accurate(s.c, s.b, fused);
    s.v = edge_area_accurate(s.a, s.c, fused);
    s.w = edge_area_accurate(s.b, s.a, fused);
}

SHARED_FN bool surrounds_ray(ShearedTriangle s) { return min(s.u, min(s.v, s.w)) >= 0.0f || max(s.u, max(s.v, s.w)) <= 0.0f; }

SHARED_FN float weighted_area(ShearedTriangle s) {
    SHARED_PRECISE const float area = (s.u + s.v) + s.w;
    return area;
}

// t where the ray's line meets the triangle's plane, weighted by the areas.
SHARED_FN float plane_distance(ShearedRay ray, ShearedTriangle s) {
    SHARED_PRECISE const float t = ((s.u * s.a.z + s.v * s.b.z) + s.w * s.c.z) * ray.shear.z / weighted_area(s);
    return t;
}

// The ray's line against the triangle; the caller looks at the range of t. Edges count as inside for both of their triangles,
// so no ray slips between them. A triangle seen exactly edge-on is not hit. Areas of both signs decide at once, whatever one that
// is 0 would be; the accurate ones are for the few rays left that need them, in one place: their registers cost every ray.
SHARED_FN bool intersect_watertight(ShearedRay ray, vec3 p0, vec3 p1, vec3 p2, bool fused, SHARED_INOUT(TriangleHit) hit) {
    ShearedTriangle s = shear_triangle(ray, p0, p1, p2);
    if (!surrounds_ray(s)) return false;
    hit.t = plane_distance(ray, s);
    // Slivers amplify the areas' roundings. Where the ray begins near the triangle's plane they would decide on which side of it,
    // and a ray that leaves a sliver by its error bounds could meet it again.
    const bool near = abs(hit.t) < 0.01f * abs(ray.shear.z) * max(abs(s.a.z), max(abs(s.b.z), abs(s.c.z)));
    if (s.u == 0.0f || s.v == 0.0f || s.w == 0.0f || near) {
        make_accurate(s, fused);
        if (!surrounds_ray(s) || weighted_area(s) == 0.0f) return false;
        hit.t = plane_distance(ray, s);
    }
    const float area = weighted_area(s);
    hit.barycentrics = vec2(s.v, s.w) / area;
    hit.front_facing = (area > 0.0f) == (ray.shear.z > 0.0f);
    return true;
}

// The point of segment ab nearest to the ray: (its share of b, its squared distance).
SHARED_FN vec2 nearest_on_edge(vec3 a, vec3 b) {
    SHARED_PRECISE const vec2 d = vec2(b.x - a.x, b.y - a.y);
    SHARED_PRECISE const float length_squared = d.x * d.x + d.y * d.y, along = -(a.x * d.x + a.y * d.y);
    SHARED_PRECISE const float share = length_squared > 0.0f ? min(max(along / length_squared, 0.0f), 1.0f) : 0.0f;
    SHARED_PRECISE const vec2 point = vec2(a.x + share * d.x, a.y + share * d.y);
    SHARED_PRECISE const float distance_squared = point.x * point.x + point.y * point.y;
    return vec2(share, distance_squared);
}

// Weights of a, b, c at the point of the triangle's outline nearest to the ray.
SHARED_FN vec3 nearest_on_outline(ShearedTriangle s) {
    const vec2 ab = nearest_on_edge(s.a, s.b), bc = nearest_on_edge(s.b, s.c), ca = nearest_on_edge(s.c, s.a);
    if (ab.y <= bc.y && ab.y <= ca.y) return vec3(1.0f - ab.x, ab.x, 0.0f);
    return bc.y <= ca.y ? vec3(0.0f, 1.0f - bc.x, bc.x) : vec3(ca.x, 0.0f, 1.0f - ca.x);
}

// t >= 0 and barycentrics of a known hit in world space, the same bits whoever found it. Traversals work in object space or by
// other arithmetic, so the ray may pass the triangle by some roundings or see it edge-on: then the triangle's point nearest to
// the ray is taken. Accurate areas keep the weights right for slivers and grazing rays. Weights are >= 0 and so is 1 - x - y.
SHARED_FN void intersect_canonical(vec3 origin, vec3 direction, vec3 p0, vec3 p1, vec3 p2, SHARED_INOUT(float) t, SHARED_INOUT(vec2) barycentrics) {
    const ShearedRay ray = make_sheared_ray(origin, direction);
    ShearedTriangle s = shear_triangle(ray, p0, p1, p2);
    make_accurate(s, false);
    SHARED_PRECISE const float area = (s.u + s.v) + s.w;
    SHARED_PRECISE vec3 weights = vec3(s.u, s.v, s.w) / area;
    if (!surrounds_ray(s) || area == 0.0f) weights = nearest_on_outline(s);
    SHARED_PRECISE const float distance = ((weights.x * s.a.z + weights.y * s.b.z) + weights.z * s.c.z) * ray.shear.z;
    t = max(distance, 0.0f);
    SHARED_PRECISE const float room = 1.0f - weights.y;
    barycentrics = vec2(weights.y, min(weights.z, room));
}

SHARED_END
#endif
