// Ray against triangle: the watertight test of our traversal, and the canonical recomputation of a hit that is already known.
#ifndef PARHELION_LIB_RAY_TRIANGLE_GLSL
#define PARHELION_LIB_RAY_TRIANGLE_GLSL

// A ray prepared for the watertight test: axes permuted so that z is the largest direction component, sheared onto it.
// Woop, Benthin, Wald 2013, "Watertight Ray/Triangle Intersection".
struct ShearedRay {
    vec3 origin;
    ivec3 axes;
    vec3 shear;
};

ShearedRay make_sheared_ray(vec3 origin, vec3 direction) {
    ShearedRay r;
    r.origin = origin;
    const vec3 a = abs(direction);
    r.axes.z = a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
    r.axes.x = r.axes.z == 2 ? 0 : r.axes.z + 1;
    r.axes.y = r.axes.x == 2 ? 0 : r.axes.x + 1;
    if (direction[r.axes.z] < 0.0) r.axes.xy = r.axes.yx;  // keeps the winding
    r.shear = vec3(direction[r.axes.x], direction[r.axes.y], 1.0) / direction[r.axes.z];
    return r;
}

// Edges count as inside for both of their triangles, so no ray slips between them. t and the weights of p1, p2 on a hit.
bool intersect_watertight(ShearedRay ray, vec3 p0, vec3 p1, vec3 p2, float t_min, float t_max, out float t, out vec2 barycentrics) {
    precise const vec3 a = p0 - ray.origin, b = p1 - ray.origin, c = p2 - ray.origin;
    const float az = a[ray.axes.z], bz = b[ray.axes.z], cz = c[ray.axes.z];
    precise const vec2 ap = vec2(a[ray.axes.x], a[ray.axes.y]) - ray.shear.xy * az;
    precise const vec2 bp = vec2(b[ray.axes.x], b[ray.axes.y]) - ray.shear.xy * bz;
    precise const vec2 cp = vec2(c[ray.axes.x], c[ray.axes.y]) - ray.shear.xy * cz;
    precise const float u = cp.x * bp.y - cp.y * bp.x;
    precise const float v = ap.x * cp.y - ap.y * cp.x;
    precise const float w = bp.x * ap.y - bp.y * ap.x;
    if (min(u, min(v, w)) < 0.0 && max(u, max(v, w)) > 0.0) return false;
    precise const float det = (u + v) + w;
    if (det == 0.0) return false;
    precise const float distance = ((u * az + v * bz) + w * cz) * ray.shear.z / det;
    if (!(distance >= t_min && distance < t_max)) return false;
    t = distance;
    barycentrics = vec2(v, w) / det;
    return true;
}

// t and barycentrics of a known hit, in world space, the same bits whoever asks. Cramer's rule on the triangle's edges (Moller
// and Trumbore 1997); weights are clamped into the triangle, so that a grazing ray cannot leave it.
void intersect_canonical(vec3 origin, vec3 direction, vec3 p0, vec3 p1, vec3 p2, out float t, out vec2 barycentrics) {
    precise const vec3 e1 = p1 - p0, e2 = p2 - p0, s = origin - p0;
    precise const vec3 q = vec3(direction.y * e2.z - direction.z * e2.y, direction.z * e2.x - direction.x * e2.z, direction.x * e2.y - direction.y * e2.x);
    precise const vec3 r = vec3(s.y * e1.z - s.z * e1.y, s.z * e1.x - s.x * e1.z, s.x * e1.y - s.y * e1.x);
    precise const float det = (e1.x * q.x + e1.y * q.y) + e1.z * q.z;
    precise const float inv = det != 0.0 ? 1.0 / det : 0.0;
    precise float u = ((s.x * q.x + s.y * q.y) + s.z * q.z) * inv;
    precise float v = ((direction.x * r.x + direction.y * r.y) + direction.z * r.z) * inv;
    precise const float distance = ((e2.x * r.x + e2.y * r.y) + e2.z * r.z) * inv;
    u = clamp(u, 0.0, 1.0);
    v = clamp(v, 0.0, 1.0 - u);
    t = max(distance, 0.0);
    barycentrics = vec2(u, v);
}
#endif
