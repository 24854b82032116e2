// Nodes of our own BVH (shared/bvh.h): from four float boxes to each layout, and back. Also compiled as C++ (shared/functions.h).
#ifndef PARHELION_LIB_BVH_NODES_GLSL
#define PARHELION_LIB_BVH_NODES_GLSL
#include "shared/bvh.h"
#include "shared/functions.h"
SHARED_BEGIN

// Where a row of an array lies. In 64 bits: a scene of 30 million triangles has more than 2^32 bytes of nodes.
SHARED_FN uint64_t row_address(uint64_t array, uint row, uint row_bytes) { return array + uint64_t(row) * uint64_t(row_bytes); }

// ---- two children ----

// Children 0 and 1 of `node`; the others must be empty.
SHARED_FN BvhNodeBinary encode_binary(BvhNode node) {
    BvhNodeBinary out_node;
    out_node.x = vec4(node.min_x.x, node.min_x.y, node.max_x.x, node.max_x.y);
    out_node.y = vec4(node.min_y.x, node.min_y.y, node.max_y.x, node.max_y.y);
    out_node.z = vec4(node.min_z.x, node.min_z.y, node.max_z.x, node.max_z.y);
    out_node.child = uvec2(node.child.x, node.child.y);
    out_node.pad = uvec2(0u, 0u);
    return out_node;
}

SHARED_FN BvhNode decode_binary(BvhNodeBinary node) {
    const float infinity = 3e38f;
    BvhNode out_node;
    out_node.min_x = vec4(node.x.x, node.x.y, infinity, infinity);
    out_node.max_x = vec4(node.x.z, node.x.w, -infinity, -infinity);
    out_node.min_y = vec4(node.y.x, node.y.y, infinity, infinity);
    out_node.max_y = vec4(node.y.z, node.y.w, -infinity, -infinity);
    out_node.min_z = vec4(node.z.x, node.z.y, infinity, infinity);
    out_node.max_z = vec4(node.z.z, node.z.w, -infinity, -infinity);
    out_node.child = uvec4(node.child.x, node.child.y, kBvhEmpty, kBvhEmpty);
    return out_node;
}

// ---- four children, 8 bits a plane ----

// The planes of one axis, quantised.
struct QuantisedAxis {
    float origin, scale;
    uint low, high;  // a byte a child
};

// Where plane n lies. n scale has at most 24 bits, so only the sum rounds, with or without a fused product.
SHARED_FN float quantised_plane(float origin, float scale, float n) { return origin + n * scale; }

// The next larger number of 16 significant bits.
SHARED_FN float next_scale(float scale) { return uintBitsToFloat((floatBitsToUint(scale) | 0xFFu) + 1u); }

// A first guess at the n of a plane: right, or one off, as far as exact planes go. Rounding keeps their order.
SHARED_FN float guess_n(float origin, float per_scale, float plane) { return float(int(min(max((plane - origin) * per_scale, 0.0f), 255.0f))); }

// The largest n whose plane does not lie above `plane`; plane 0 never does.
SHARED_FN uint quantise_down(float origin, float scale, float per_scale, float plane) {
    const float guess = guess_n(origin, per_scale, plane), n = guess - (quantised_plane(origin, scale, guess) > plane ? 1.0f : 0.0f);
    return uint(int(min(max(n + (quantised_plane(origin, scale, n + 1.0f) <= plane ? 1.0f : 0.0f), 0.0f), 255.0f)));
}

// The smallest n whose plane does not lie below `plane`; plane 255 never does.
SHARED_FN uint quantise_up(float origin, float scale, float per_scale, float plane) {
    const float guess = guess_n(origin, per_scale, plane), n = guess + (quantised_plane(origin, scale, guess) < plane ? 1.0f : 0.0f);
    return uint(int(min(n + (quantised_plane(origin, scale, n) < plane ? 1.0f : 0.0f), 255.0f)));
}

// Rounds outwards: each quantised interval contains the given one, down to the last bit. Empty children get 255 to 0.
SHARED_FN QuantisedAxis quantise_axis(vec4 low, vec4 high, uvec4 child) {
    const float infinity = 3e38f;
    const vec4 used_low = vec4(child.x != kBvhEmpty ? low.x : infinity, child.y != kBvhEmpty ? low.y : infinity,
                               child.z != kBvhEmpty ? low.z : infinity, child.w != kBvhEmpty ? low.w : infinity);
    const vec4 used_high = vec4(child.x != kBvhEmpty ? high.x : -infinity, child.y != kBvhEmpty ? high.y : -infinity,
                                child.z != kBvhEmpty ? high.z : -infinity, child.w != kBvhEmpty ? high.w : -infinity);
    const float first = min(min(used_low.x, used_low.y), min(used_low.z, used_low.w)), last = max(max(used_high.x, used_high.y), max(used_high.z, used_high.w));
    const float smallest = 1e-30f;  // keeps products normal, as devices may flush others to zero
    QuantisedAxis axis;
    axis.origin = first <= last ? first : 0.0f;
    // A step of the scale is at least 2^-16 of it and the quotient good to 2^-22, so plane 255 does not lie below `last`.
    axis.scale = next_scale(first <= last ? max((last - first) * (1.0f / 255.0f), smallest) : smallest);
    const float per_scale = 1.0f / axis.scale;
    axis.low = (child.x != kBvhEmpty ? quantise_down(axis.origin, axis.scale, per_scale, low.x) : 255u) | (child.y != kBvhEmpty ? quantise_down(axis.origin, axis.scale, per_scale, low.y) : 255u) << 8 |
               (child.z != kBvhEmpty ? quantise_down(axis.origin, axis.scale, per_scale, low.z) : 255u) << 16 | (child.w != kBvhEmpty ? quantise_down(axis.origin, axis.scale, per_scale, low.w) : 255u) << 24;
    axis.high = (child.x != kBvhEmpty ? quantise_up(axis.origin, axis.scale, per_scale, high.x) : 0u) | (child.y != kBvhEmpty ? quantise_up(axis.origin, axis.scale, per_scale, high.y) : 0u) << 8 |
                (child.z != kBvhEmpty ? quantise_up(axis.origin, axis.scale, per_scale, high.z) : 0u) << 16 | (child.w != kBvhEmpty ? quantise_up(axis.origin, axis.scale, per_scale, high.w) : 0u) << 24;
    return axis;
}

SHARED_FN BvhNodeCompact encode_compact(BvhNode node) {
    const QuantisedAxis x = quantise_axis(node.min_x, node.max_x, node.child), y = quantise_axis(node.min_y, node.max_y, node.child),
                        z = quantise_axis(node.min_z, node.max_z, node.child);
    BvhNodeCompact out_node;
    out_node.origin = vec3(x.origin, y.origin, z.origin);
    out_node.scale = vec3(x.scale, y.scale, z.scale);
    out_node.min_x = x.low;
    out_node.max_x = x.high;
    out_node.min_y = y.low;
    out_node.max_y = y.high;
    out_node.min_z = z.low;
    out_node.max_z = z.high;
    out_node.child = node.child;
    return out_node;
}

SHARED_FN vec4 unpack_bytes(uint bytes) { return vec4(float(bytes & 0xFFu), float((bytes >> 8) & 0xFFu), float((bytes >> 16) & 0xFFu), float(bytes >> 24)); }

SHARED_FN BvhNode decode_compact(BvhNodeCompact node) {
    BvhNode out_node;
    out_node.min_x = unpack_bytes(node.min_x) * node.scale.x + node.origin.x;
    out_node.max_x = unpack_bytes(node.max_x) * node.scale.x + node.origin.x;
    out_node.min_y = unpack_bytes(node.min_y) * node.scale.y + node.origin.y;
    out_node.max_y = unpack_bytes(node.max_y) * node.scale.y + node.origin.y;
    out_node.min_z = unpack_bytes(node.min_z) * node.scale.z + node.origin.z;
    out_node.max_z = unpack_bytes(node.max_z) * node.scale.z + node.origin.z;
    out_node.child = node.child;
    return out_node;
}

// ---- reading ----

// Memory as rows of 16 bytes, read in one of two ways: as vectors of four words, which GPUs load at once; or as pairs of 64-bit
// words. CPU devices gather one component after the other, for all rays of a vector: half as many components, half the work.
SHARED_ARRAY_16(BvhRows, uvec4)
SHARED_ARRAY_16(BvhPairRows, u64vec2)

SHARED_FN uvec4 fetch_row(uint64_t address, uint row, bool in_pairs) {
    if (!in_pairs) return BvhRows(address).v[row];
    const u64vec2 pairs = BvhPairRows(address).v[row];
    return uvec4(uint(pairs.x), uint(pairs.x >> 32), uint(pairs.y), uint(pairs.y >> 32));
}

SHARED_FN vec4 to_floats(uvec4 row) { return vec4(uintBitsToFloat(row.x), uintBitsToFloat(row.y), uintBitsToFloat(row.z), uintBitsToFloat(row.w)); }
SHARED_FN vec3 to_floats(uint x, uint y, uint z) { return vec3(uintBitsToFloat(x), uintBitsToFloat(y), uintBitsToFloat(z)); }

SHARED_FN BvhNodeBinary fetch_binary(uint64_t nodes, uint index, bool in_pairs) {
    const uint64_t address = row_address(nodes, index, 64u);
    const uvec4 links = fetch_row(address, 3u, in_pairs);
    BvhNodeBinary node;
    node.x = to_floats(fetch_row(address, 0u, in_pairs));
    node.y = to_floats(fetch_row(address, 1u, in_pairs));
    node.z = to_floats(fetch_row(address, 2u, in_pairs));
    node.child = uvec2(links.x, links.y);
    node.pad = uvec2(0u, 0u);
    return node;
}

SHARED_FN BvhNode fetch_four(uint64_t nodes, uint index, bool in_pairs) {
    const uint64_t address = row_address(nodes, index, 112u);
    BvhNode node;
    node.min_x = to_floats(fetch_row(address, 0u, in_pairs));
    node.max_x = to_floats(fetch_row(address, 1u, in_pairs));
    node.min_y = to_floats(fetch_row(address, 2u, in_pairs));
    node.max_y = to_floats(fetch_row(address, 3u, in_pairs));
    node.min_z = to_floats(fetch_row(address, 4u, in_pairs));
    node.max_z = to_floats(fetch_row(address, 5u, in_pairs));
    node.child = fetch_row(address, 6u, in_pairs);
    return node;
}

SHARED_FN BvhNodeCompact fetch_compact(uint64_t nodes, uint index, bool in_pairs) {
    const uint64_t address = row_address(nodes, index, 64u);
    const uvec4 first = fetch_row(address, 0u, in_pairs), second = fetch_row(address, 1u, in_pairs), third = fetch_row(address, 2u, in_pairs);
    BvhNodeCompact node;
    node.origin = to_floats(first.x, first.y, first.z);
    node.min_x = first.w;
    node.scale = to_floats(second.x, second.y, second.z);
    node.max_x = second.w;
    node.min_y = third.x;
    node.max_y = third.y;
    node.min_z = third.z;
    node.max_z = third.w;
    node.child = fetch_row(address, 3u, in_pairs);
    return node;
}

// Node `index` of an array of nodes of a layout.
SHARED_FN BvhNode fetch_node(uint64_t nodes, uint index, uint layout_of_nodes) {
    if (layout_of_nodes == kBvhBinary) return decode_binary(fetch_binary(nodes, index, false));
    if (layout_of_nodes == kBvhCompact) return decode_compact(fetch_compact(nodes, index, false));
    return fetch_four(nodes, index, false);
}

SHARED_END
#endif
