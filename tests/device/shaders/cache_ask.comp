#version 460
// World cache test: given points ask, claim (life > 0) and are told what a view would see.
// Reads: asks. Reads and writes: cache. Writes: answers.
#extension GL_GOOGLE_include_directive : require
#include "scene/cache_ask.glsl"

struct Ask {
    vec3 position_ws, n_ws, back_ws;
    uint owner;
    float footprint, u;
    uint life;
};
struct Answer {
    vec3 irradiance;
    uint known, id, level, count, age, life;
};

layout(local_size_x = 64) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Asks { Ask v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Answers { Answer v[]; };
layout(push_constant, scalar) uniform Push {
    Asks asks;
    Answers answers;
    Cache cache;
    uint count;
} push;

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    const Ask ask = push.asks.v[i];
    const CachePoint at = CachePoint(ask.position_ws, ask.position_ws, ask.n_ws, ask.back_ws, ask.owner, ask.footprint, ask.u);
    const CacheView view = cache_look(push.cache, at);
    Answer answer;
    answer.known = uint(cache_visit(push.cache, at, ask.life, answer.irradiance));
    answer.id = view.id;
    answer.level = view.level;
    answer.count = view.count;
    answer.age = view.age;
    answer.life = view.life;
    push.answers.v[i] = answer;
}
