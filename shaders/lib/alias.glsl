// Sampling of alias tables in O(1). Walker 1977; Vose 1991. Tables are built by sampling/alias_table.h. Also compiled as C++
// (shared/functions.h).
#ifndef PARHELION_LIB_ALIAS_GLSL
#define PARHELION_LIB_ALIAS_GLSL
#include "shared/functions.h"
#include "shared/scene.h"
SHARED_BEGIN

SHARED_ARRAY(AliasRows, AliasEntry)

// Index with probability alias_pmf(). The two numbers, 24 bits each, are read as one of 48 bits whose product with the count is
// the bin and, below the point, the choice between the bin and its alias: one float alone would leave the choice in a table of
// 2^20 rows four bits, and its bins unequal by up to 1/16. count <= 2^24.
SHARED_FN uint sample_alias(uint64_t table, uint count, vec2 u) {
    const uint64_t high = uint64_t(uint(u.x * 16777216.0f)) * uint64_t(count);
    const uint64_t low = uint64_t(uint(u.y * 16777216.0f)) * uint64_t(count);
    const uint64_t product = high + (low >> 24);
    const uint bin = uint(product >> 24);
    const float rest = float(uint(product) & 0xFFFFFFu) * 5.9604645e-8f;
    const AliasEntry entry = AliasRows(table).v[bin];
    return rest < entry.probability ? bin : entry.alias;
}

SHARED_FN float alias_pmf(uint64_t table, uint index) { return AliasRows(table).v[index].pmf; }

SHARED_END
#endif
