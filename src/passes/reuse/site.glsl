// A pixel's surface by its summary alone, and about how much a sample lights it. What reservoirs are weighed by may be any positive number
// where the sample lights the surface at all, as long as it is the same one for all who are weighed: what is kept is then lit exactly
// (reuse/light.comp). So no triangle or texture of the surface is read, and a point's own scattering is taken to be diffuse.
#ifndef PARHELION_REUSE_SITE_GLSL
#define PARHELION_REUSE_SITE_GLSL
#include "realtime/demodulate.glsl"
#include "reuse/reservoirs.glsl"
#include "shared/realtime.h"

struct Site {
    vec3 position_ws, normal_ws, wo_ws;
    float diffuse, glossy, alpha;  // luminance of the surface's colours; glossy 0: its other lobes share nothing
    uint number;                   // of its instance and geometry, 16 bits
    float distance;                // metres from the camera
};

bool sees_surface(uvec4 summary) { return summary.z >> kSummaryIdShift != 0u; }

// As one frame's camera saw it. The reversed depth is of the pixel's ray.
Site site_at(Camera camera, vec2 jitter, vec2 size_px, ivec2 at, uvec4 summary, float reversed) {
    const Ray ray = camera_ray(camera, vec2(at) + 0.5 + jitter, size_px, 0u);
    const float along = camera.orthographic != 0u ? 1.0 / reversed - 1.0 : kDepthNear / reversed;
    const Demodulation colors = demodulation(summary);
    const float roughness = unpackUnorm4x8(summary.x).a;
    Site site;
    site.distance = along / dot(ray.direction_ws, camera.forward_ws);
    site.position_ws = ray.origin_ws + ray.direction_ws * site.distance;
    site.normal_ws = unpack_direction_24(summary.w >> 8);
    site.wo_ws = -ray.direction_ws;
    site.diffuse = luminance(colors.diffuse);
    site.glossy = luminance(colors.specular);
    site.alpha = max(roughness * roughness, 0.05);
    site.number = summary.z >> kSummaryIdShift;
    return site;
}

// Value times cosine, about. Never 0.
float about_scattered(Site site, vec3 wi_ws, bool glossy) {
    const float kLeastCosine = 0.02;
    const float cosine = max(dot(site.normal_ws, wi_ws), kLeastCosine);
    const float diffuse = (site.diffuse + 1e-3) / kPi * cosine;
    if (!glossy) return diffuse;
    const float of_half = max(dot(site.normal_ws, normalize(site.wo_ws + wi_ws)), 0.0), a2 = site.alpha * site.alpha;
    const float spread = of_half * of_half * (a2 - 1.0) + 1.0;
    return diffuse + site.glossy * a2 / (4.0 * kPi * spread * spread);
}

// What a sample brings to a surface, about: luminance in the measure of its kind; and where it is seen from there.
struct Brought {
    float target;
    vec3 wi_ws;
    float t;  // metres
};

Brought about_brought(LightSampleRef y, Site site, uint moment) {
    Brought brought = Brought(0.0, y.direction, kInfinity);
    if (y.kind == kSampleNone) return brought;
    const bool glossy = site.alpha >= kRoughEnoughToShare * kRoughEnoughToShare;
    if (y.kind == kSampleLight) {
        const LightSample light = sample_light(LightPick(y.reference, y.number, 1.0), site.position_ws, vec4(unpack_place(y.place), 0.0, 0.0));
        if (light.pdf <= 0.0) return brought;
        brought.wi_ws = light.wi;
        if (!light.infinite) brought.t = distance(light.target_ws, site.position_ws);
        brought.target = about_scattered(site, light.wi, glossy) * luminance(light.radiance) * shone(y, moment) / light.pdf;
        return brought;
    }
    if (is_direction(y.kind)) {
        brought.target = about_scattered(site, y.direction, glossy) * luminance(y.radiance) * shone(y, moment);
        return brought;
    }
    vec3 way, normal;
    if (!find_point(y, site.position_ws, moment, way, normal)) return brought;
    const float kLeastFacing = 1e-3, squared = dot(way, way);
    brought.t = sqrt(squared);
    brought.wi_ws = way / brought.t;
    const vec3 n = normal / max(length(normal), 1e-30);
    float leaving = luminance(y.radiance) * shone(y, moment);
    if (y.kind == kSampleReconnection) leaving *= max(abs(dot(n, y.direction)), 0.05) / kPi;
    brought.target = about_scattered(site, brought.wi_ws, glossy) * leaving * max(abs(dot(n, brought.wi_ws)), kLeastFacing) / squared;
    return brought;
}
#endif
