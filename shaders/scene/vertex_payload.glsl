// How a path and its vertex go through the payload when hit and miss shaders shade (SHADE_IN_HIT). Included where `payload` is
// declared. A path's ray that asks for its vertex says so in the payload's hit, whose other words carry the rest of the question:
// geometry has the pixel, primitive the sample, barycentrics the class of the path, t its density.
#ifndef PARHELION_SCENE_VERTEX_PAYLOAD_GLSL
#define PARHELION_SCENE_VERTEX_PAYLOAD_GLSL
#include "scene/payload.glsl"
#include "scene/vertex.glsl"

const uint kAsksVertex = 0xFFFFFFFEu;  // in Hit::instance_bits: shade the vertex; every other ray is told which triangle

// The class of a path in one word: its bounces and these.
const uint kPayloadTransmitted = 0x80000000u;
const uint kPayloadGoesOn = 0x40000000u;
const uint kPayloadHasEvent = 0x20000000u;
const uint kPayloadBounces = 0x1FFFFFFFu;

uint pack_class(PathClass path_class) { return path_class.bounce | (path_class.transmitted ? kPayloadTransmitted : 0u); }

void ask_vertex(PathKey key, PathState path, FirstHit first) {
    payload.hit = Hit(kAsksVertex, key.pixel.x | key.pixel.y << 16, key.sample_index, pack_class(path.path_class), path.pdf);
    payload.alpha_key = path.ray.alpha_key;
    payload.vertex.throughput = path.throughput;
    payload.vertex.travelled = path.travelled;
    if (path.path_class.bounce == 0u) payload.vertex.first = first;
#ifdef LAYERS
    payload.vertex.radiance_scale = path.radiance_scale;
    payload.vertex.media = path.media;
#endif
}

bool asks_vertex() { return payload.hit.instance_bits == kAsksVertex; }

PathKey asked_key(ViewData view) { return PathKey(uvec2(payload.hit.geometry & 0xFFFFu, payload.hit.geometry >> 16), payload.hit.primitive, view.seed); }

// The path of the question; `ray` as it is traced.
PathState asked_path(Ray ray) {
    PathState path;
    path.ray = ray;
    path.throughput = payload.vertex.throughput;
    path.pdf = payload.hit.t;
    path.travelled = payload.vertex.travelled;
    path.path_class = PathClass(payload.hit.barycentrics & kPayloadBounces, (payload.hit.barycentrics & kPayloadTransmitted) != 0u, vec3(0.0));
    path.cone = kNoCone;
#ifdef LAYERS
    path.radiance_scale = payload.vertex.radiance_scale;
    path.media = payload.vertex.media;
#else
    path.radiance_scale = 1.0;
    path.media = make_medium_stack();
#endif
    return path;
}

void answer_event(NextEvent event) {
    payload.vertex.event_origin_ws = event.ray.origin_ws;
    payload.vertex.event_direction_ws = event.ray.direction_ws;
    payload.vertex.event_reach = event.ray.t_max;
    payload.vertex.event_diffuse = event.value.diffuse;
    payload.vertex.event_specular = event.value.specular;
#ifdef LAYERS
    payload.vertex.event_transmission = event.value.transmission;
#endif
}

// `at_first`: the path came to its first surface.
void answer_vertex(PathState path, VertexResult vertex, bool at_first, FirstHit first) {
    payload.hit.barycentrics = pack_class(path.path_class) | (vertex.goes_on ? kPayloadGoesOn : 0u) | (vertex.event.exists ? kPayloadHasEvent : 0u);
    payload.vertex.arriving = vertex.arriving;
    if (vertex.event.exists) answer_event(vertex.event);
    if (at_first) {
        payload.vertex.diffuse_share = path.path_class.diffuse_share;
        payload.vertex.first = first;
    }
    if (!vertex.goes_on) return;
    payload.hit.t = path.pdf;
    payload.alpha_key = path.ray.alpha_key;
    payload.vertex.throughput = path.throughput;
    payload.vertex.travelled = path.travelled;
    payload.vertex.origin_ws = path.ray.origin_ws;
    payload.vertex.direction_ws = path.ray.direction_ws;
#ifdef LAYERS
    payload.vertex.radiance_scale = path.radiance_scale;
    payload.vertex.media = path.media;
#endif
}

NextEvent take_event(uint alpha_key) {
    NextEvent event;
    event.exists = (payload.hit.barycentrics & kPayloadHasEvent) != 0u;
    if (!event.exists) return event;
    event.ray = Ray(payload.vertex.event_origin_ws, 0.0, payload.vertex.event_direction_ws, payload.vertex.event_reach, alpha_key);
    event.value = BsdfValue(payload.vertex.event_diffuse, payload.vertex.event_specular, vec3(0.0));
#ifdef LAYERS
    event.value.transmission = payload.vertex.event_transmission;
#endif
    return event;
}

// The answer, with the path's next state.
VertexResult take_vertex(PathKey key, inout PathState path, inout FirstHit first) {
    VertexResult vertex;
    const uint bounce = path.path_class.bounce, state = payload.hit.barycentrics;
    vertex.arriving = payload.vertex.arriving;
    vertex.event = take_event(alpha_key(key, bounce, kRayShadow));
    vertex.goes_on = (state & kPayloadGoesOn) != 0u;
    if (bounce == 0u) {
        path.path_class.diffuse_share = payload.vertex.diffuse_share;
        first = payload.vertex.first;
    }
    if (!vertex.goes_on) return vertex;
    path.path_class.bounce = state & kPayloadBounces;
    path.path_class.transmitted = (state & kPayloadTransmitted) != 0u;
    path.pdf = payload.hit.t;
    path.throughput = payload.vertex.throughput;
    path.travelled = payload.vertex.travelled;
    path.ray = Ray(payload.vertex.origin_ws, 0.0, payload.vertex.direction_ws, kInfinity, payload.alpha_key);
#ifdef LAYERS
    path.radiance_scale = payload.vertex.radiance_scale;
    path.media = payload.vertex.media;
#endif
    return vertex;
}
#endif
