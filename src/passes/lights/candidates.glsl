// Light at a vertex: a few candidates, of which one is kept in proportion to about what it adds (Talbot et al. 2005, "Importance
// Resampling for Global Illumination"; Bitterli et al. 2020). Candidates are judged by what a tile tells of them, or, without tiles, by
// themselves; the one that is kept is made again at full precision, so that coarse codes cost variance and no bias.
#ifndef PARHELION_LIGHTS_CANDIDATES_GLSL
#define PARHELION_LIGHTS_CANDIDATES_GLSL
#include "lights/tile_code.glsl"
#include "scene/vertex.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Tiles { TileSample v[]; };

const uint kCandidateSalt = 0x43414E44u, kMostCandidates = 64u;

// About what a candidate adds: luminance of BSDF, cosine, light over density, with the weight of MIS. Positive where that is.
float candidate_target(ViewData view, Shading shading, TileView candidate, float bsdf_share) {
    if (max_component(candidate.light) <= 0.0) return 0.0;
    const vec3 wi = candidate.wi * shading.frame;
    const BsdfTerms terms = evaluate_bsdf(shading.bsdf, shading.outgoing, wi);
    float weight = 1.0;
    if (!candidate.is_delta && view.light_sampling == kLightSamplingMis) weight = mis_power_heuristic(candidate.pdf, terms.pdf * bsdf_share);
    return luminance(total(terms.value) * candidate.light) * weight;
}

// Which sample was kept, by place in the tiles (with tiles), and the sum of all targets over its own.
struct Candidate {
    uint place, emitter, triangle;
    float scale;  // mean of the targets over the one of this; 0: none
};

// `bounce`: of the vertex; each has candidates of its own.
Candidate choose_candidate(ViewData view, PathKey key, Shading shading, uint bounce, Tiles tiles, uint count) {
    Candidate kept = Candidate(0u, kNone, 0u, 0.0);
    const uint tile = tile_of(key.pixel, key.sample_index, key.seed);
    float sum = 0.0, kept_target = 0.0;
    for (uint i = 0u; i < count; ++i) {
        const uvec4 h = pcg4d(uvec4(key.pixel, key.sample_index, hash_combine(key.seed ^ kCandidateSalt, i + kMostCandidates * bounce)));
        const uint place = tile * kTileSamples + h.x % kTileSamples;
        const TileSample candidate = tiles.v[place];
        if (candidate.bits >> kTileKindShift == kTileNone) continue;
        const float target = candidate_target(view, shading, view_tile_sample(candidate, shading.s.position_ws), 1.0 / float(count));
        sum += target;
        if (target <= 0.0 || uint_to_unit_float(h.y) * sum >= target) continue;
        kept_target = target;
        kept.place = place;
        kept.emitter = candidate.emitter;
        kept.triangle = candidate.triangle;
    }
    if (kept.emitter != kNone) kept.scale = sum / (float(count) * kept_target);
    return kept;
}
#endif
