// What lies on a surface: sheen, and a clear coat over it (KHR_materials_sheen, KHR_materials_clearcoat).
//
// Layers that scatter the share S(mu) of light from mu would give back S + T(o) T(i) b(o, i), T = 1 - S, over a surface b: symmetric,
// but the light that they turn back on its way out is lost. What is missing to a white surface's 1 is known,
//     N(o) = 1 - S(o) - T(o) int T(i) b(o, i) di,     which only needs averages of the layers' albedos over b (shared/bsdf_tables.h),
// and goes out as N(o) N(i) / (pi N_average), as what microfacets scatter more than once does (Kulla and Conty 2017): the whole is
// symmetric, and white over white. Over a coloured surface N is taken of its albedos, and what comes back has met it once more.
// A mirror's light stays a mirror's: it comes out whole, weighted by what the layers do not scatter.
#ifndef PARHELION_LIB_LAYERS_GLSL
#define PARHELION_LIB_LAYERS_GLSL
#include "lib/glossy.glsl"
#include "lib/warp.glsl"

struct Layers {
    float coat;           // weight; 0: none
    float coat_roughness, coat_alpha;
    float coat_again, coat_loss_average;  // as Reflectance::again and Glossy::loss_average
    vec3 coat_normal;
    bool coat_delta;
    vec3 sheen_color;
    float sheen;          // its largest channel, by which it darkens what lies below; 0: none
    float sheen_alpha, sheen_place;       // the latter on the tables' axis
    float sheen_share;    // of its albedo that counts in T; less than 1 under a smooth coat, so that T stays positive
    float over_again, over_diffuse;  // the layers' albedo averaged over Glossy's again and Lambert lobes
    vec3 residual;        // what N(o) N(i) is multiplied by
};

bool has_layers(Layers l) { return l.coat > 0.0 || l.sheen > 0.0; }

// The layers as a direction meets them.
struct LayerPlace {
    float cos_coat;        // to the coat's normal
    float coat_loss;
    float coat, sheen;     // albedos, weights included
    float sheen_cap;
    float sheen_out;       // the sheen lobe's albedo behind the coat
    float leaves;          // 1 - what the layers scatter
    float passes;          // T: 1 - the sum of the albedos, which need not be exactly what leaves: N takes the rest
    vec3 residual;         // N
};

vec2 coat_table(Layers l, float cosine, uint64_t tables) {
    return l.coat_delta ? vec2(0.0, schlick_weight(cosine)) : ggx_albedo(tables, cosine, l.coat_roughness);
}
Reflectance coat_reflectance(Layers l) { return Reflectance(vec3(kCoatF0), 1.0, vec3(l.coat_again)); }

// The layers alone, without what they turn back; w in the shading frame, z > 0.
LayerPlace bare_layer_place(Layers l, vec3 w, uint64_t tables) {
    LayerPlace p;
    p.residual = vec3(0.0);
    p.cos_coat = max(dot(w, l.coat_normal), 0.0);
    p.coat_loss = 0.0;
    p.coat = 0.0;
    p.sheen = 0.0;
    p.sheen_cap = 1.0;
    float coat_over_sheen = 0.0;
    if (l.coat > 0.0) {
        const vec2 tc = coat_table(l, p.cos_coat, tables);
        p.coat_loss = tc.x;
        p.coat = l.coat * whole_albedo(coat_reflectance(l), tc).x;
        if (l.sheen > 0.0) coat_over_sheen = l.coat * l.sheen *
            read_table(tables, kCoatOverSheenAt, mu_axis(w.z, kLayerMu), table_axis(l.sheen_place, kLayerRoughness), table_axis(l.coat_roughness, kLayerRoughness), uvec2(kLayerMu, kLayerRoughness)).x;
    }
    if (l.sheen > 0.0) {
        const vec2 ts = read_table(tables, kSheenAlbedoAt, mu_axis(w.z, kSheenMu), table_axis(l.sheen_place, kSheenRoughness), kSheenMu);
        p.sheen = l.sheen * ts.x;
        p.sheen_cap = ts.y;
    }
    p.sheen_out = (1.0 - p.coat) * max(p.sheen - coat_over_sheen, 0.0);
    p.leaves = max(1.0 - p.coat - p.sheen_out, 0.0);
    p.passes = max(1.0 - p.coat - l.sheen_share * p.sheen, 0.0);
    return p;
}

// Over a surface; t: its glossy_table() of w. What mirrors below give back is in no average (see above).
LayerPlace layer_place(Layers l, Glossy g, vec3 w, vec2 t, uint64_t tables) {
    LayerPlace p = bare_layer_place(l, w, tables);
    const bool over_ggx = has_glossy(g) && !g.delta;
    vec2 over = vec2(0.0);
    if (over_ggx) {
        const TableAxis mu = mu_axis(w.z, kLayerMu), below = table_axis(g.roughness, kLayerBelow);
        const uvec2 count = uvec2(kLayerMu, kLayerBelow);
        if (l.coat > 0.0) over += l.coat * read_table(tables, kCoatOverGgxAt, mu, below, table_axis(l.coat_roughness, kLayerRoughness), count);
        if (l.sheen > 0.0) over += l.sheen_share * l.sheen * read_table(tables, kSheenOverGgxAt, mu, below, table_axis(l.sheen_place, kLayerRoughness), count);
    }
    const vec3 again = again_albedo(g, t), diffuse = diffuse_albedo(g, t), single = over_ggx ? single_albedo(g.glossy, t) : vec3(0.0);
    const vec3 turned_back = g.glossy.f0 * over.x + vec3(g.glossy.f90 * over.y) + again * l.over_again + diffuse * l.over_diffuse;
    p.residual = max((p.leaves - p.passes) * (single + again + diffuse) + p.passes * turned_back, vec3(0.0));
    return p;
}

// What the layers do not scatter of light from a cosine to both normals.
float layers_pass(Layers l, float cosine, uint64_t tables) {
    Layers flat_layers = l;
    flat_layers.coat_normal = vec3(0.0, 0.0, 1.0);
    return bare_layer_place(flat_layers, vec3(sqrt(max(1.0 - cosine * cosine, 0.0)), 0.0, cosine), tables).leaves;
}

// A layer's albedo averaged over the lobes of the surface below that look the same from everywhere: (again, Lambert).
vec2 layer_averages(Glossy g, uint at, float average, float roughness, uint64_t tables) {
    if (!has_glossy(g)) return vec2(average);
    const vec2 t = read_table(tables, at, table_axis(g.delta ? 0.0 : g.roughness, kLayerBelow), table_axis(roughness, kLayerRoughness), kLayerBelow);
    const float loss = t.x * g.loss_average, over = dot(vec3(g.over.f0.x, g.over.f90, g.over.again.x), vec3(average - loss - t.y, t.y, loss));
    return vec2(t.x, max(average - over, 0.0) / g.passes_average);
}

// (cosine, weight) of quadrature over 2 cos: Gauss-Jacobi in the cosine, enough for a coat; and, for sheen, which is seen at grazing angles
// only where its roughness is small, Gauss-Legendre in sqrt(cosine) on both sides of 0.6 (its first node, of weight 3e-5, left out).
const uint kCoatNodes = 4u, kSheenNodes = 6u;
const vec2 kNodes[10] = vec2[](vec2(0.139759864, 0.062361942), vec2(0.416409568, 0.259695095), vec2(0.723156986, 0.406929136), vec2(0.942895804, 0.271013827),
                               vec2(0.039206252, 0.006105350), vec2(0.161599428, 0.050837624), vec2(0.311744553, 0.072657026), vec2(0.416129066, 0.119305251),
                               vec2(0.640000000, 0.364088889), vec2(0.911870934, 0.387005860));

// N_average, and how much light that comes back down leaves a surface of its colour; `glass`: weight of what is below besides, and takes
// no light away.
void set_residual(inout Layers l, Glossy g, float glass, float turned_back_average, uint64_t tables) {
    const uint first = l.sheen > 0.0 ? kCoatNodes : 0u, last = l.sheen > 0.0 ? kCoatNodes + kSheenNodes : kCoatNodes;
    vec3 average = vec3(0.0), albedo = vec3(glass);
    Layers flat_layers = l;
    flat_layers.coat_normal = vec3(0.0, 0.0, 1.0);
    for (uint k = first; k < last; ++k) {
        const vec2 node = kNodes[k];
        const vec3 w = vec3(sqrt(1.0 - node.x * node.x), 0.0, node.x);
        const vec2 t = glossy_table(g, w.z, tables);
        average += node.y * layer_place(flat_layers, g, w, t, tables).residual;
        albedo += node.y * (whole_albedo(g.glossy, t) + diffuse_albedo(g, t));
    }
    // A series: met by the surface, and turned back by the layers, again and again.
    const float back = min(turned_back_average, 0.95);
    const vec3 leaves = albedo * (1.0 - back) / (vec3(1.0) - min(albedo, vec3(1.0)) * back);
    l.residual = mix(min(leaves, vec3(1.0)) / (kPi * max(average, vec3(1e-6))), vec3(0.0), lessThan(average, vec3(1e-6)));
}

vec2 coat_average(Layers l, uint64_t tables) { return l.coat_delta ? vec2(0.0, 1.0 / 21.0) : ggx_albedo_average(tables, l.coat_roughness); }

// The layers alone, whatever lies below.
Layers make_bare_layers(float coat, float coat_roughness, vec3 coat_normal, vec3 sheen_color, float sheen_roughness, bool compensate, uint64_t tables) {
    Layers l;
    l.coat = coat;
    l.coat_roughness = coat_roughness;
    l.coat_alpha = coat_roughness * coat_roughness;
    l.coat_delta = coat_roughness < kDeltaRoughness;
    l.coat_normal = coat_normal;
    l.coat_again = 0.0;
    l.coat_loss_average = 0.0;
    l.sheen_color = sheen_color;
    l.sheen = max_component(sheen_color);
    const float roughness = max(sheen_roughness, kMinSheenRoughness);
    l.sheen_alpha = roughness * roughness;
    l.sheen_place = (roughness - kMinSheenRoughness) / (1.0 - kMinSheenRoughness);
    l.sheen_share = 1.0;
    l.over_again = 0.0;
    l.over_diffuse = 0.0;
    l.residual = vec3(0.0);
    if (coat > 0.0) {
        l.coat_loss_average = coat_average(l, tables).x;
        l.coat_again = make_reflectance(vec3(kCoatF0), 1.0, compensate, l.coat_loss_average).again.x;
        if (l.sheen > 0.0) l.sheen_share -= 0.5 * coat * whole_albedo(coat_reflectance(l), coat_table(l, 0.1, tables)).x;  // as it is near grazing angles
    }
    return l;
}

Layers make_layers(Glossy g, float glass, float coat, float coat_roughness, vec3 coat_normal, vec3 sheen_color, float sheen_roughness, bool compensate, uint64_t tables) {
    Layers l = make_bare_layers(coat, coat_roughness, coat_normal, sheen_color, sheen_roughness, compensate, tables);
    if (!has_layers(l)) return l;
    float turned_back = 0.0;
    if (coat > 0.0) {
        const float mean = whole_albedo(coat_reflectance(l), coat_average(l, tables)).x;
        const vec2 over = layer_averages(g, kCoatOverLossAt, mean, coat_roughness, tables);
        l.over_again += coat * over.x;
        l.over_diffuse += coat * over.y;
        turned_back += coat * mean;
    }
    if (l.sheen > 0.0) {
        const float mean = read_float_table(tables, kSheenAverageAt, table_axis(l.sheen_place, kSheenRoughness)).x;
        const vec2 over = layer_averages(g, kSheenOverLossAt, mean, l.sheen_place, tables);
        l.over_again += l.sheen_share * l.sheen * over.x;
        l.over_diffuse += l.sheen_share * l.sheen * over.y;
        turned_back += l.sheen * mean;
    }
    set_residual(l, g, glass, turned_back, tables);
    return l;
}

// ---- lobes: value times cosine ----

// In the coat's own frame: its cosine, not the surface's.
vec3 to_coat(Layers l, vec3 w) {
    if (l.coat_normal.z == 1.0) return w;
    const vec3 x = normalize(vec3(l.coat_normal.z, 0.0, -l.coat_normal.x)), y = cross(l.coat_normal, x);
    return vec3(dot(w, x), dot(w, y), dot(w, l.coat_normal));
}
vec3 from_coat(Layers l, vec3 w) {
    if (l.coat_normal.z == 1.0) return w;
    const vec3 x = normalize(vec3(l.coat_normal.z, 0.0, -l.coat_normal.x)), y = cross(l.coat_normal, x);
    return x * w.x + y * w.y + l.coat_normal * w.z;
}

// What the coat's microfacets scatter once is eval_ggx() in its frame; this is the rest.
float eval_coat_again(Layers l, LayerPlace o, LayerPlace i) {
    if (l.coat_loss_average <= 0.0) return 0.0;
    return l.coat * l.coat_again * o.coat_loss * i.coat_loss / l.coat_loss_average * i.cos_coat / kPi;
}

// Estevez and Kulla 2017, "Production Friendly Microfacet Sheen BRDF", as KHR_materials_sheen writes it; alpha = roughness^2.
float sheen_lambda(float cosine, float alpha) {
    const float blend = (1.0 - alpha) * (1.0 - alpha);
    const float a = mix(21.5473, 25.3245, blend), b = mix(3.82987, 3.32435, blend), c = mix(0.19823, 0.16801, blend);
    const float d = mix(-1.97760, -1.27393, blend), e = mix(-4.32054, -4.85967, blend);
    const float x = cosine < 0.5 ? cosine : 1.0 - cosine;
    const float fit = a / (1.0 + b * pow(max(x, 1e-20), c)) + d * x + e;
    if (cosine < 0.5) return exp(fit);
    return exp(2.0 * (a / (1.0 + b * pow(0.5, c)) + d * 0.5 + e) - fit);
}
vec3 eval_sheen(Layers l, LayerPlace o, LayerPlace i, vec3 h, vec3 wo, vec3 wi) {
    const float alpha = l.sheen_alpha;
    const float distribution = (2.0 + 1.0 / alpha) * pow(clamp(dot(h.xy, h.xy), 0.0, 1.0), 0.5 / alpha) / (2.0 * kPi);
    const float masked = distribution / ((1.0 + sheen_lambda(wo.z, alpha) + sheen_lambda(wi.z, alpha)) * 4.0 * wo.z);
    return l.sheen_color * (masked * o.sheen_cap * i.sheen_cap * (1.0 - o.coat) * (1.0 - i.coat));
}
vec3 eval_residual(Layers l, LayerPlace o, LayerPlace i, float cos_i) { return l.residual * o.residual * i.residual * cos_i; }
#endif
