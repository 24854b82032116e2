// Forms that the device makes (Mesh::deformation): what deforms their mesh at rest, brought in once, and the pass that puts the vertices
// of each form where its weights and joints say.
#include <algorithm>

#include "scene_gpu/chunks.h"
#include "scene_gpu/state.h"
#include "shared/deform.h"

namespace parhelion {

namespace {

// The work of one frame.
struct DeformWork {
    std::vector<shared::DeformJob> jobs;
    std::vector<shared::WorkChunk> chunks;
    std::vector<shared::ActiveTarget> targets;
    std::vector<shared::Affine> palette;
};

struct DeformPush {
    uint64_t jobs = 0, chunks = 0, targets = 0, palette = 0;
    uint32_t chunk_count;
};

constexpr uint64_t kTrianglesOfARefit = 8;  // deforming so many is about as much work as refitting the tree of one

constexpr std::vector<glm::vec3> MorphTarget::*kDeltas[3] = {&MorphTarget::positions, &MorphTarget::normals, &MorphTarget::tangents};

RowSource influence_rows(const BufferRange& to, const Primitive& primitive) {
    return {to.buffer, to.offset, sizeof(shared::JointInfluence), primitive.joints.size(), [&primitive](std::byte* out, uint64_t first, uint64_t count) {
                for (uint64_t i = 0; i < count; ++i) {
                    const shared::JointInfluence row{primitive.joints[first + i], primitive.joint_weights[first + i]};
                    std::memcpy(out + i * sizeof(row), &row, sizeof(row));
                }
            }};
}

shared::Affine to_rows(const glm::mat4x3& m) {
    const auto row = [&](int r) { return glm::vec4(m[0][r], m[1][r], m[2][r], m[3][r]); };
    return {row(0), row(1), row(2)};
}

void add_job(DeformWork& work, const PartOnDevice& rest, const DeformersOnDevice& deformers, const PartOnDevice& form, const MeshDeformation& deformation, uint32_t influence_count, uint32_t joint) {
    shared::DeformJob job{.rest_positions = rest.positions.address(),
                          .rest_attributes = rest.attributes.address(),
                          .positions = form.positions.address(),
                          .attributes = form.attributes.address(),
                          .influences = influence_count != 0 ? deformers.influences.address() : 0,
                          .vertex_count = rest.vertex_count,
                          .influence_count = influence_count,
                          .joint = joint,
                          .target = static_cast<uint32_t>(work.targets.size())};
    for (size_t i = 0; i < std::min(deformation.weights.size(), deformers.targets.size()); ++i) {
        if (deformation.weights[i] == 0.0f) continue;
        const auto address = [&](int kind) { return deformers.targets[i][kind].buffer ? deformers.targets[i][kind].address() : 0; };
        work.targets.push_back({.positions = address(0), .normals = address(1), .tangents = address(2), .weight = deformation.weights[i]});
    }
    job.target_count = static_cast<uint32_t>(work.targets.size()) - job.target;
    add_chunks(work.chunks, static_cast<uint32_t>(work.jobs.size()), job.vertex_count);
    work.jobs.push_back(job);
}

}  // namespace

void SceneGpu::State::upload_deformers(Frame& frame, Slice& slice) {
    for (const Handle<Mesh> handle : resident_meshes) {
        MeshOnDevice& mesh = meshes.at(handle);
        if (!mesh.has_made || mesh.deformers_ready) continue;
        if (!slice.has_bytes()) return;
        const Mesh& source = scene->get(handle);
        const auto take = [&](const auto& values, size_t row_bytes) { return values.empty() ? BufferRange{} : deformer_pool.take(values.size() * row_bytes); };
        std::vector<RowSource> rows;
        const bool is_new = mesh.deformers.empty();
        for (size_t i = 0; i < source.primitives.size(); ++i) {
            const Primitive& primitive = source.primitives[i];
            if (is_new) {
                DeformersOnDevice& deformers = mesh.deformers.emplace_back();
                deformers.influences = take(primitive.joints, sizeof(shared::JointInfluence));
                for (const MorphTarget& target : primitive.targets)
                    deformers.targets.push_back({take(target.positions, sizeof(glm::vec3)), take(target.normals, sizeof(glm::vec3)), take(target.tangents, sizeof(glm::vec3))});
            }
            const DeformersOnDevice& deformers = mesh.deformers[i];
            if (!primitive.joints.empty()) rows.push_back(influence_rows(deformers.influences, primitive));
            for (size_t t = 0; t < primitive.targets.size(); ++t)
                for (int kind = 0; kind < 3; ++kind)
                    if (const std::vector<glm::vec3>& deltas = primitive.targets[t].*kDeltas[kind]; !deltas.empty()) rows.push_back(array_rows(deformers.targets[t][kind], deltas));
        }
        mesh.deformers_ready = upload_rows(frame, slice, rows, mesh.deformer_rows_done);
    }
}

void SceneGpu::State::deform_meshes(Frame& frame, Slice& slice) {
    DeformWork work;
    for (const Handle<Mesh> handle : wanted_meshes) {
        MeshOnDevice& mesh = meshes.at(handle);
        if (!mesh.made_here || mesh.uploaded) continue;
        const MeshOnDevice& rest = meshes.at(mesh.rest);
        if (!rest.uploaded || !rest.deformers_ready || !slice.has_triangles()) continue;
        const Mesh& source = scene->get(mesh.rest);
        const MeshDeformation& deformation = *scene->get(handle).deformation;
        mesh.geometry_base = static_cast<uint32_t>(*geometry_rows.take(rest.parts.size()));
        const auto joint = static_cast<uint32_t>(work.palette.size());
        std::ranges::transform(deformation.object_from_rest, std::back_inserter(work.palette), to_rows);
        for (size_t i = 0; i < rest.parts.size(); ++i) {
            const PartOnDevice& from = rest.parts[i];
            mesh.parts.push_back({.positions = form_pool.take(from.vertex_count * sizeof(glm::vec3)),
                                  .indices = from.indices,
                                  .attributes = form_pool.take(from.vertex_count * sizeof(shared::VertexAttributes)),
                                  .vertex_count = from.vertex_count,
                                  .triangle_count = from.triangle_count});
            add_job(work, from, rest.deformers[i], mesh.parts.back(), deformation, deformation.object_from_rest.empty() ? 0 : source.primitives[i].influence_count, joint);
        }
        mesh.uploaded = true;
        slice.take_triangles(mesh.triangle_count / kTrianglesOfARefit);
    }
    if (work.chunks.empty()) return;
    over_chunks(frame.compute("scene_gpu/deform")
                    .read("jobs", upload_list(frame, "deform_jobs", work.jobs))
                    .read("chunks", upload_list(frame, "deform_chunks", work.chunks))
                    .read("targets", upload_list(frame, "deform_targets", work.targets))
                    .read("palette", upload_list(frame, "deform_palette", work.palette))
                    .reach(geometry_pool.buffers())
                    .reach(deformer_pool.buffers())
                    .reach_written(form_pool.buffers())
                    .push(DeformPush{.chunk_count = static_cast<uint32_t>(work.chunks.size())}),
                work.chunks.size());
}

}  // namespace parhelion
