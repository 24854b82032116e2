// Ray cones: how much of a texture a path sees at a hit, so that it reads the level whose texels have that size.
// Akenine-Moller et al. 2019, "Texture Level of Detail Strategies for Real-Time Ray Tracing" (Ray Tracing Gems, 20), and 2021,
// "Improved Shader and Texture Level of Detail Using Ray Cones" (JCGT 10, 1). Pure functions.
#ifndef PARHELION_LIB_RAY_CONE_GLSL
#define PARHELION_LIB_RAY_CONE_GLSL

// At distance t a cone is width + t * spread wide: metres, radians. A negative width: no cone, textures are read at full
// resolution.
struct RayCone {
    float width, spread;
};
const RayCone kNoCone = RayCone(-1.0, 0.0);

// What a diffuse lobe adds, and the most that any does; chosen. (A cosine lobe's standard deviation per axis is half a radian.)
const float kWidestSpread = 1.0;

bool has_cone(RayCone cone) { return cone.width >= 0.0; }
float cone_width(RayCone cone, float t) { return cone.width + cone.spread * t; }

// The level of a texture of one texel (2019, "Ray Cones"): its texel against the cone's ellipse on the triangle. Both areas are of the
// same triangle, doubled or not; `cosine` between normal and ray.
float cone_level(float area_uv, float area_ws, float width, float cosine) {
    const float kTiny = 1e-30;
    return 0.5 * log2(max(area_uv, kTiny) / max(area_ws, kTiny)) + log2(max(width, kTiny) / max(abs(cosine), 1e-6));
}

// The same of a texture of so many texels, seen through a transform of the UVs that scales areas by `area_scale`.
float texture_level(float level, float width, float height, float area_scale) { return level + 0.5 * log2(max(width * height * area_scale, 1e-30)); }

// What a GGX lobe adds to the spread, which is a full width: a standard deviation to either side. Its variance is alpha^2 /
// (2 (1 - alpha^2)) (2021, section 4 and appendix A); the cap is ours. The curvature of surfaces (2021, section 3) adds nothing
// here: in a path tracer a cone that is too narrow only costs samples, one that is too wide blurs.
float lobe_spread(float alpha) {
    const float a2 = alpha * alpha;
    return min(2.0 * sqrt(0.5 * a2 / max(1.0 - a2, 1e-6)), kWidestSpread);
}

// The cone after scattering at distance t.
RayCone scatter_cone(RayCone cone, float t, float added_spread) {
    if (!has_cone(cone)) return cone;
    return RayCone(cone_width(cone, t), cone.spread + added_spread);
}
#endif
