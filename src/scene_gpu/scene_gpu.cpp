#include "scene_gpu/scene_gpu.h"

#include "base/error.h"
#include "sampling/blue_noise.h"
#include "sampling/sobol.h"
#include "scene_gpu/state.h"

namespace parhelion {

SceneGpu::SceneGpu(gpu::DevicePtr device, const SceneGpuOptions& options) : state_(std::make_unique<State>()) {
    state_->device = std::move(device);
    state_->options = options;
}
SceneGpu::~SceneGpu() = default;

const SceneBinding& SceneGpu::binding() const { return state_->binding; }
const SceneGpuStats& SceneGpu::stats() const { return state_->stats; }

void SceneGpu::sync(const Scene& scene) {
    state_->scene = &scene;
    state_->structure_stale = state_->edited = true;
}

void SceneGpu::sync(const Scene& scene, const ChangeSet& changes) {
    state_->scene = &scene;
    state_->structure_stale |= !changes.materials.empty() || !changes.meshes.empty();
    state_->textures_stale |= !changes.images.empty() || !changes.textures.empty() || changes.environment;
    state_->edited |= !changes.empty();
    state_->placement_stale |= !changes.instances.empty() || !changes.lights.empty() || state_->unsettled;
    state_->unsettled = false;
}

void SceneGpu::update(Frame& frame) {
    State& s = *state_;
    PARHELION_CHECK(s.scene != nullptr, "SceneGpu::update() before sync()");
    if (!s.structure_stale && !s.textures_stale && !s.placement_stale) return;
    if (s.structure_stale || s.textures_stale) {
        s.upload_materials(frame);
        s.upload_environment(frame);
    }
    if (s.structure_stale) {
        s.upload_geometry(frame);
        // The previous top level points at bottom levels that are no more: the past is the present then.
        s.tlas[s.parity] = {};
        s.top_nodes[s.parity] = s.top_items[s.parity] = {};
    }
    if (!s.sampler_tables) {
        std::vector<uint32_t> tables = sampling::sobol_table();
        const std::vector<uint32_t> tile = sampling::blue_noise_words();
        tables.insert(tables.end(), tile.begin(), tile.end());
        s.sampler_tables = s.make_buffer(frame, "sampler_tables", tables);
    }
    s.parity ^= 1;
    s.place_instances(frame);
    s.place_emitters(frame);
    s.write_header(frame);
    s.structure_stale = s.textures_stale = s.placement_stale = false;
    s.unsettled = s.edited;
    s.edited = false;
}

// The header and set 0 alternate, so that the previous frame may still be in flight.
void SceneGpu::State::write_header(Frame& frame) {
    const auto address = [](const gpu::Buffer& buffer) { return buffer ? buffer.address() : 0; };
    shared::SceneHeader header{};
    header.instances = address(instance_table);
    header.geometries = address(geometry_table);
    header.materials = address(material_table);
    header.geometry_emitters = address(geometry_emitters);
    header.emitters = address(emitter_table);
    header.emitter_table = address(emitter_alias);
    header.triangle_tables = address(triangle_alias);
    header.environment_table = address(environment_alias);
    header.bottom_nodes = address(bottom_nodes);
    header.bottom_triangles = address(bottom_triangles);
    header.top_nodes = address(top_nodes[parity]);
    header.top_items = address(top_items[parity]);
    header.top_nodes_before = address(top_nodes[1 - parity] ? top_nodes[1 - parity] : top_nodes[parity]);
    header.top_items_before = address(top_items[1 - parity] ? top_items[1 - parity] : top_items[parity]);
    header.sobol = address(sampler_tables);
    header.blue_noise = address(sampler_tables) + sampling::sobol_table().size() * sizeof(uint32_t);
    header.suns = address(suns);
    header.sun_count = static_cast<uint32_t>(sun_rows.size());
    header.emitter_count = static_cast<uint32_t>(emitters.size());
    header.culling = options.culling ? 1 : 0;
    header.environment = environment;

    gpu::Buffer& block = header_buffer[parity];
    block = gpu::Buffer(device, "scene/header", sizeof(header));
    frame.upload(block, 0, std::as_bytes(std::span(&header, 1)));
    gpu::SceneSet& set = sets[parity];
    set = gpu::SceneSet(device, "scene/set", std::max<uint32_t>(1, static_cast<uint32_t>(textures.size())));
    set.set_header(block);
    for (uint32_t slot = 0; slot < textures.size(); ++slot) set.set_texture(slot, textures[slot].first, textures[slot].second);
    const gpu::AccelStruct& before = tlas[1 - parity] ? tlas[1 - parity] : tlas[parity];
    if (uses_hardware()) set.set_accel(tlas[parity], before);

    binding = {.set = set,
               .buffers = {block, positions, indices, attributes, geometry_table, material_table, instance_table, emitter_table, emitter_alias, triangle_alias,
                           geometry_emitters, environment_alias, suns, sampler_tables},
               .textures = images};
    for (const gpu::Buffer& buffer : {bottom_nodes, bottom_triangles, top_nodes[0], top_items[0], top_nodes[1], top_items[1]})
        if (buffer) binding.buffers.push_back(buffer);
    if (uses_hardware()) {
        binding.accels = {tlas[parity], before};
        for (const auto& [handle, mesh] : meshes) binding.accels.push_back(mesh.blas);
    }
}

}  // namespace parhelion
