#version 460
// Which geometries of which instances are drawn, judged by their boxes. The first pass takes what the camera can see and the last frame's
// depth did not hide, seen as it stood then; the second what the first has left out and this frame's depth, as far as it is drawn, does not
// hide. So nothing that shows is left out, whatever moved. Greene, Kass, Miller 1993, "Hierarchical Z-Buffer Visibility"; Haar and
// Aaltonen 2015, "GPU-Driven Rendering Pipelines" (two passes). All bounds are widened: the tests may only err towards drawing.
// Reads: scene, view, drawn, pyramid, bits. Writes: bits (words of rows: of the first pass, then of the second), counts (the far end).
#extension GL_GOOGLE_include_directive : require
#include "gbuffer/depth_pyramid.glsl"
#include "gbuffer/raster.glsl"
#include "scene/ray.glsl"
#include "scene/scene.glsl"

layout(local_size_x = kRasterGroup) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Pyramid { float v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Bits { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Counts { RasterCounts data; };
layout(push_constant, scalar) uniform Push {
    ViewBlock view;
    DrawnArray drawn;
    Pyramid pyramid;
    Bits bits;
    Counts counts;
    uint row_count;    // a multiple of kRasterGroup
    uint second_pass;  // 0 or 1
    uint has_pyramid;  // 0: the first pass knows no last frame
} push;

shared uint word[2];
shared uint farthest;

// A box as the camera sees it, in the units of to_view().
struct SeenBox {
    bool outside;       // of the picture, or behind the camera
    bool crosses;       // its nearest point is not in front of the camera: what follows says nothing
    vec2 lower, upper;  // on the picture, in [-1, 1] where it shows, y up
    float z_near, z_far;
};

SeenBox see_box(Camera camera, Affine world_from_object, vec3 lower, vec3 upper) {
    SeenBox box = SeenBox(false, false, vec2(3e38), vec2(-3e38), 3e38, -3e38);
    bool left = true, right = true, below = true, above = true;
    const float scale = 1.0 / min(length(camera.right_ws), length(camera.up_ws));
    const vec2 edge = 1.0 + 2.0 / vec2(push.view.data.width, push.view.data.height);  // jittered pixels look past it by half of one
    for (uint i = 0u; i < 8u; ++i) {
        const vec3 corner = mix(lower, upper, bvec3(i & 1u, i & 2u, i & 4u));
        vec3 error;
        const vec3 p = transform_point_precise(world_from_object, corner, vec3(0.0), error);
        const vec3 v = to_view(camera, p), sizes = abs(p) + abs(camera.position_ws);
        const float slack = 2e-6 * (sizes.x + sizes.y + sizes.z), extent = camera.orthographic != 0u ? 1.0 : v.z;
        const float room = slack * (scale + 1.0);
        left = left && v.x < -extent * edge.x - room;
        right = right && v.x > extent * edge.x + room;
        below = below && v.y < -extent * edge.y - room;
        above = above && v.y > extent * edge.y + room;
        box.z_near = min(box.z_near, v.z - slack);
        box.z_far = max(box.z_far, v.z + slack);
        box.lower = min(box.lower, (v.xy - room) / extent);
        box.upper = max(box.upper, (v.xy + room) / extent);
    }
    box.crosses = camera.orthographic == 0u && box.z_near <= 4.0 * kRasterNear;
    box.outside = left || right || below || above || box.z_far < 0.0;
    return box;
}

// The pyramid is of a picture of this size. Pixels are widened by one, so that neither where a corner is rounded to nor how a triangle's
// edge falls on pixels matters; a depth buffer interpolates.
bool hidden(SeenBox box, Camera camera, uvec2 size) {
    if (box.outside || box.crosses) return false;
    const vec2 picture = vec2(size), first = (vec2(box.lower.x, -box.upper.y) + 1.0) * 0.5 * picture, last = (vec2(box.upper.x, -box.lower.y) + 1.0) * 0.5 * picture;
    const uvec2 from = uvec2(clamp(first - 1.0, vec2(0.0), picture - 1.0)), to = uvec2(clamp(last + 1.0, vec2(0.0), picture - 1.0));
    uint level = 1u;
    while (any(greaterThan((to >> level) - (from >> level), uvec2(3u)))) ++level;
    const uint offset = pyramid_offset(size, level), width = pyramid_size(size, level).x;
    float behind = 1.0;
    for (uint y = from.y >> level; y <= to.y >> level; ++y)
        for (uint x = from.x >> level; x <= to.x >> level; ++x) behind = min(behind, push.pyramid.v[offset + y * width + x]);
    const float nearest = camera.orthographic != 0u ? 1.0 - box.z_near / push.pyramid.v[0] + 1e-5 : kRasterNear / box.z_near * 1.0001;
    return nearest < behind;
}

bool drawn_before(uint row) { return (push.bits.v[row >> 5] >> (row & 31u) & 1u) != 0u; }

bool shows(uint row) {
    const ViewData view = push.view.data;
    const DrawnGeometry item = push.drawn.v[row];
    if (item.instance == kNone || (scene_instance(item.instance).mask & kAllInstances) == 0u) return false;
    const Instance instance = scene_instance(item.instance);
    const SeenBox box = see_box(view.camera, instance.world_from_object, item.lower, item.upper);
    if (box.outside) return false;
    const uvec2 size = uvec2(view.width, view.height);
    if (push.second_pass != 0u) return !drawn_before(row) && !hidden(box, view.camera, size);
    if (box.z_far > 0.0) atomicMax(farthest, floatBitsToUint(box.z_far));
    if (push.has_pyramid == 0u) return true;
    return !hidden(see_box(view.camera_before, instance.world_from_object_before, item.lower, item.upper), view.camera_before, size);
}

void main() {
    const uint row = gl_GlobalInvocationID.x, half_of_group = gl_LocalInvocationID.x >> 5;
    if (gl_LocalInvocationID.x < 2u) word[gl_LocalInvocationID.x] = 0u;
    if (gl_LocalInvocationID.x == 0u) farthest = 0u;
    barrier();
    if (row < push.row_count && shows(row)) atomicOr(word[half_of_group], 1u << (row & 31u));
    barrier();
    if (row < push.row_count && (row & 31u) == 0u) push.bits.v[push.second_pass * (push.row_count >> 5) + (row >> 5)] = word[half_of_group];
    // The next power of two: it stays what it is while the scene moves a little.
    if (gl_LocalInvocationID.x == 0u && farthest != 0u) atomicMax(push.counts.data.far_bits, (farthest + 0x7FFFFFu) & 0x7F800000u);
}
