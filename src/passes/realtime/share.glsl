// The part of Shade that shares a path's light with other pixels (REUSE): notes its second vertex, and hands what may be shared to the pixel's
// reservoir. Uses Shade's push constants and its globals.
#ifndef PARHELION_REALTIME_SHARE_GLSL
#define PARHELION_REALTIME_SHARE_GLSL

LightReuse second = kNoReuse;
vec3 cached = vec3(0.0);                // what the cache knew, as it leaves the second vertex
LightSampleRef asked = kNoSampleRef;    // what the shadow ray offers, if it is free,
float asked_density = 1.0;              // with which it was found,
bool asked_rough = false;               // whether the first surface lets others have the light of all its lobes,
vec3 asked_share = vec3(0.0);           // and the share of its light that the second vertex lets others have;
LightSums asked_brings = LightSums(vec3(0.0), vec3(0.0));  // what that brings to the pixel,
bool asks_for_others = false;           // and nothing is left of it that is the path's
float arrived = 1.0;                    // the throughput's largest part as the path came here,
vec3 prefix = vec3(1.0);                // and what it lacks

bool is_second() { return (second.bits & kReuseSecond) != 0u; }

// The path comes to its next vertex. Roulette there is by its whole throughput: gives what that takes, to be undone after it.
float begin_sharing(ViewData view, PathKey key, uint slot, inout PathState path) {
    if (push.round == 0u) {
        clear_reservoirs(push.reservoirs, view, key.pixel, key.sample_index, push.frame.reservoir_sets);
        push.offered.v[slot] = LightSums(vec3(0.0), vec3(0.0));
    } else second = push.reuse.v[slot];
    arrived = max_component(path.throughput);
    prefix = second.prefix;
    const float of_roulette = arrived / max(max_component(second.prefix * path.throughput), 1e-30);
    path.radiance_scale *= of_roulette;
    return of_roulette;
}

// Of a path that left its first surface with the density that it keeps, which stands against all candidates: per area of what it met.
float area_density(float pdf, float t, float facing) {
    return pdf * (push.frame.tiles != 0u ? float(push.frame.candidates) : 1.0) * facing / (t * t);
}

// The surface is what the path left the first one for.
void note_second(PathState path, Shading shading) {
    const Surface s = shading.s;
    if (push.round != 1u || (second.bits & kReuseFirst) == 0u || !may_share(s) || !is_packable(s.geometry) || is_too_near(s.t * s.t, s.extent_ws)) return;
    second.instance = s.instance;
    second.number = s.primitive;
    second.place = pack_place(s.barycentrics);
    second.density = area_density(path.pdf, s.t, abs(dot(shading.n_geometric_ws, path.ray.direction_ws)));
    if (second.density <= 0.0) return;
    second.bits |= s.geometry | kReuseSecond | (s.front_facing ? kReuseFront : 0u);
}

// What the light sample of a vertex is to others. `path`: as it stands before it scatters.
void note_event(PathState path, Shading shading, NextEvent event) {
    if (!event.exists) return;
    if (push.round == 1u && is_second()) {
        asked = sample_at_second(second, kSampleReconnection, event.ray.direction_ws, max_component(path.throughput) / arrived * event.light);
        asked_density = second.density;
        const vec3 shares = total(shared_value(event.value, is_rough(shading.s))), all = total(event.value);
        asked_share = mix(shares / max(all, vec3(1e-30)), vec3(1.0), equal(shares, all));  // exactly 1 where nothing else is
    } else if (is_second()) {
        asked = sample_at_second(second, kSampleReconnection, unpack_direction(second.direction), total(event.value));
        asked_density = second.density;
        asked_share = second.share;
    }
}

// The path has left its first surface, or its second: from there on its throughput is that of what lies behind. `factor`: of the path before it
// scattered; `density`: of the direction.
void note_scattering(inout PathState path, Shading shading, float factor, float density, vec3 diffuse_share) {
    if (push.round == 0u && may_share(shading.s) && path.pdf > 0.0 && !path.path_class.transmitted) second.bits |= kReuseFirst | (is_rough(shading.s) ? kReuseRough : 0u);
    if (push.round != 1u || !is_second()) return;
    if (path.pdf <= 0.0 || density <= 0.0) {
        second.bits &= ~kReuseSecond;
        return;
    }
    second.share = is_rough(shading.s) ? vec3(1.0) : diffuse_share;
    second.direction = pack_direction(path.ray.direction_ws);
    second.prefix = path.throughput * (density / factor);
    path.throughput = vec3(factor / density);
}

// A sample with what it brings to the pixel, and the density with which it was found.
struct Offer {
    LightSampleRef point;
    LightSums brings;
    float density;
};

void offer_now(ViewData view, PathKey key, uint slot, Offer o, uint which) {
    const float weight = luminance(o.brings.diffuse + o.brings.specular);
    if (!(weight > 0.0)) return;
    const uint pixel = key.pixel.y * view.width + key.pixel.x;
    offer(push.reservoirs, reservoir_of(view, pixel, o.point.kind, push.frame.reservoir_sets), pack_sample(o.point, 1u), weight, weight * o.density,
          offer_number(key.pixel, key.sample_index, key.seed, push.round, which));
    add_light(push.offered, slot, o.brings.diffuse, o.brings.specular);
}

void keep_second(uint slot) {
    push.reuse.v[slot].prefix = second.prefix;
    push.reuse.v[slot].share = second.share;
    push.reuse.v[slot].direction = second.direction;
    push.reuse.v[slot].instance = second.instance;
    push.reuse.v[slot].number = second.number;
    push.reuse.v[slot].place = second.place;
    push.reuse.v[slot].bits = second.bits;
    push.reuse.v[slot].density = second.density;
}

LightSampleRef emitter_sample(WavefrontHit met, vec2 barycentrics, vec3 radiance) {
    LightSampleRef y = kNoSampleRef;
    y.kind = kSampleEmitter;
    y.flags = kSampleSeen;
    y.reference = met.instance_bits & kHitInstanceMask;
    y.geometry = met.geometry;
    y.number = met.primitive;
    y.place = pack_place(barycentrics);
    y.radiance = radiance;
    return y;
}

// What of the arriving light may be shared goes to the reservoir.
void share_arriving(ViewData view, PathKey key, uint slot, WavefrontHit met, vec3 came_by, float came_with, inout VertexResult vertex, inout PathClass path_class) {
    if (push.round == 0u) return;
    const vec3 light = vertex.arriving;
    vertex.arriving *= prefix;
    if (light == vec3(0.0)) return;
    const bool behind = path_class.bounce >= 2u && is_second(), sky = met.instance_bits == kHitMiss;
    const bool there = !behind && push.round == 1u && (second.bits & kReuseFirst) != 0u && (sky || (is_packable(met.geometry) && !is_too_near(vertex.t * vertex.t, vertex.extent)));
    if (!behind && !there) return;
    Offer o;
    o.brings = take_shared(vertex.arriving, path_class, second, behind ? second.share : vec3(1.0));
    o.density = behind ? second.density : sky ? area_density(came_with, 1.0, 1.0) : area_density(came_with, vertex.t, vertex.facing);
    if (behind) o.point = sample_at_second(second, kSampleReconnection, unpack_direction(second.direction), light);
    else if (sky) o.point = sample_of_direction(kSampleOutside, scene.header.environment.emitter, came_by, light);
    else o.point = emitter_sample(met, vertex.barycentrics, light);
    offer_now(view, key, slot, o, 0u);
}

// And of what the cache knows.
void share_cached(ViewData view, PathKey key, uint slot, inout PathClass path_class) {
    from_cache *= prefix;
    if (from_cache == vec3(0.0) || !is_second()) return;
    const bool here = push.round == 1u;
    const LightSums taken = take_shared(from_cache, path_class, second, here ? vec3(1.0) : second.share);
    offer_now(view, key, slot, Offer(sample_at_second(second, here ? kSampleRadiosity : kSampleReconnection, unpack_direction(second.direction), cached), taken, second.density), 1u);
}

// And of a light sample, with its shadow ray.
void share_event(uint slot, inout NextEvent event, inout PathClass path_class) {
    if (asked.kind == kSampleNone) event.value = scale(event.value, prefix);
    else if (push.round == 0u) {
        const BsdfValue value = shared_value(event.value, asked_rough);
        asked_brings = LightSums(value.diffuse, value.specular);
        event.value.diffuse -= value.diffuse;
        event.value.specular -= value.specular;
    } else {
        vec3 light = prefix * total(event.value);
        asked_brings = take_shared(light, path_class, second, asked_share);
        event.value = BsdfValue(light, vec3(0.0), vec3(0.0));
    }
    const float weight = luminance(asked_brings.diffuse + asked_brings.specular);
    asks_for_others = weight > 0.0 && total(event.value) == vec3(0.0);
    push.offers.v[slot].weight = weight;
    push.offers.v[slot].target = weight * asked_density;
    if (!(weight > 0.0)) return;
    const PackedSample point = pack_sample(asked, 1u);
    STORE_SAMPLE(push.offers.v[slot].point, point)
    if (!asks_for_others) push.brings.v[slot] = asked_brings;
}
#endif
