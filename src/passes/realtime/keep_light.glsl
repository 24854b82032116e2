// The part of Shade that keeps a vertex' light: in the signals and the film's layers at once, or for Connect until its shadow ray is traced.
// Uses Shade's push constants and its globals.
#ifndef PARHELION_REALTIME_KEEP_LIGHT_GLSL
#define PARHELION_REALTIME_KEEP_LIGHT_GLSL

// The class in the film's layers: by the first surface, whatever surface the signals are of.
PathClass film_class(PathClass path_class, uint lobes) { return PathClass(path_class.bounce, path_class.transmitted, (lobes & kLobeBehind) != 0u ? vec3(0.0) : path_class.diffuse_share); }

// Whether light that arrives is seen straight, and else, which share of it the diffuse signal has.
bool is_seen_straight(PathClass path_class, uint lobes) { return push.frame.follows != 0u ? (lobes & kLobeStraight) != 0u : path_class.bounce == 0u && !path_class.transmitted; }
vec3 diffuse_share(PathClass path_class) { return push.frame.follows == 0u && path_class.transmitted ? vec3(0.0) : path_class.diffuse_share; }

// Light that is there without a shadow ray.
void keep_arriving(ViewData view, uint slot, uint pixel, PathClass path_class, PathClass cached_class, uint lobes, vec3 arriving) {
    if (push.round == 0u) {
        push.sums.v[slot] = LightSums(vec3(0.0), vec3(0.0));
        push.emission.v[pixel] = pack_light(vec3(0.0));
    }
    if (arriving == vec3(0.0) && from_cache == vec3(0.0)) return;
    if (is_seen_straight(path_class, lobes)) push.emission.v[pixel] = pack_light(unpack_light(push.emission.v[pixel]) + arriving * push.frame.exposure);
    else {
        const vec3 share = diffuse_share(path_class), of_cached = diffuse_share(cached_class);
        add_light(push.sums, slot, share * arriving + of_cached * from_cache, (1.0 - share) * arriving + (1.0 - of_cached) * from_cache);
    }
    PathRadiance light = make_path_radiance();
    add_arriving(light, film_class(path_class, lobes), arriving);
    add_sampled(light, film_class(cached_class, lobes), from_cache, kNoBsdfValue);
    film_add_path_classes(push.block, view, pixel, light);
}

// For Connect: the shadow ray, and what it brings.
void keep_event(uint slot, uint pixel, PathClass path_class, uint lobes, NextEvent event) {
    push.shadow_rays.v[slot] = WavefrontShadowRay(event.ray.origin_ws, event.ray.t_max, event.ray.direction_ws, event.ray.alpha_key);
    // A direction lies before the surface or behind it: what goes through comes alone.
    const bool through = path_class.transmitted || (path_class.bounce == 0u && event.value.transmission != vec3(0.0));
    const bool behind = (lobes & (kLobeBehind | kLobeStraight)) != 0u && path_class.bounce != 0u;
    const uint kind = through ? kLightTransmitted : behind ? kLightReflected : path_class.bounce == 0u ? kLightDirect : kLightIndirect;
    vec3 diffuse = event.value.diffuse, specular = event.value.specular + event.value.transmission;
    if (!is_seen_straight(path_class, lobes)) {
        const vec3 share = diffuse_share(path_class), sum = total(event.value);
        diffuse = share * sum;
        specular = (1.0 - share) * sum;
    }
    LightPending pending = LightPending(diffuse, pixel, specular, kind);
#ifdef REUSE
    if (asks_for_others) pending = LightPending(asked_brings.diffuse, pixel, asked_brings.specular, kLightOffered);
#endif
    push.pending.v[slot] = pending;
}
#endif
