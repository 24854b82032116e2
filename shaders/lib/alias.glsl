// Sampling of alias tables in O(1). Walker 1977; Vose 1991.
#ifndef PARHELION_LIB_ALIAS_GLSL
#define PARHELION_LIB_ALIAS_GLSL
#include "shared/scene.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer AliasTable { AliasEntry v[]; };

// u.x picks the bin, u.y decides between the bin and its alias.
uint sample_alias(uint64_t table, uint count, vec2 u) {
    const uint bin = min(uint(u.x * float(count)), count - 1u);
    const AliasEntry entry = AliasTable(table).v[bin];
    return u.y < entry.probability ? bin : entry.alias;
}

float alias_pmf(uint64_t table, uint index) { return AliasTable(table).v[index].pmf; }
#endif
