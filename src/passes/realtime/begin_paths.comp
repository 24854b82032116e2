#version 460
// Begins the paths of a band: at the camera, each with what its pixel's identity says that it meets, sorted for Shade.
// Reads: scene, view, identity. Reads and writes: control, lists (classes). Writes: rays, paths, inside (scenes with layers), hits, sums,
// distances.
// optimised variants
#extension GL_GOOGLE_include_directive : require
#include "realtime/paths.glsl"
#include "scene/begin_path.glsl"
#include "wavefront/classes.glsl"
#include "wavefront/linear.glsl"
#include "wavefront/lists.glsl"

layout(set = 1, binding = 0, rgba32ui) uniform readonly uimage2D identity;
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Hits { WavefrontHit v[]; };
layout(push_constant, scalar) uniform Push {
    ViewBlock view;
    Control control;
    Lists lists;
    Rays rays;
    LightPaths paths;
    Inside inside;
    Hits hits;
    ClassSums sums;
    Distances distances;
    uint has_inside;
} push;

void main() {
    const ViewData view = push.view.data;
    const uint slot = invocation_index();
    uint met = kNone;
    if (slot < push.control.v.pixel_count) {
        const PathKey key = path_key(view, push.control, slot);
        const PathState path = begin_path(view, key);
        const uvec4 which = imageLoad(identity, ivec2(key.pixel));
        const WavefrontHit hit = WavefrontHit(which.x, which.y, which.z);
        met = class_of(hit);
        push.rays.v[slot] = pack_ray(path);
        push.paths.v[slot] = pack_light_path(path, Footprint(RayCone(view.pixel_width, view.pixel_spread), 0.0, false, 0u));
        if (push.has_inside != 0u) push.inside.v[slot] = pack_inside(path);
        push.hits.v[slot] = hit;
        push.sums.v[slot] = WavefrontClassSums(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0));
        push.distances.v[key.pixel.y * view.width + key.pixel.x] = 0u;
    }
    list_append(push.lists, push.control, kListClasses, met, kClassCount, slot);
}
