#include "scene_gpu/scene_gpu.h"

#include "base/error.h"
#include "scene_gpu/state.h"

namespace parhelion {

SceneGpu::State::State(gpu::DevicePtr the_device, const SceneGpuOptions& the_options)
    : device(std::move(the_device)),
      options(the_options),
      layout(choose_node_layout(device->caps(), options.node_layout)),
      geometry_pool(device, "scene/geometry", options.geometry_buffer_bytes),
      form_pool(device, "scene/forms", options.geometry_buffer_bytes),
      deformer_pool(device, "scene/deformers", options.geometry_buffer_bytes),
      bottom_nodes(device, "scene/bottom_nodes", bvh::node_bytes(layout)),
      bottom_triangles(device, "scene/bottom_triangles", sizeof(shared::BvhTriangle)),
      plan_nodes(device, "scene/refit_plan_nodes", sizeof(shared::RefitNode)),
      plan_triangles(device, "scene/refit_plan_triangles", sizeof(shared::RefitTriangle)),
      own_top(layout) {}

SceneGpu::SceneGpu(gpu::DevicePtr device, const SceneGpuOptions& options) : state_(std::make_unique<State>(std::move(device), options)) {}
SceneGpu::~SceneGpu() = default;

uint64_t SceneGpu::version() const { return state_->version; }
uint64_t SceneGpu::light_switches() const { return state_->light_switches; }
uint32_t SceneGpu::features() const { return state_->features_shown; }
const SceneGpuStats& SceneGpu::stats() const { return state_->stats; }
const SceneBinding& SceneGpu::binding() const {
    PARHELION_CHECK(state_->published > 0, "the scene is not on the device yet: SceneGpu::update() has not said drawable");
    return state_->binding;
}

const DrawnGeometries& SceneGpu::drawn() const {
    PARHELION_CHECK(state_->drawn_now.table, "SceneGpu has no table of what is drawn: it was made without SceneGpuOptions::raster, or shows nothing yet");
    return state_->drawn_now;
}

void SceneGpu::sync(const Scene& scene) {
    state_->begin_anew();
    state_->scene = &scene;
}

void SceneGpu::sync(const Scene& scene, const ChangeSet& changes) {
    State& s = *state_;
    if (s.scene != &scene) return sync(scene);
    s.materials_stale |= !changes.materials.empty();
    s.textures_stale |= !changes.images.empty() || !changes.textures.empty() || !changes.materials.empty();  // another one may be drawn
    s.environment_stale |= changes.environment;
    s.edited |= !changes.empty();
    s.anything_stale |= !changes.empty() || s.unsettled;
    s.unsettled = false;
    s.frame_began = true;
}

SceneProgress SceneGpu::update(Frame& frame) {
    State& s = *state_;
    PARHELION_CHECK(s.scene != nullptr, "SceneGpu::update() before sync()");
    Slice slice(s.options.slice_bytes, s.options.slice_triangles);
    if (!s.advance(frame, slice)) s.settle(frame);
    return s.progress;
}

bool SceneGpu::State::advance(Frame& frame, Slice& slice) {
    if (!tables_running) {
        if (!anything_stale && measurements.empty() && !moved_by_compaction) return false;
        plan();
        upload_images(frame, slice);
        make_proxies(slice);
        upload_meshes(frame, slice);
        choose_proxies();
        upload_deformers(frame, slice);
        deform_meshes(frame, slice);
        read_decay();
        measure_decay(frame);
        replan_refits(slice);
        build_own_bottoms(frame, slice);
        plan_refits(frame, slice);
        refit_own_bottoms(frame, slice);
        build_driver_bottoms(frame, slice);
        compact_bottoms(frame);
        measure_progress();
        if (!is_resident() || (!anything_stale && !moved_by_compaction)) return false;
        make_tables();
    }
    if (!upload_rows(frame, slice, tables, table_rows_done)) return false;
    publish(frame);
    measure_progress();
    return true;
}

void SceneGpu::finish(Frame& frame) {
    while (!update(frame).complete) frame.run();
}

// Another scene has handles of its own: nothing that is here may be found by them. What is drawn now stays until the new is there.
void SceneGpu::State::begin_anew() {
    geometry_pool = BufferPool(device, "scene/geometry", options.geometry_buffer_bytes);
    form_pool = BufferPool(device, "scene/forms", options.geometry_buffer_bytes);
    deformer_pool = BufferPool(device, "scene/deformers", options.geometry_buffer_bytes);
    bottom_nodes = RowArray(device, "scene/bottom_nodes", bvh::node_bytes(layout));
    bottom_triangles = RowArray(device, "scene/bottom_triangles", sizeof(shared::BvhTriangle));
    plan_nodes = RowArray(device, "scene/refit_plan_nodes", sizeof(shared::RefitNode));
    plan_triangles = RowArray(device, "scene/refit_plan_triangles", sizeof(shared::RefitTriangle));
    geometry_rows = FreeRanges(1ull << 32);
    meshes.clear();
    retired_rows.clear();
    measurements.clear();
    decay_readings.clear();
    images.clear();
    environment_image = {};
    geometries.clear();
    geometry_table = triangle_alias = {};
    emissive_parts.clear();
    instances.clear();
    own_top = bvh::MovingTop(layout);
    instance_rows.clear();
    row_meshes.clear();
    emitter_keys.clear();
    emitter_looks.clear();
    free_rows.clear();
    left_rows.clear();
    tables.clear();
    next = {};
    tables_running = moved_by_compaction = unsettled = false;
    anything_stale = materials_stale = textures_stale = environment_stale = environment_table_stale = edited = has_no_past = true;
    stats.own_build_seconds = 0;
    frame_began = true;
}

// Nothing is lost by planning again: what has come in is found by its handle.
void SceneGpu::State::plan() {
    plan_images();
    plan_meshes();
}

// Before there is any picture, the wait for compacted bottom levels costs none.
bool SceneGpu::State::is_resident() const {
    if (published == 0 && !measurements.empty()) return false;
    if (!scene->environment().radiance.empty() && !environment_image.ready) return false;
    for (const auto& [key, image] : images)
        if (image.wanted && !image.ready) return false;
    for (const Handle<Mesh> handle : resident_meshes) {
        const MeshOnDevice& mesh = meshes.at(handle);
        if ((needs_geometry(mesh) && !mesh.uploaded) || (uses_hardware() && !mesh.blas) || (options.own_bvh && mesh.drawn && !mesh.own_ready)) return false;
    }
    return true;
}

// Bytes are the measure; a bottom level counts like as many as it has, about.
void SceneGpu::State::measure_progress() {
    constexpr double kBottomBytes = 64;  // a triangle
    double done = 0, total = 1;
    const auto add = [&](double amount, double share) { total += amount, done += amount * share; };
    for (const auto& [key, image] : images)
        if (image.wanted) add(double(image.bytes), image.ready ? 1.0 : double(image.done_bytes) / double(std::max<uint64_t>(image.bytes, 1)));
    for (const Handle<Mesh> handle : resident_meshes) {
        const MeshOnDevice& mesh = meshes.at(handle);
        uint64_t rows = 0;
        for (const PartOnDevice& part : mesh.parts) rows += 2ull * part.vertex_count + part.triangle_count + part.proxy_count + (part.proxy_count > 0 ? part.triangle_count : 0);
        if (needs_geometry(mesh)) add(double(mesh.bytes), mesh.uploaded ? 1.0 : double(mesh.done_rows) / double(std::max<uint64_t>(rows, 1)));
        if (uses_hardware()) add(kBottomBytes * double(mesh.triangle_count), mesh.blas ? 1 : 0);
        if (options.own_bvh && mesh.drawn) add(kBottomBytes * double(mesh.triangle_count), mesh.own_ready ? 1 : mesh.own_host ? 0.8 : 0);
        if (options.own_bvh && mesh.has_forms) add(kBottomBytes * double(mesh.triangle_count), mesh.plan.ready ? 1 : mesh.plan.host ? 0.8 : 0);
    }
    const bool complete = published > 0 && !tables_running && !anything_stale && !moved_by_compaction && measurements.empty();
    progress = {.drawable = published > 0, .complete = complete, .done = complete ? total : done, .total = total};
}

}  // namespace parhelion
