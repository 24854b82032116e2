#version 460
// Test shader: levels of detail by ray cones. Reads: queries. Writes: levels (texture level, spread that a lobe of `alpha` adds).
#extension GL_GOOGLE_include_directive : require
#include "lib/ray_cone.glsl"
#include "shared/types.h"

struct Query {
    float pixel_width, pixel_spread, t, cosine, area_uv, area_ws, side, area_scale, alpha;  // side: of a square texture, texels
};
layout(local_size_x = 64) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Queries { Query v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Levels { vec2 v[]; };
layout(push_constant, scalar) uniform Push {
    Queries queries;
    Levels levels;
    uint count;
} push;

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    const Query q = push.queries.v[i];
    const float width = cone_width(RayCone(q.pixel_width, q.pixel_spread), q.t);
    push.levels.v[i] = vec2(texture_level(cone_level(q.area_uv, q.area_ws, width, q.cosine), q.side, q.side, q.area_scale), lobe_spread(q.alpha));
}
