#version 460
// Spatial reuse, second half: a pixel's reservoir and its partners' become one. Lights a band's pixels by the samples kept: a shadow ray for each, but
// for those that a ray of this frame has seen.
// Reads: scene, view, identity, summary, reservoirs, told. Reads and writes: control and shadow_list (of shadow rays), sums, pending, block (path classes,
// debug layers), rays (of the film: the exchange's), diffuse and specular, if they hold what paths were offered. Writes: shadow_rays.
// variants: LAYERS
#extension GL_GOOGLE_include_directive : require
#include "realtime/demodulate.glsl"
#include "realtime/offered.glsl"
#include "realtime/paths.glsl"
#include "reuse/partner.glsl"
#include "scene/shift.glsl"
#include "wavefront/linear.glsl"
#include "wavefront/lists.glsl"

layout(set = 1, binding = 0, rgba32ui) uniform readonly uimage2D identity;
layout(set = 1, binding = 1, rgba32ui) uniform readonly uimage2D summary;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Reservoirs { PackedReservoir v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Told { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer ShadowList { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) writeonly buffer ShadowRays { WavefrontShadowRay v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer RayCounts { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Light { PackedLight v[]; };
layout(push_constant, scalar) uniform Push {
    ViewBlock view;
    Control control;
    Reservoirs reservoirs;
    Told told;
    Sums sums;
    Pending pending;
    ShadowRays shadow_rays;
    ShadowList shadow_list;
    FilmBlock block;
    RayCounts rays;
    Light diffuse, specular;
    ReuseFrame frame;
    float exposure;
} push;

struct Partner {
    uint pixel;
    float here, there;       // what its sample brings to the pixel, and the pixel's own to it
};

// False: there is none, or, where the two did not agree about it by rounding, none that both know of.
bool read_partner(ViewData view, uvec2 id, uint pixel, uint index, out Partner partner) {
    const uint pixels = view.width * view.height, told = told_of(push.told.v[told_at(pixels, push.frame, index, pixel)], index);
    if (told == kNoPartner) return false;
    const ivec2 at = partner_of(view, push.frame, id, index, told_turn(told));
    const uint other = uint(at.y) * view.width + uint(at.x), told_other = told_of(push.told.v[told_at(pixels, push.frame, index, other)], index);
    partner = Partner(other, told_target(told), told_target(told_other));
    return told_other != kNoPartner && told_turn(told_other) == told_turn(told);
}

// Of a pixel's partners' samples one. Both pixels of a pair decide by one number, `u`: what is due to both is kept by one of them, and none is kept twice
// while the other one gets lost. (Each by itself they would add noise to means over pixels, which reconstruction makes.) False: it has no partner.
bool ask_partners(ViewData view, uvec2 id, uint pixel, Reservoir own, out Offered offered, out float u, out float around) {
    const uint kPartnerSalt = 0x5441u, pixels = view.width * view.height;
    Partner partner;
    offered = kNothingOffered;
    u = around = 0.0;
    for (uint i = 0u; i < push.frame.neighbours; ++i)
        if (read_partner(view, id, pixel, i, partner)) around += float(packed_confidence(push.reservoirs.v[reservoir_at(pixels, push.frame.set, partner.pixel)].point));
    if (around <= 0.0) return false;
    own.target = as_told(own.target);
    for (uint i = 0u; i < push.frame.neighbours; ++i) {
        if (!read_partner(view, id, pixel, i, partner)) continue;
        Reservoir other = unpack_reservoir(push.reservoirs.v[reservoir_at(pixels, push.frame.set, partner.pixel)]);
        other.point.flags |= kSampleSeen;  // or it brings nothing
        other.target = as_told(other.target);
        const uvec4 random = pcg4d(uvec4(min(pixel, partner.pixel), push.frame.frame_index, view.seed ^ kPartnerSalt, 2u * i + push.frame.set));
        if (offer_reservoir(offered, own, other, around, partner.here, partner.there, uint_to_unit_float(pixel < partner.pixel ? random.y : random.z))) u = uint_to_unit_float(random.x);
    }
    return true;
}

// What lights a pixel: `left` of what its path was offered, if signals hold that, and one sample or two.
struct Lit {
    float left;
    Reservoir extra, one;  // `extra` is the pixel's own sample, seen by a ray of this frame
};

// A pixel's reservoir beside those of its partners. Where signals hold what its path was offered, and the sample is out of that, the pixel keeps its share of all of
// it and takes a partner's sample besides: so its own light has no noise of a choice, and needs neither its surface's lobes nor a ray. The share is the sample's,
// which is about the same for all that was offered. Where it is much more, since partners do not see the sample, all keep what is left beside partners who see all, and
// what the sample has more is its own: else a lamp that is hidden from the partner would give of its share to lamps of other colours that are not.
Lit take_from_partners(ViewData view, uvec2 id, uint pixel) {
    const float kMuchMore = 0.1;
    Reservoir own = unpack_reservoir(push.reservoirs.v[reservoir_at(view.width * view.height, push.frame.set, pixel)]);
    Offered offered;
    float u, around;
    const bool has_partner = ask_partners(view, id, pixel, own, offered, u, around);
    Lit lit = Lit(0.0, kEmptyReservoir, own);
    if (push.frame.keeps_offered != 0u && own.point.kind != kSampleNone && (own.point.flags & kSampleSeen) != 0u) {
        const float share = has_partner && own.target > 0.0 ? offered.own_share : 1.0, usual = has_partner ? float(own.confidence) / (float(own.confidence) + around) : 1.0;
        lit.left = share;
        if (share > usual + kMuchMore && (scene.header.features & kScenePanes) == 0u) {
            lit.left = usual;
            lit.extra = own;
            lit.extra.weight *= share - usual;
        }
        lit.one = Reservoir(offered.point, own.confidence, offered.target > 0.0 ? offered.sum / offered.target : 0.0, offered.target);
    } else if (has_partner) take_offered(lit.one, offered, u);
    return lit;
}

void add_class(ViewData view, uint pixel, bool indirect, BsdfValue light) {
    PathRadiance by_class = make_path_radiance();
    if (indirect) {
        by_class.indirect_diffuse = light.diffuse;
        by_class.indirect_specular = light.specular;
    } else add_sampled(by_class, PathClass(0u, false, vec3(0.0)), total(light), light);
    film_add_path_classes(push.block, view, pixel, by_class);
}

bool keeps_classes(ViewData view) {
    bool keeps = false;
    for (uint group = kFilmPathDirectDiffuse; group <= kFilmPathIndirectSpecular; ++group) keeps = keeps || view.channel[group] != kNoChannel;
    return keeps;
}

// What is left of what the pixel's path was offered joins its own light. In the film's layers it is as direct or indirect as the one sample that stands for it.
void settle_offered(ViewData view, uvec2 id, uint pixel, float left) {
    const PackedLight diffuse = push.diffuse.v[pixel], specular = push.specular.v[pixel];
    const BsdfValue offered = BsdfValue(left * offered_light(diffuse), left * offered_light(specular), vec3(0.0));
    push.diffuse.v[pixel] = pack_light(own_light(diffuse) + offered.diffuse);
    push.specular.v[pixel] = pack_light(own_light(specular) + offered.specular);
    if (left <= 0.0 || !keeps_classes(view)) return;
    const bool indirect = is_indirect(push.reservoirs.v[reservoir_at(view.width * view.height, push.frame.set, pixel)].point.bits >> 24 & 7u);
    const Demodulation by = demodulation(imageLoad(summary, ivec2(id)));
    add_class(view, pixel, indirect, BsdfValue(offered.diffuse * by.diffuse / push.exposure, offered.specular * by.specular / push.exposure, vec3(0.0)));
}

// Without a ray.
void add_seen(ViewData view, uint slot, uint pixel, bool indirect, BsdfValue light) {
    add_light(push.sums, slot, light.diffuse, light.specular);
    add_class(view, pixel, indirect, light);
}

// By one sample, whole. True: the light waits for its shadow ray.
bool light_by(ViewData view, uint slot, uint pixel, PathKey key, Receiver here, Reservoir r) {
    const Shifted brought = shift(view, r.point, here, kNow, sample_ray_key(key, r.point.kind));
    if (target_of(brought) <= 0.0) return false;
    const BsdfValue light = scale(brought.value, vec3(r.weight));
    const bool indirect = is_indirect(r.point.kind);
    if ((r.point.flags & kSampleSeen) != 0u && (scene.header.features & kScenePanes) == 0u) {
        add_seen(view, slot, pixel, indirect, light);
        return false;
    }
    push.shadow_rays.v[slot] = WavefrontShadowRay(brought.ray.origin_ws, brought.ray.t_max, brought.ray.direction_ws, brought.ray.alpha_key);
    push.pending.v[slot] = LightPending(light.diffuse, pixel, light.specular, (indirect ? kLightIndirect : kLightDirect) | (brought.passes ? 0u : kLightStopsAtPanes));
    return true;
}

bool lights(Reservoir r) { return r.point.kind != kSampleNone && r.weight > 0.0; }

// True: the pixel's light waits for its shadow ray.
bool light_pixel(uint slot) {
    const ViewData view = push.view.data;
    const uvec2 id = pixel_of(view, push.control.v.slice, slot);
    const uint pixel = id.y * view.width + id.x;
    if (push.frame.set == 0u) push.sums.v[slot] = LightSums(vec3(0.0), vec3(0.0));
    const uvec4 which = imageLoad(identity, ivec2(id));
    Lit lit = Lit(0.0, kEmptyReservoir, kEmptyReservoir);
    if (which.x != kHitMiss) lit = take_from_partners(view, id, pixel);
    if (push.frame.keeps_offered != 0u) settle_offered(view, id, pixel, lit.left);
    if (!lights(lit.one) && !lights(lit.extra)) return false;
    const PathKey key = PathKey(id, push.frame.frame_index, view.seed);
    const Receiver here = receiver_at(view, key, which, bsdf_share(push.frame.candidates), kNow);
    bool waits = false;
    for (uint i = 0u; i < 2u; ++i) {  // a loop, so that what is long is compiled once
        Reservoir r = lit.one;
        if (i == 0u) r = lit.extra;
        if (lights(r)) waits = light_by(view, slot, pixel, key, here, r);
    }
    return waits;
}

// Of the exchange, which tells of its rays and does not count them: here as many as run at once ask the counter once.
void count_rays(uint slot, bool shown) {
    const ViewData view = push.view.data;
    uint of_pixel = 0u, of_all = 0u;
    for (uint i = 0u; i < push.frame.neighbours; ++i) {
        bool traced = false;
        if (shown) {
            const uvec2 id = pixel_of(view, push.control.v.slice, slot);
            if (imageLoad(identity, ivec2(id)).x != kHitMiss) traced = told_traced(told_of(push.told.v[told_at(view.width * view.height, push.frame, i, id.y * view.width + id.x)], i));
        }
        of_pixel += uint(traced);
        of_all += subgroupBallotBitCount(subgroupBallot(traced));
    }
    if (shown && of_pixel != 0u) {
        const uvec2 id = pixel_of(view, push.control.v.slice, slot);
        film_add(push.block, view, kFilmDebugRays, id.y * view.width + id.x, vec3(float(of_pixel)));
    }
    if (of_all == 0u || !subgroupElect()) return;
    const uint before = atomicAdd(push.rays.v[2u * kRayShadow], of_all);
    if (before + of_all < before) atomicAdd(push.rays.v[2u * kRayShadow + 1u], 1u);
}

void main() {
    const uint slot = invocation_index();
    count_rays(slot, slot < push.control.v.pixel_count);
    const bool waits = slot < push.control.v.pixel_count && light_pixel(slot);
    const uint place = reserve(push.control, kListShadows, bin_if(waits), 1u);
    if (waits) push.shadow_list.v[place] = slot;
}
