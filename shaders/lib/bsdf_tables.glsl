// Reading the tables of directional albedos (shared/bsdf_tables.h): linear between their points.
#ifndef PARHELION_LIB_BSDF_TABLES_GLSL
#define PARHELION_LIB_BSDF_TABLES_GLSL
#include "shared/bsdf_tables.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer BsdfTableWords { uint v[]; };

// A place on an axis: between point `index` and the next.
struct TableAxis {
    uint index;
    float rest;
};
TableAxis table_axis(float x, uint count) {
    const float scaled = clamp(x, 0.0, 1.0) * float(count - 1u);
    const uint index = min(uint(scaled), count - 2u);
    return TableAxis(index, scaled - float(index));
}
TableAxis mu_axis(float cosine, uint count) { return table_axis(sqrt(clamp(cosine, 0.0, 1.0)), count); }

// Pairs of 16 bits over one, two and three axes; `at` is the table's first word, `count` its points along x (and y).
vec2 read_table(uint64_t tables, uint at, TableAxis x) {
    BsdfTableWords words = BsdfTableWords(tables);
    return mix(unpackUnorm2x16(words.v[at + x.index]), unpackUnorm2x16(words.v[at + x.index + 1u]), x.rest);
}
vec2 read_table(uint64_t tables, uint at, TableAxis x, TableAxis y, uint count) {
    const uint row = at + y.index * count;
    return mix(read_table(tables, row, x), read_table(tables, row + count, x), y.rest);
}
vec2 read_table(uint64_t tables, uint at, TableAxis x, TableAxis y, TableAxis z, uvec2 count) {
    const uint layer = at + z.index * (count.x * count.y);
    return mix(read_table(tables, layer, x, y, count.x), read_table(tables, layer + count.x * count.y, x, y, count.x), z.rest);
}
// Pairs of floats over one axis.
vec2 read_float_table(uint64_t tables, uint at, TableAxis x) {
    BsdfTableWords words = BsdfTableWords(tables);
    const uint i = at + 2u * x.index;
    return mix(uintBitsToFloat(uvec2(words.v[i], words.v[i + 1u])), uintBitsToFloat(uvec2(words.v[i + 2u], words.v[i + 3u])), x.rest);
}

// (loss, grazing) of the white GGX lobe, see shared/bsdf_tables.h; averaged over the hemisphere in the second.
vec2 ggx_albedo(uint64_t tables, float cosine, float roughness) {
    return read_table(tables, kGgxAlbedoAt, mu_axis(cosine, kGgxMu), table_axis(roughness, kGgxRoughness), kGgxMu);
}
vec2 ggx_albedo_average(uint64_t tables, float roughness) { return read_float_table(tables, kGgxAverageAt, table_axis(roughness, kGgxRoughness)); }

// What rough glass scatters more than once of light from the side on which it has this cosine; eta: index beyond over index there.
TableAxis glass_index_axis(float eta, uint count) { return table_axis(sqrt(abs(eta - 1.0) / ((eta + 1.0) * kGlassMaxReflection)), count); }
float glass_table(uint64_t tables, float cosine, float roughness, float eta, float specular) {
    const uint side = eta < 1.0 ? kGlassMu * kGlassRoughness * kGlassIndices : 0u;
    const vec2 pair = read_table(tables, kGlassLossAt + side, table_axis(sqrt(sqrt(cosine)), kGlassMu), table_axis(sqrt(roughness), kGlassRoughness), glass_index_axis(eta, kGlassIndices),
                                 uvec2(kGlassMu, kGlassRoughness));
    return mix(pair.y, pair.x, specular);
}
float glass_average_table(uint64_t tables, float roughness, float eta, float specular) {
    const TableAxis index = glass_index_axis(eta, kGlassIndices), along = table_axis(sqrt(roughness), kGlassRoughness);
    const uint row = 2u * kGlassRoughness, at = kGlassAverageAt + (eta < 1.0 ? row * kGlassIndices : 0u) + index.index * row;
    const vec2 pair = mix(read_float_table(tables, at, along), read_float_table(tables, at + row, along), index.rest);
    return mix(pair.y, pair.x, specular);
}
#endif
