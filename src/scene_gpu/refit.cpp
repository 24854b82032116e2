// Our bottom levels of deformed meshes: the plan of the mesh at rest, made once on the host, and the passes that put boxes around each
// form's triangles where the upload left them (shared/refit.h).
#include <chrono>

#include "scene_gpu/chunks.h"
#include "scene_gpu/state.h"

namespace parhelion {

namespace {

// The work of one frame's refits.
struct RefitWork {
    std::vector<shared::RefitJob> jobs;
    std::vector<shared::RefitPart> parts;
    std::vector<shared::WorkChunk> triangle_chunks, node_chunks;
    uint32_t scratch_rows = 0;
};

struct TrianglesPush {
    uint64_t jobs = 0, chunks = 0, parts = 0, plan = 0, triangles = 0;
    uint32_t chunk_count;
};
struct NodesPush {
    uint64_t jobs = 0, chunks = 0, plan = 0, triangles = 0, nodes = 0, boxes = 0, counters = 0;
    uint32_t chunk_count, layout_of_nodes;
};

void add_job(RefitWork& work, const MeshOnDevice& mesh, const RefitPlanOnDevice& plan) {
    const auto index = static_cast<uint32_t>(work.jobs.size());
    const shared::RefitJob job{.plan_node = static_cast<uint32_t>(plan.nodes),
                               .plan_triangle = static_cast<uint32_t>(plan.triangles),
                               .node_count = static_cast<uint32_t>(plan.node_count),
                               .triangle_count = static_cast<uint32_t>(plan.triangle_count),
                               .node = static_cast<uint32_t>(mesh.own_nodes),
                               .triangle = static_cast<uint32_t>(mesh.own_triangles),
                               .part = static_cast<uint32_t>(work.parts.size()),
                               .scratch = work.scratch_rows};
    for (const PartOnDevice& part : mesh.parts) work.parts.push_back({part.positions.address(), part.indices.address()});
    add_chunks(work.triangle_chunks, index, job.triangle_count);
    add_chunks(work.node_chunks, index, job.node_count);
    work.scratch_rows += job.node_count;
    work.jobs.push_back(job);
}

shared::BvhNode node_around(const Bounds& bounds) {
    shared::BvhNode node{};
    node.child = glm::uvec4(shared::kBvhLeaf, shared::kBvhEmpty, shared::kBvhEmpty, shared::kBvhEmpty);
    node.min_x.x = bounds.min.x, node.max_x.x = bounds.max.x;
    node.min_y.x = bounds.min.y, node.max_y.x = bounds.max.y;
    node.min_z.x = bounds.min.z, node.max_z.x = bounds.max.z;
    return node;
}

template <class T>
RowSource plan_rows(const RowArray& array, uint64_t first_row, const std::vector<T>& rows) {
    return {array.buffer(), first_row * sizeof(T), sizeof(T), rows.size(),
            [&rows](std::byte* to, uint64_t first, uint64_t count) { std::memcpy(to, rows.data() + first, count * sizeof(T)); }};
}

}  // namespace

void SceneGpu::State::plan_refits(Frame& frame, Slice& slice) {
    if (!options.own_bvh) return;
    for (const Handle<Mesh> handle : resident_meshes) {
        MeshOnDevice& mesh = meshes.at(handle);
        RefitPlanOnDevice& plan = mesh.plan;
        if (!mesh.has_forms || plan.ready) continue;
        if (!plan.host) {
            if (!slice.has_triangles() || !slice.has_bytes()) return;
            const auto start = std::chrono::steady_clock::now();
            plan.host = std::make_unique<bvh::RefitPlan>(bvh::plan_refit(bottom_geometries(scene->get(handle)), layout));
            stats.own_build_seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
            slice.take_triangles(mesh.triangle_count);
        }
        if (plan.node_count == 0) {
            plan.node_count = plan.host->nodes.size();
            plan.triangle_count = plan.host->triangles.size();
            plan.nodes = plan_nodes.take(frame, plan.node_count);
            plan.triangles = plan_triangles.take(frame, plan.triangle_count);
        }
        const RowSource rows[] = {plan_rows(plan_nodes, plan.nodes, plan.host->nodes), plan_rows(plan_triangles, plan.triangles, plan.host->triangles)};
        if (!upload_rows(frame, slice, rows, plan.done_rows)) return;
        plan.host.reset();
        plan.ready = true;
    }
}

void SceneGpu::State::refit_own_bottoms(Frame& frame, Slice& slice) {
    if (!options.own_bvh) return;
    RefitWork work;
    for (const Handle<Mesh> handle : wanted_meshes) {
        MeshOnDevice& mesh = meshes.at(handle);
        if (mesh.own_ready || !mesh.rest || !mesh.uploaded) continue;
        const RefitPlanOnDevice& plan = meshes.at(mesh.rest).plan;
        if (!plan.ready || !slice.has_triangles()) continue;
        take_own_rows(frame, mesh, plan.node_count, plan.triangle_count);
        add_job(work, mesh, plan);
        mesh.own_root = bvh::RootBoxes(node_around(scene->get(handle).bounds));
        mesh.own_ready = true;
        slice.take_triangles(mesh.triangle_count);
    }
    if (work.jobs.empty()) return;
    const gpu::Buffer jobs = upload_list(frame, "refit_jobs", work.jobs), parts = upload_list(frame, "refit_parts", work.parts),
                      triangle_chunks = upload_list(frame, "refit_triangle_chunks", work.triangle_chunks), node_chunks = upload_list(frame, "refit_node_chunks", work.node_chunks),
                      boxes(device, "scene/refit_boxes", work.scratch_rows * sizeof(float) * 6), counters(device, "scene/refit_counters", work.scratch_rows * sizeof(uint32_t));
    frame.fill(counters, 0);
    over_chunks(frame.compute("scene_gpu/refit_triangles")
                    .read("jobs", jobs)
                    .read("chunks", triangle_chunks)
                    .read("parts", parts)
                    .reach(geometry_buffers())
                    .read("plan", plan_triangles.buffer())
                    .write("triangles", bottom_triangles.buffer())
                    .push(TrianglesPush{.chunk_count = static_cast<uint32_t>(work.triangle_chunks.size())}),
                work.triangle_chunks.size());
    over_chunks(frame.compute("scene_gpu/refit_nodes")
                    .read("jobs", jobs)
                    .read("chunks", node_chunks)
                    .read("plan", plan_nodes.buffer())
                    .read("triangles", bottom_triangles.buffer())
                    .write("nodes", bottom_nodes.buffer())
                    .read_write("boxes", boxes)
                    .read_write("counters", counters)
                    .push(NodesPush{.chunk_count = static_cast<uint32_t>(work.node_chunks.size()), .layout_of_nodes = static_cast<uint32_t>(layout)}),
                work.node_chunks.size());
}

}  // namespace parhelion
