#version 460
// Temporal reuse: a pixel's new reservoir and the one that its surface had in the last frame become one, weighed by about what their samples
// bring to both surfaces, hidden or not.
// Reads: scene, view, summary, depth, motion, summary_before, depth_before, history. Reads and writes: reservoirs (its own); diffuse, specular, if they
// hold what paths were offered.
// variants: LAYERS
#extension GL_GOOGLE_include_directive : require
#include "realtime/offered.glsl"
#include "reuse/site.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 1, binding = 0, rgba32ui) uniform readonly uimage2D summary;
layout(set = 1, binding = 1, r32f) uniform readonly image2D depth;
layout(set = 1, binding = 2, rg32f) uniform readonly image2D motion;
layout(set = 1, binding = 3, rgba32ui) uniform readonly uimage2D summary_before;
layout(set = 1, binding = 4, r32f) uniform readonly image2D depth_before;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer History { PackedReservoir v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Light { PackedLight v[]; };
layout(push_constant, scalar) uniform Push {
    ViewBlock view;
    Reservoirs reservoirs;
    History history;
    Light diffuse, specular;
    ReuseFrame frame;
} push;
#include "reuse/before.glsl"

// The surface as the last frame saw it; false: it did not.
bool find_site_before(ViewData view, uvec2 id, Site here, out ivec2 before, out Site there) {
    if (!find_before(view, id, imageLoad(motion, ivec2(id)).xy, before)) return false;
    const uvec4 seen = imageLoad(summary_before, before);
    if (!sees_surface(seen)) return false;
    there = site_at(view.camera_before, view.jitter_before, vec2(view.width, view.height), before, seen, imageLoad(depth_before, before).x);
    return here.number == there.number && dot(here.normal_ws, there.normal_ws) >= kLeastSimilarCosine;
}

// What the path was offered counts for as much more or less as its sample does.
void scale_offered(ViewData view, uvec2 id, float by) {
    const uint kScaleSalt = 0x53434F46u, pixel = id.y * view.width + id.x;
    const uvec4 random = pcg4d(uvec4(pixel, push.frame.frame_index, view.seed ^ kScaleSalt, 0u));
    const PackedLight diffuse = push.diffuse.v[pixel], specular = push.specular.v[pixel];
    push.diffuse.v[pixel] = pack_parts(own_light(diffuse), offered_light(diffuse) * by, random);
    push.specular.v[pixel] = pack_parts(own_light(specular), offered_light(specular) * by, random.wzyx * 0x9E3779B9u);
}

void main() {
    const uvec2 id = gl_GlobalInvocationID.xy;
    const ViewData view = push.view.data;
    if (id.x >= view.width || id.y >= view.height) return;
    const uvec4 seen = imageLoad(summary, ivec2(id));
    if (!sees_surface(seen)) return;
    const uint at = reservoir_of(view, push.frame, id);
    Reservoir own = unpack_reservoir(push.reservoirs.v[at]), history = kEmptyReservoir;
    const Site here = site_at(view.camera, view.jitter, vec2(view.width, view.height), ivec2(id), seen, imageLoad(depth, ivec2(id)).x);
    Site there;
    ivec2 before;
    const bool recalls = find_site_before(view, id, here, before, there);
    if (recalls) history = recall(view, before);
    // The weights of what the frame's path offered have been added up; now the reservoir gets its W. What found nothing has looked, too.
    own.confidence = 1u;
    own.weight = own.target > 0.0 ? own.weight / own.target : 0.0;
    float targets[3] = float[](0.0, 0.0, 0.0);
    for (uint i = 0u; i < (recalls ? 3u : 1u); ++i) {  // a loop, so that what is long is compiled once: own sample here, the other's here, own sample there
        LightSampleRef y = own.point;
        if (i == 1u) y = history.point;
        Site site = here;
        if (i == 2u) site = there;
        targets[i] = i == 2u && is_new(y) ? 0.0 : about_brought(y, site, i == 2u ? kBefore : kNow).target;
    }
    own.target = targets[0];
    const float weight = own.weight;
    const bool takes = recalls && merge_reservoirs(own, history, targets[1], targets[2], reuse_number(view, id, push.frame));
    if (push.frame.keeps_offered != 0u && recalls && !takes && own.target > 0.0 && weight > 0.0) scale_offered(view, id, own.weight / weight);
    store_reservoir(push.reservoirs, at, own);
}
