#version 460
// Nodes of deformed meshes' bottom levels (shared/refit.h), from the leaves to the root in one dispatch: whoever finishes the last
// inner child of a node goes on with the node (Karras 2012, "Maximizing Parallelism in the Construction of BVHs, Octrees, and k-d Trees").
// Minima and maxima do not depend on who that is. Reads: jobs, chunks, plan, triangles. Writes: nodes, in the layout of the scene's;
// boxes and counters (zero before) are scratch memory. Boxes are kept as floats on the way up, so that each is rounded once.
#extension GL_GOOGLE_include_directive : require
#include "lib/bvh_nodes.glsl"
#include "shared/refit.h"

struct RefitBox {
    vec3 low, high;
};

layout(local_size_x = 64) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Jobs { RefitJob v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Chunks { WorkChunk v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Plan { RefitNode v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Triangles { BvhTriangle v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) coherent buffer Boxes { RefitBox v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) coherent buffer Counters { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) writeonly buffer NodesFour { BvhNode v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) writeonly buffer NodesBinary { BvhNodeBinary v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) writeonly buffer NodesCompact { BvhNodeCompact v[]; };
layout(push_constant, scalar) uniform Push {
    Jobs jobs;
    Chunks chunks;
    Plan plan;
    Triangles triangles;
    NodesFour nodes;  // or of another layout
    Boxes boxes;
    Counters counters;
    uint chunk_count;
    uint layout_of_nodes;
} push;

bool is_inner(uint child) { return (child & kBvhLeaf) == 0u; }
uint inner_children(RefitNode plan) { return uint(is_inner(plan.child.x)) + uint(is_inner(plan.child.y)) + uint(is_inner(plan.child.z)) + uint(is_inner(plan.child.w)); }

RefitBox empty_box() { return RefitBox(vec3(3e38), vec3(-3e38)); }
RefitBox joined(RefitBox a, RefitBox b) { return RefitBox(min(a.low, b.low), max(a.high, b.high)); }

RefitBox box_of_leaf(RefitJob job, uint first) {
    RefitBox box = empty_box();
    uint rest = 1u;
    for (uint i = job.triangle + first; rest != 0u; ++i) {
        const uint64_t address = row_address(uint64_t(push.triangles), i, 48u);  // of a BvhTriangle
        const uvec4 a = fetch_row(address, 0u, false), b = fetch_row(address, 1u, false), c = fetch_row(address, 2u, false);
        const vec3 p0 = to_floats(a.x, a.y, a.z), p1 = to_floats(a.w, b.x, b.y), p2 = to_floats(b.z, b.w, c.x);
        box = joined(box, RefitBox(min(p0, min(p1, p2)), max(p0, max(p1, p2))));
        rest = c.y;
    }
    return box;
}

RefitBox box_of_child(RefitJob job, uint child) {
    if (child == kBvhEmpty) return empty_box();
    if (!is_inner(child)) return box_of_leaf(job, child & kBvhItemMask);
    return push.boxes.v[job.scratch + child];
}

uint moved(RefitJob job, uint child) { return child == kBvhEmpty ? child : is_inner(child) ? child + job.node : child + job.triangle; }

void store_node(uint index, BvhNode node) {
    const uint64_t nodes = uint64_t(push.nodes);
    if (push.layout_of_nodes == kBvhBinary) NodesBinary(row_address(nodes, index, 64u)).v[0] = encode_binary(node);
    else if (push.layout_of_nodes == kBvhCompact) NodesCompact(row_address(nodes, index, 64u)).v[0] = encode_compact(node);
    else NodesFour(row_address(nodes, index, 112u)).v[0] = node;
}

// Makes the node whose inner children are done; returns the box around it all.
RefitBox make_node(RefitJob job, uint index, uvec4 child) {
    const RefitBox a = box_of_child(job, child.x), b = box_of_child(job, child.y), c = box_of_child(job, child.z), d = box_of_child(job, child.w);
    store_node(job.node + index, BvhNode(vec4(a.low.x, b.low.x, c.low.x, d.low.x), vec4(a.high.x, b.high.x, c.high.x, d.high.x),
                                         vec4(a.low.y, b.low.y, c.low.y, d.low.y), vec4(a.high.y, b.high.y, c.high.y, d.high.y),
                                         vec4(a.low.z, b.low.z, c.low.z, d.low.z), vec4(a.high.z, b.high.z, c.high.z, d.high.z),
                                         uvec4(moved(job, child.x), moved(job, child.y), moved(job, child.z), moved(job, child.w))));
    return joined(joined(a, b), joined(c, d));
}

void main() {
    const uint group = gl_WorkGroupID.y * kWorkGroups + gl_WorkGroupID.x;
    if (group >= push.chunk_count) return;
    const WorkChunk chunk = push.chunks.v[group];
    const RefitJob job = push.jobs.v[chunk.job];
    uint index = chunk.first + gl_LocalInvocationIndex;
    if (index >= job.node_count) return;
    RefitNode plan = push.plan.v[job.plan_node + index];
    uint missing = inner_children(plan);
    while (missing == 0u) {
        push.boxes.v[job.scratch + index] = make_node(job, index, plan.child);
        index = plan.parent;
        if (index == kBvhEmpty) return;
        plan = push.plan.v[job.plan_node + index];
        memoryBarrierBuffer();
        missing = inner_children(plan) - 1u - atomicAdd(push.counters.v[job.scratch + index], 1u);
        memoryBarrierBuffer();
    }
}
