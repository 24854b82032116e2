// Glass under sheen and a clear coat, which lie on its outside, on both sides of a wall. Light that crosses is weighted by what the
// layers let through in its direction outside, L = 1 - their albedo; light reflected outside by L(o) L(i). Both are symmetric. What the
// layers turn back on its way out is
//     N(o) = L(o) int (1 - L(i)) R(o, i) di  outside,      N(o) = int (1 - L(i)) C(o, i) di  inside, below them
// (R: reflected, C: crossing), from tables of averages over the lobes (shared/bsdf_tables.h), and goes out on the same side as
// N(o) N(i) / (pi N_average), as in lib/layers.glsl: the whole is symmetric, and white over white. Smooth glass needs no average: a
// mirror's light stays a mirror's, and below the layers what they turn back is added to the reflection, to which it is parallel.
#ifndef PARHELION_LIB_COATED_GLASS_GLSL
#define PARHELION_LIB_COATED_GLASS_GLSL
#extension GL_EXT_control_flow_attributes : require
#include "lib/glass.glsl"
#include "lib/layers.glsl"

struct CoatedGlass {
    bool inside;   // wo is below the layers, in the glass
    bool diffuse;  // something of N is there: the glass is rough
    float turned[kTurnedBasis];  // the layers' albedo at equal steps of sqrt(cosine) from 0 to 1
    float average; // N's, over 2 cos
};

float turned_value(vec2 pair, float specular) { return 1.2 * mix(pair.y, pair.x, specular) - 0.2; }

TableAxis turned_mu_axis(float cosine, float eta) {
    const float critical = sqrt(max(1.0 - eta * eta, 0.0));
    if (critical == 0.0) return table_axis(sqrt(sqrt(cosine)), kTurnedMu);
    const float place = cosine > critical ? 0.5 + 0.5 * sqrt((cosine - critical) / (1.0 - critical)) : acos(1.0 - 2.0 * cosine / critical) / (2.0 * kPi);
    return table_axis(place, kTurnedMu);
}

// (cosine, weight) of quadrature over 2 cos: Gauss-Legendre with four nodes in each half of that axis.
vec2 turned_node(uint k, float eta) {
    const vec2 nodes[4] = vec2[](vec2(0.069431844, 0.173927423), vec2(0.330009478, 0.326072577), vec2(0.669990522, 0.326072577), vec2(0.930568156, 0.173927423));
    const float x = 0.5 * (nodes[k % 4u].x + float(k / 4u)), weight = 0.5 * nodes[k % 4u].y, critical = sqrt(max(1.0 - eta * eta, 0.0));
    if (critical == 0.0) return vec2(x * x * x * x, weight * 8.0 * x * x * x * x * x * x * x);
    const float above = 2.0 * x - 1.0, cosine = above > 0.0 ? critical + (1.0 - critical) * above * above : critical * 0.5 * (1.0 - cos(2.0 * kPi * x));
    const float slope = above > 0.0 ? 4.0 * (1.0 - critical) * above : kPi * critical * sin(2.0 * kPi * x);
    return vec2(cosine, weight * slope * 2.0 * cosine);
}

// int (1 - L) over a lobe of light from a cosine; `at`: the table of k = 0 on this side, `stride`: to the next k.
float turned_by_lobe(Glass g, CoatedGlass c, float cosine, uint at) {
    const TableAxis mu = turned_mu_axis(cosine, g.eta), roughness = table_axis(sqrt(g.roughness), kTurnedRoughness), index = glass_index_axis(g.eta, kTurnedIndices);
    float sum = 0.0;
    [[dont_unroll]] for (uint k = 0u; k < kTurnedBasis; ++k)
        sum += c.turned[k] * turned_value(read_table(g.tables, at + k * kTurnedLobe, mu, roughness, index, uvec2(kTurnedMu, kTurnedRoughness)), g.specular);
    return sum;
}
float turned_on_average(Glass g, CoatedGlass c, uint at) {
    const TableAxis roughness = table_axis(sqrt(g.roughness), kTurnedRoughness), index = glass_index_axis(g.eta, kTurnedIndices);
    float sum = 0.0;
    [[dont_unroll]] for (uint k = 0u; k < kTurnedBasis; ++k)
        sum += c.turned[k] * turned_value(read_table(g.tables, at + k * kTurnedAverage, roughness, index, kTurnedRoughness), g.specular);
    return sum;
}
float turned_by_wall(Glass g, CoatedGlass c, float cosine) {
    const TableAxis mu = table_axis(sqrt(sqrt(cosine)), kTurnedMu), roughness = table_axis(sqrt(g.roughness), kTurnedRoughness);
    float sum = 0.0;
    [[dont_unroll]] for (uint k = 0u; k < kTurnedBasis; ++k)
        sum += c.turned[k] * turned_value(read_table(g.tables, kTurnedMirroredAt + k * kTurnedMu * kTurnedRoughness, mu, roughness, kTurnedMu), 1.0);
    return sum;
}
float turned_by_wall_again(Glass g, CoatedGlass c) {
    float sum = 0.0;
    [[dont_unroll]] for (uint k = 0u; k < kTurnedBasis; ++k)
        sum += c.turned[k] * turned_value(read_table(g.tables, kTurnedMirroredLossAt + k * kTurnedRoughness, table_axis(sqrt(g.roughness), kTurnedRoughness)), 1.0);
    return sum;
}

// The first index of a side's tables: `leaving` the denser medium, in which the light is.
uint turned_side(bool leaving, uint table) { return leaving ? kTurnedBasis * table : 0u; }

// N, seen from a cosine on wo's side; `passes`: L there.
float coated_loss(Glass g, CoatedGlass c, float cosine, float passes) {
    if (!c.diffuse) return 0.0;
    const float loss = glass_loss(g, cosine, false);
    if (g.thin) return passes * max(turned_by_wall(g, c, cosine) + (loss > 0.0 ? loss * turned_by_wall_again(g, c) : 0.0), 0.0);
    const bool leaving = g.eta < 1.0;
    const uint lobe = turned_side(leaving, kTurnedLobe);
    if (c.inside) {
        const float again = loss > 0.0 ? loss * g.crossing * turned_on_average(g, c, kTurnedLossAt + turned_side(!leaving, kTurnedAverage)) : 0.0;
        return max(turned_by_lobe(g, c, cosine, kTurnedCrossingAt + lobe) + again, 0.0);
    }
    const float again = loss > 0.0 ? loss * (1.0 - g.crossing) * turned_on_average(g, c, kTurnedLossAt + turned_side(leaving, kTurnedAverage)) : 0.0;
    return passes * max(turned_by_lobe(g, c, cosine, kTurnedReflectedAt + lobe) + again, 0.0);
}

// By quadrature of N itself, so that it fits N whatever the tables make of it.
float coated_average(Glass g, CoatedGlass c, Layers l) {
    float sum = 0.0;
    [[dont_unroll]] for (uint k = 0u; k < 8u; ++k) {
        const vec2 node = turned_node(k, g.thin ? 1.0 : g.eta);
        sum += node.y * coated_loss(g, c, node.x, c.inside ? 1.0 : layers_pass(l, node.x, g.tables));
    }
    return sum;
}

CoatedGlass make_coated_glass(Glass g, Layers l, bool inside) {
    CoatedGlass c;
    c.inside = inside;
    c.diffuse = has_layers(l) && !g.delta && g.eta > 0.0;
    c.average = 0.0;
    if (!c.diffuse) return c;
    [[dont_unroll]] for (uint k = 0u; k < kTurnedBasis; ++k) {
        const float x = float(k) / float(kTurnedBasis - 1u);
        c.turned[k] = 1.0 - layers_pass(l, max(x * x, 1e-6), g.tables);
    }
    c.average = coated_average(g, c, l);
    return c;
}

// What the lobes of glass are multiplied by. passes_o, passes_i: L in both directions, as if they were outside.
float coated_passes(Glass g, CoatedGlass c, float passes_o, float passes_i, bool crosses) {
    if (c.inside) return crosses ? passes_i : 1.0;
    return passes_o * (crosses && !g.thin ? 1.0 : passes_i);
}

// N(o) N(i) / (pi N_average) times the cosine, from both cosines and L. Inside it has crossed twice.
vec3 eval_coated(Glass g, CoatedGlass c, vec2 cosines, vec2 passes) {
    if (!c.diffuse || c.average <= 1e-7) return vec3(0.0);
    float value = cosines.y / (kPi * c.average);
    [[dont_unroll]] for (uint k = 0u; k < 2u; ++k) value *= coated_loss(g, c, cosines[k], passes[k]);
    return (c.inside ? g.tint * g.tint : vec3(1.0)) * value;
}

// The same for smooth glass; passes_across: L in the refracted direction.
SmoothGlass coated_smooth_glass(Glass g, CoatedGlass c, vec3 wo, float passes_o, float passes_mirrored, float passes_across) {
    SmoothGlass shares = smooth_glass(g, wo);
    if (!c.inside) return SmoothGlass(shares.reflected * sqrt(passes_o * passes_mirrored), shares.refracted * passes_o);
    return SmoothGlass(shares.reflected + shares.refracted * g.tint * (1.0 - passes_across), shares.refracted * passes_across);
}
#endif
