// Whether the trees that deformed forms have of their mesh at rest still fit: measured on the device as forms are made, and where they have become
// loose a tree is made of a form instead, from which those after it get theirs.
#include "scene/deform.h"
#include "scene_gpu/chunks.h"
#include "scene_gpu/state.h"

namespace parhelion {

namespace {

constexpr uint32_t kFormsAMeasure = 8;     // of a mesh: one of so many is measured
constexpr double kTooLoose = 1.5;          // times what it was when the tree was made
constexpr uint32_t kFormsARebuild = 32;    // at least, between two trees of a mesh

struct DecayPush {
    uint64_t jobs = 0, chunks = 0, areas = 0;
    uint32_t chunk_count;
};

// Boxes over triangles, of clusters [first, first + count).
double looseness(std::span<const glm::vec2> areas) {
    double boxes = 0, triangles = 0;
    for (const glm::vec2& area : areas) boxes += area.x, triangles += area.y;
    return triangles > 0 ? boxes / triangles : 0;
}

// As decay.comp does it.
double looseness_of(const Mesh& mesh) {
    std::vector<glm::vec2> areas;
    for (const Primitive& p : mesh.primitives)
        for (size_t first = 0; first < p.triangles.size(); first += shared::kWorkChunk) {
            Bounds box;
            float area = 0;
            for (size_t i = first; i < std::min<size_t>(first + shared::kWorkChunk, p.triangles.size()); ++i) {
                const glm::vec3 &a = p.positions[p.triangles[i].x], &b = p.positions[p.triangles[i].y], &c = p.positions[p.triangles[i].z];
                for (const glm::vec3& corner : {a, b, c}) box.add(corner);
                area += 0.5f * glm::length(glm::cross(b - a, c - a));
            }
            const glm::vec3 extent = box.max - box.min;
            areas.emplace_back(2.0f * glm::dot(extent, glm::vec3(extent.y, extent.z, extent.x)), area);
        }
    return looseness(areas);
}

}  // namespace

// Of forms that have come to the device since: of those of meshes whose trees are new, the next one as what others are held against.
void SceneGpu::State::measure_decay(Frame& frame) {
    std::vector<shared::DecayJob> jobs;
    std::vector<shared::WorkChunk> chunks;
    DecayReading reading;
    for (const Handle<Mesh> handle : wanted_meshes) {
        MeshOnDevice& form = meshes.at(handle);
        if (!form.rest || !form.uploaded || form.looked_at) continue;
        form.looked_at = true;
        MeshOnDevice& rest = meshes.at(form.rest);
        // Where all forms have arrays of their own, those of the mesh at rest need not be on the device.
        if (rest.looseness == 0 && !rest.base_asked && !rest.tree_of_form && !rest.uploaded) rest.looseness = looseness_of(scene->get(form.rest));
        const bool is_base = rest.looseness == 0 && !rest.base_asked;
        if (rest.forms_made++ % kFormsAMeasure != 0 && !is_base) continue;
        rest.base_asked |= is_base;
        // The tree is that of the mesh at rest, until another was made.
        const MeshOnDevice& measured = is_base && rest.uploaded && !rest.tree_of_form ? rest : form;
        const size_t first = chunks.size();
        for (const PartOnDevice& part : measured.parts) {
            add_chunks(chunks, static_cast<uint32_t>(jobs.size()), part.triangle_count);
            jobs.push_back({part.positions.address(), part.indices.address(), part.triangle_count});
        }
        reading.forms.push_back({form.rest, first, chunks.size() - first, is_base});
    }
    if (chunks.empty()) return;
    const gpu::Buffer areas(device, "scene/decay_areas", chunks.size() * sizeof(glm::vec2));
    over_chunks(frame.compute("scene_gpu/decay")
                    .read("jobs", upload_list(frame, "decay_jobs", jobs))
                    .read("chunks", upload_list(frame, "decay_chunks", chunks))
                    .reach(geometry_buffers())
                    .write("areas", areas)
                    .push(DecayPush{.chunk_count = static_cast<uint32_t>(chunks.size())}),
                chunks.size());
    reading.areas = frame.read_back(areas);
    decay_readings.push_back(std::move(reading));
}

// The frame that measured is done when it no longer holds what it was written to.
void SceneGpu::State::read_decay() {
    std::erase_if(decay_readings, [&](const DecayReading& reading) {
        if (reading.areas.data().use_count() > 1) return false;
        const std::span<const glm::vec2> areas = reading.areas.mapped_as<const glm::vec2>();
        for (const DecayReading::Form& form : reading.forms) {
            const auto found = meshes.find(form.rest);
            if (found == meshes.end()) continue;
            MeshOnDevice& rest = found->second;
            const double loose = looseness(areas.subspan(form.first, form.count));
            if (form.is_base) rest.looseness = loose;
            if (rest.looseness == 0) continue;
            stats.tree_decay = loose / rest.looseness;
            const bool fits = stats.tree_decay < kTooLoose && stats.tree_decay > 1 / kTooLoose;  // a shape that was torn fits the whole one no better
            if (fits || rest.forms_made - rest.forms_at_rebuild < kFormsARebuild) continue;
            rest.rebuild_own = options.own_bvh;
            rest.rebuild_driver = uses_hardware();
        }
        return true;
    });
}

void SceneGpu::State::note_rebuilt(MeshOnDevice& rest) {
    ++stats.rebuilt_trees;
    rest.forms_at_rebuild = rest.forms_made;
    rest.looseness = 0;
    rest.base_asked = false;
    rest.tree_of_form = true;
}

// A plan out of the first form that is there, a mesh a frame; the forms of this frame have it already.
void SceneGpu::State::replan_refits(Slice& slice) {
    if (!options.own_bvh) return;
    for (const Handle<Mesh> handle : wanted_meshes) {
        const MeshOnDevice& form = meshes.at(handle);
        if (!form.rest || form.own_ready || !form.uploaded) continue;
        MeshOnDevice& rest = meshes.at(form.rest);
        if (!rest.rebuild_own || !rest.plan.ready || !slice.has_triangles()) continue;
        const Mesh& source = scene->get(handle);
        std::vector<Primitive> shapes(source.primitives.size());
        std::vector<bvh::BottomGeometry> geometries_of_form;
        for (size_t g = 0; g < shapes.size(); ++g) {
            const Primitive& shape = drawn_shape(*scene, source, g, shapes[g]);
            geometries_of_form.push_back({shape.positions, shape.triangles});
        }
        plan_nodes.give(rest.plan.nodes, rest.plan.node_count);
        plan_triangles.give(rest.plan.triangles, rest.plan.triangle_count);
        rest.plan = {.host = std::make_unique<bvh::RefitPlan>(bvh::plan_refit(geometries_of_form, layout))};
        slice.take_triangles(rest.triangle_count);
        rest.rebuild_own = false;
        note_rebuilt(rest);
        return;
    }
}

}  // namespace parhelion
