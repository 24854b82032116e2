// A vertex of a path: what the surface that a ray met adds, which light it asks for, and where the path goes on. No ray is traced
// here, so raygen, a compute shader or a closest-hit shader may call it.
#ifndef PARHELION_SCENE_VERTEX_GLSL
#define PARHELION_SCENE_VERTEX_GLSL
#include "lib/mis.glsl"
#include "scene/lights.glsl"
#include "scene/panes.glsl"
#include "scene/path_state.glsl"
#include "scene/vertex_numbers.glsl"

const uint kLightSamplingMis = 0u;
const uint kLightSamplingOnly = 1u;
const uint kBsdfSamplingOnly = 2u;

// One light sample: its ray, and what it adds, throughput included, if the ray is free.
struct NextEvent {
    Ray ray;
    BsdfValue value;
    vec3 light;  // radiance over density, with the weight of MIS: what the BSDF and the throughput are not in yet
    bool exists;
};

// What a vertex gives back besides the path's new state.
struct VertexResult {
    vec3 arriving;    // radiance that the path's ray brought here, throughput and MIS weight included
    NextEvent event;
    bool goes_on;     // the path has a next ray
    float t;          // metres to what the path's ray met
    vec2 barycentrics;  // of that,
    float facing;     // the cosine of the ray to its plane,
    float extent;     // and how long its triangle is (Surface)
};

// MIS weight of light reached by the last BSDF sample, which light sampling would have found with light_pdf.
float arriving_weight(PathState path, uint mode, float light_pdf) {
    if (path.pdf < 0.0 || light_pdf <= 0.0) return 1.0;
    if (mode == kLightSamplingOnly) return 0.0;
    return mode == kBsdfSamplingOnly ? 1.0 : mis_power_heuristic(path.pdf, light_pdf);
}

vec3 arriving_environment(PathState path, uint mode) {
    const uint emitter = scene.header.environment.emitter;
    if (emitter == kNone) return vec3(0.0);
    const float weight = path.pdf < 0.0 ? 1.0 : arriving_weight(path, mode, pdf_light_environment(path.ray.direction_ws));
    return weight * environment_radiance(path.ray.direction_ws);
}

// The disks of suns that the ray meets.
vec3 arriving_suns(PathState path, uint mode) {
    vec3 sum = vec3(0.0);
    for (uint i = 0u; i < scene.header.sun_count; ++i) {
        const uint emitter = UintArray(scene.header.suns).v[i];
        const Emitter sun = scene_emitter(emitter);
        if (in_sun(sun, path.ray.direction_ws)) sum += arriving_weight(path, mode, pdf_light_sun(emitter, sun)) * sun_radiance(sun);
    }
    return sum;
}

vec3 arriving_emission(PathState path, Surface s, uint mode) {
    if (s.emission == vec3(0.0)) return vec3(0.0);
    const uint emitter = surface_emitter(s);
    const float light_pdf = emitter == kNone || path.pdf < 0.0 ? 0.0 : pdf_light(emitter, s, path.travelled + s.t, path.ray.direction_ws);
    return arriving_weight(path, mode, light_pdf) * s.emission;
}

// The ray left the scene.
VertexResult end_in_sky(ViewData view, PathState path, inout FirstHit first) {
    VertexResult result;
    result.event.exists = false;
    result.goes_on = false;
    result.t = kInfinity;
    result.barycentrics = vec2(0.0);
    result.facing = 1.0;
    result.extent = 0.0;
    result.arriving = path.throughput * (arriving_environment(path, view.light_sampling) + arriving_suns(path, view.light_sampling));
    if (kLayers) result.arriving *= medium_transmittance(medium_there(path.media), kInfinity);
    if (path.path_class.bounce == 0u && !path.path_class.transmitted) first.emission = result.arriving;
    result.arriving *= firefly_share(view, path.path_class.bounce, result.arriving);
    return result;
}

// The surface as the path scatters there: in its shading frame, wo towards where the path came from, on the side of +z.
struct Shading {
    Surface s;
    mat3 frame;
    vec3 wo;
    vec3 n_geometric_ws;  // on wo's side
    Bsdf bsdf;
    Outgoing outgoing;    // wo, as the BSDF is asked from there
    MediumBoundary boundary;  // what lies behind the surface
};

// Both normals on the side of wo.
vec3 shading_normal(ViewData view, vec3 n_shading, vec3 n_geometric, vec3 wo) {
    return (view.flags & kViewNormalCorrection) != 0u ? bend_normal(n_shading, n_geometric, wo) : n_shading;
}

Shading make_shading(ViewData view, PathState path, Surface s, MediumBoundary boundary) {
    Shading shading;
    const float side = s.front_facing ? 1.0 : -1.0;
    const vec3 wo_ws = -path.ray.direction_ws;
    shading.s = s;
    shading.s.scattering.eta = boundary.eta;
    shading.s.scattering.inside = !s.front_facing;
    shading.boundary = boundary;
    shading.n_geometric_ws = side * s.n_geometric_ws;
    shading.frame = make_frame(shading_normal(view, side * s.n_shading_ws, shading.n_geometric_ws, wo_ws));
    shading.wo = wo_ws * shading.frame;
    const bool coated = kLayers && s.scattering.coat > 0.0;
    const vec3 coat_normal = coated ? shading_normal(view, side * s.n_coat_ws, shading.n_geometric_ws, wo_ws) * shading.frame : vec3(0.0, 0.0, 1.0);
    shading.bsdf = make_bsdf(shading.s.scattering, coat_normal, (view.flags & kViewEnergyCompensation) != 0u, scene.header.bsdf_tables);
    shading.outgoing = look_from(shading.bsdf, shading.wo);
    return shading;
}

// A direction that the shading normal puts on one side of the surface and the real surface on the other carries nothing.
bool sides_agree(Shading shading, vec3 wi, vec3 wi_ws) { return (wi.z > 0.0) == (dot(wi_ws, shading.n_geometric_ws) > 0.0); }

MediumStack media_behind(PathState path, Shading shading, vec3 wi) {
    return wi.z < 0.0 && !shading.s.scattering.thin ? shading.boundary.beyond : path.media;
}

// MIS weight of a light sample, which the BSDF would have found with `bsdf_pdf`; no ray can hit a delta light.
float light_sample_weight(uint mode, LightSample light, float bsdf_pdf) {
    if (light.is_delta || mode == kLightSamplingOnly) return 1.0;
    return mode == kBsdfSamplingOnly ? 0.0 : mis_power_heuristic(light.pdf, bsdf_pdf);
}

// The ray that must be free for it.
Ray light_sample_ray(Surface s, LightSample light, uint alpha_key) {
    Ray ray = spawn_ray(s, light.wi, kInfinity, alpha_key);
    if (light.infinite) return ray;
    const vec3 to_target = light.target_ws - ray.origin_ws;
    ray.t_max = length(to_target) * (1.0 - 4e-7);
    ray.direction_ws = normalize(to_target);
    return ray;
}

// What a light sample adds to the path if its ray is free. `bsdf_share`: how many BSDF samples there are for each light sample that it
// was chosen from, for the weight of MIS.
NextEvent next_event(ViewData view, PathState path, Shading shading, LightSample light, float bsdf_share, uint alpha_key) {
    NextEvent event;
    event.exists = false;
    if (light.pdf <= 0.0) return event;
    const vec3 wi = light.wi * shading.frame;
    if (!sides_agree(shading, wi, light.wi)) return event;
    const BsdfTerms terms = evaluate_bsdf(shading.bsdf, shading.outgoing, wi);
    const BsdfValue value = terms.value;
    if (max_component(total(value)) <= 0.0) return event;
    event.light = light.radiance * (light_sample_weight(view.light_sampling, light, terms.pdf * bsdf_share) / light.pdf);
    event.ray = light_sample_ray(shading.s, light, alpha_key);
    if (kLayers) event.light *= medium_transmittance(medium_there(media_behind(path, shading, wi)), event.ray.t_max);
    vec3 arriving = path.throughput * event.light;
    arriving *= firefly_share(view, path.path_class.bounce, arriving * total(value));
    event.value = BsdfValue(arriving * value.diffuse, arriving * value.specular, arriving * value.transmission);
    event.exists = max_component(total(event.value)) > 0.0;
    return event;
}

NextEvent sample_next_event(ViewData view, PathState path, Shading shading, vec4 u_pick, vec4 u_light, uint alpha_key) {
    const LightPick pick = pick_light(shading.s.position_ws, shading.s.n_geometric_ws, u_pick);
    return next_event(view, path, shading, sample_light(pick, shading.s.position_ws, u_light), 1.0, alpha_key);
}

// The variant RAY_CONES reads textures as finely as the path sees them (texture.lod=cone); without it cones cost nothing.
#ifdef RAY_CONES
RayCone first_cone(ViewData view) { return RayCone(view.pixel_width, view.pixel_spread); }
RayCone next_cone(RayCone cone, float t, uint lobe, Bsdf bsdf) { return scatter_cone(cone, t, lobe == kLobeDiffuse ? kWidestSpread : lobe_spread(bsdf.alpha)); }
RayCone passing_cone(RayCone cone, float t) { return scatter_cone(cone, t, 0.0); }
#else
RayCone first_cone(ViewData view) { return kNoCone; }
RayCone next_cone(RayCone cone, float t, uint lobe, Bsdf bsdf) { return kNoCone; }
RayCone passing_cone(RayCone cone, float t) { return kNoCone; }
#endif

// Continues the path by the BSDF, u = (lobe, direction); false: it ends here. without diffuse: only what other lobes scatter goes on.
// splits: the path's light is split by the lobes of this surface.
bool scatter(inout PathState path, Shading shading, vec3 u, bool diffuse, bool splits, uint alpha_key) {
    BsdfSample next = sample_bsdf(shading.bsdf, shading.outgoing, u.x, u.yz);
    if (!diffuse) next.weight.diffuse = vec3(0.0);
    if (next.lobe == kLobeNone) return false;
    const vec3 wi_ws = shading.frame * next.wi;
    if (!sides_agree(shading, next.wi, wi_ws)) return false;
    const vec3 weight = total(next.weight);
    if (splits) {
        // Exactly 1 where nothing else is, whatever the device makes of a quotient.
        path.path_class.diffuse_share = mix(next.weight.diffuse / max(weight, vec3(1e-30)), vec3(1.0), equal(next.weight.diffuse, weight));
    }
    if (path.path_class.bounce == 0u) path.path_class.transmitted = path.path_class.transmitted || next.wi.z < 0.0;
    path.throughput *= weight;
    path.pdf = next.pdf;
    path.path_class.bounce += 1u;
    path.travelled = 0.0;
    path.ray = spawn_ray(shading.s, normalize(wi_ws), kInfinity, alpha_key);
    path.cone = next_cone(path.cone, shading.s.t, next.lobe, shading.bsdf);
    if (kLayers) {
        path.media = media_behind(path, shading, next.wi);
        if (next.wi.z < 0.0 && !shading.s.scattering.thin) path.radiance_scale /= shading.s.scattering.eta * shading.s.scattering.eta;
    }
    return max_component(path.throughput) > 0.0;
}

// Russian roulette with survival in [0.05, 0.95] by the largest throughput; false: the path ends.
bool survive_roulette(inout PathState path, float u) {
    const float survival = clamp(max_component(path.throughput) / path.radiance_scale, 0.05, 0.95);
    if (u >= survival) return false;
    path.throughput /= survival;
    return true;
}

// The path goes straight on behind the surface, which counts as no scattering.
void pass_surface(inout PathState path, Surface s) {
    path.travelled += s.t;
    path.cone = passing_cone(path.cone, s.t);
    path.ray = pass_through(path.ray, s);
}

// Behind a boundary that is none, because a volume of higher priority is on both sides.
void pass_boundary(inout PathState path, Surface s, MediumBoundary boundary) {
    pass_surface(path, s);
    path.media = boundary.beyond;
    path.pdf = -1.0;  // shadow rays end at every boundary
}

// Passes or stays before a pane, in proportion; the decision is a number of its own, because the path's next ones are the next
// surface's too. True: it passed.
bool pass_pane(ViewData view, inout PathState path, Surface s) {
    const vec3 passing = pane_transmittance(view, s, path.ray.direction_ws);
    const float share = min(max_component(passing), 1.0);
    const uint kPaneSalt = 0x50414E45u;
    if (hash_alpha(path.ray.alpha_key ^ kPaneSalt, s.instance, s.geometry, s.primitive) >= share) {
        path.throughput /= 1.0 - share;
        return false;
    }
    path.throughput *= passing / share;
    if (path.path_class.bounce == 0u) path.path_class.transmitted = true;
    pass_surface(path, s);
    return true;
}

// What happens where the path scatters: a light is asked for, and it goes on. A pass that says OWN_SCATTERING does it in its own way.
#ifdef OWN_SCATTERING
void scatter_at(ViewData view, PathKey key, Shading shading, VertexNumbers u, inout PathState path, inout VertexResult result);
#else
void scatter_at(ViewData view, PathKey key, Shading shading, VertexNumbers u, inout PathState path, inout VertexResult result) {
    const uint bounce = path.path_class.bounce;
    result.event = sample_next_event(view, path, shading, u.pick, u.light, alpha_key(key, bounce, kRayShadow));
    result.goes_on = scatter(path, shading, u.scatter, true, bounce == 0u, alpha_key(key, bounce + 1u, kRayPath));
}
#endif

// One vertex, from what the path's ray met there. `first` is set at the first surface.
VertexResult shade_vertex(ViewData view, PathKey key, Hit hit, inout PathState path, inout FirstHit first) {
    VertexResult result;
    result.event.exists = false;
    result.goes_on = false;
    Surface s = fetch_surface(hit, path.ray, path.cone);
    s.integer_offset = (view.flags & kViewIntegerOffset) != 0u;
    result.t = s.t;
    result.barycentrics = s.barycentrics;
    result.facing = abs(dot(s.n_geometric_ws, path.ray.direction_ws));
    result.extent = s.extent_ws;
    if (kLayers) path.throughput *= medium_transmittance(medium_there(path.media), s.t);
    const uint bounce = path.path_class.bounce;
    result.arriving = path.throughput * arriving_emission(path, s, view.light_sampling);
    result.arriving *= firefly_share(view, bounce, result.arriving);

    MediumBoundary boundary = MediumBoundary(path.media, true, s.scattering.ior);
    if (kLayers && s.scattering.transmission > 0.0 && !s.scattering.thin) boundary = cross_boundary(path.media, s.material, s.front_facing);
    if (!boundary.real) {
        pass_boundary(path, s, boundary);
        result.goes_on = true;
        return result;
    }
    if (bounce == 0u && !path.path_class.transmitted)
        first = FirstHit(s.scattering.base_color, s.n_shading_ws * (s.front_facing ? 1.0 : -1.0), s.emission, s.scattering.roughness);
    if (kLayers && is_pane(s.scattering) && pass_pane(view, path, s)) {
        result.goes_on = true;
        return result;
    }
    if (bounce >= view.max_bounces) return result;

    const VertexNumbers u = draw_numbers(view, key, bounce);
    if (bounce >= view.roulette_start && !survive_roulette(path, u.roulette)) return result;

    scatter_at(view, key, make_shading(view, path, s, boundary), u, path, result);
    return result;
}
#endif
