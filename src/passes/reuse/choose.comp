#version 460
// Spatial reuse, second half: a pixel's reservoir and its partners' become one. By the sample that is kept reuse/light lights the pixel, if it needs that: pixels go
// into a list for each of its kernels.
// Reads: scene, view, identity, summary, reservoirs, told. Reads and writes: control, lists, block (path classes, debug layers), rays (of the film: the exchange's),
// sums (nothing yet), diffuse and specular, if they hold what paths were offered. Writes: chosen.
#extension GL_GOOGLE_include_directive : require
#include "lib/reservoir.glsl"
#include "realtime/demodulate.glsl"
#include "realtime/offered.glsl"
#include "realtime/paths.glsl"
#include "reuse/partner.glsl"
#include "wavefront/classes.glsl"
#include "wavefront/linear.glsl"
#include "wavefront/lists.glsl"

layout(set = 1, binding = 0, rgba32ui) uniform readonly uimage2D identity;
layout(set = 1, binding = 1, rgba32ui) uniform readonly uimage2D summary;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Reservoirs { PackedReservoir v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Told { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Chosen { ChosenSample v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer RayCounts { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Light { PackedLight v[]; };
layout(push_constant, scalar) uniform Push {
    ViewBlock view;
    Control control;
    Lists lists;
    Reservoirs reservoirs;
    Told told;
    Chosen chosen;
    Sums sums;
    FilmBlock block;
    RayCounts rays;
    Light diffuse, specular;
    ReuseFrame frame;
    float exposure;
} push;
#include "reuse/add_class.glsl"

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
// while the other one gets lost. (Each by itself they would add noise to means over pixels, which reconstruction makes.) `from`: whose reservoir that sample is in.
// False: it has no partner.
bool ask_partners(ViewData view, uvec2 id, uint pixel, Reservoir own, out Offered offered, out uint from, out float u) {
    const uint kPartnerSalt = 0x5441u, pixels = view.width * view.height;
    Partner partner;
    float around = 0.0;
    offered = kNothingOffered;
    from = kNone;
    u = 0.0;
    for (uint i = 0u; i < push.frame.neighbours; ++i)
        if (read_partner(view, id, pixel, i, partner)) around += float(packed_confidence(push.reservoirs.v[reservoir_at(pixels, push.frame.set, partner.pixel)].point));
    if (around <= 0.0) return false;
    own.target = as_told(own.target);
    for (uint i = 0u; i < push.frame.neighbours; ++i) {
        if (!read_partner(view, id, pixel, i, partner)) continue;
        const uint at = reservoir_at(pixels, push.frame.set, partner.pixel);
        Reservoir other = unpack_reservoir(push.reservoirs.v[at]);
        other.target = as_told(other.target);
        const uvec4 random = pcg4d(uvec4(min(pixel, partner.pixel), push.frame.frame_index, view.seed ^ kPartnerSalt, 2u * i + push.frame.set));
        if (!offer_reservoir(offered, own, other, around, partner.here, partner.there, uint_to_unit_float(pixel < partner.pixel ? random.y : random.z))) continue;
        from = at;
        u = uint_to_unit_float(random.x);
    }
    return true;
}

// What becomes of a pixel's reservoir beside those of its partners: `from` is where the sample lies that is kept. Where signals hold what its path was offered, and the
// sample is out of that, `left` of it stays and the rest is the partners' alone: so the pixel's own light has no noise of a choice, and needs neither its surface's
// lobes nor a ray.
Reservoir take_from_partners(ViewData view, uvec2 id, uint pixel, out uint from, out float left) {
    const uint at = reservoir_at(view.width * view.height, push.frame.set, pixel);
    Reservoir own = unpack_reservoir(push.reservoirs.v[at]);
    Offered offered;
    uint from_partner;
    float u;
    const bool has_partner = ask_partners(view, id, pixel, own, offered, from_partner, u);
    from = at;
    left = 0.0;
    if (push.frame.keeps_offered != 0u && own.point.kind != kSampleNone && (own.point.flags & kSampleSeen) != 0u) {
        left = has_partner && own.target > 0.0 ? offered.own_share : 1.0;
        from = from_partner;
        return Reservoir(offered.point, own.confidence, offered.target > 0.0 ? offered.sum / offered.target : 0.0, offered.target);
    }
    if (has_partner && take_offered(own, offered, u)) from = from_partner;
    return own;
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

bool is_plain(uint instance, uint geometry) {
    const uint met_class = class_of(WavefrontHit(instance, geometry, 0u));
    return met_class != kClassCoated && met_class != kClassTransmissive;
}

// The kernel that is to light the pixel: the plain one if all is plain that it looks at. kNone: nothing is left to do.
uint choose(uint slot) {
    const ViewData view = push.view.data;
    const uvec2 id = pixel_of(view, push.control.v.slice, slot);
    const uint pixel = id.y * view.width + id.x;
    if (push.frame.set == 0u) push.sums.v[slot] = LightSums(vec3(0.0), vec3(0.0));
    const uvec4 which = imageLoad(identity, ivec2(id));
    uint from = kNone;
    float left = 0.0;
    Reservoir kept = kEmptyReservoir;
    if (which.x != kHitMiss) kept = take_from_partners(view, id, pixel, from, left);
    if (push.frame.keeps_offered != 0u) settle_offered(view, id, pixel, left);
    if (kept.point.kind == kSampleNone || kept.weight <= 0.0) return kNone;
    push.chosen.v[slot] = ChosenSample(from, kept.weight);
    return is_plain(which.x, which.y) && (!is_point(kept.point.kind) || is_plain(kept.point.reference, kept.point.geometry)) ? kShadePlain : kShadeRest;
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
    const bool shown = slot < push.control.v.pixel_count;
    count_rays(slot, shown);
    uint kernel = kNone;
    if (shown) kernel = choose(slot);
    list_append(push.lists, push.control, kListClasses, kernel, kShadeKernels, slot);
}
