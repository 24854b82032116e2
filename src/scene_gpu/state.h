#pragma once
// What SceneGpu consists of; one file per part. Each upload_... function records its part from the scene as it is.
#include <unordered_map>
#include <vector>

#include "bvh/bvh.h"
#include "scene_gpu/scene_gpu.h"
#include "shared/scene.h"

namespace parhelion {

// Where a mesh's geometries lie, and its bottom levels.
struct MeshOnDevice {
    uint32_t geometry_base = 0, geometry_count = 0;
    gpu::AccelStruct blas;
    bool cull_by_flag = false;   // every geometry single-sided: the driver culls
    uint32_t own_root = 0;       // our bottom level: its entry in the bottom table
};

struct SceneGpu::State {
    gpu::DevicePtr device;
    SceneGpuOptions options;
    const Scene* scene = nullptr;
    bool structure_stale = true, textures_stale = true, placement_stale = true;
    bool edited = true;      // since the last update
    bool unsettled = false;  // the last update followed an edit: the previous top level is another than the present one

    // geometry.cpp
    std::vector<shared::Geometry> geometries;
    std::unordered_map<Handle<Mesh>, MeshOnDevice> meshes;
    gpu::Buffer positions, indices, attributes, geometry_table;
    bvh::Bottoms bottoms;
    gpu::Buffer bottom_nodes, bottom_triangles;
    // materials.cpp
    std::unordered_map<Handle<Material>, uint32_t> material_rows;
    std::vector<shared::Material> materials;
    gpu::Buffer material_table;
    std::vector<gpu::Image> images;
    std::vector<std::pair<gpu::Image, gpu::Sampler>> textures;  // by slot of the texture table
    // lights.cpp
    std::vector<shared::Emitter> emitters;
    gpu::Buffer emitter_table, emitter_alias, triangle_alias, geometry_emitters, environment_alias, suns;
    std::vector<uint32_t> sun_rows;
    std::unordered_map<uint32_t, uint32_t> triangle_table_of_geometry;  // geometry row -> offset in triangle_alias
    std::vector<shared::AliasEntry> triangle_rows;
    shared::Environment environment{};
    float environment_flux = 0;
    // instances.cpp
    std::vector<shared::Instance> instances;
    std::vector<uint32_t> geometry_emitter_rows;
    std::vector<Handle<Instance>> instance_handles;  // by row; none: the row is free
    std::unordered_map<Handle<Instance>, uint32_t> instance_rows;
    std::vector<uint32_t> free_rows, left_rows;  // free now; left by this frame's edit, still seen by the previous top level
    gpu::Buffer instance_table, tlas_instances;
    gpu::AccelStruct tlas[2];
    gpu::Buffer top_nodes[2], top_items[2];
    // scene_gpu.cpp
    gpu::Buffer sampler_tables;
    gpu::Buffer header_buffer[2];
    gpu::SceneSet sets[2];
    uint32_t parity = 0;
    SceneBinding binding;
    SceneGpuStats stats;

    bool uses_hardware() const { return options.hardware && (device->caps().ray_pipeline || device->caps().ray_query); }

    void upload_materials(Frame& frame);
    void upload_environment(Frame& frame);
    void upload_geometry(Frame& frame);
    void upload_triangle_tables(Frame& frame);
    void assign_instance_rows();
    void place_instances(Frame& frame);  // instance rows, driver's and our top level
    void place_emitters(Frame& frame);   // the top of the light table
    void write_header(Frame& frame);

    // A buffer of at least one element with these contents, uploaded by the frame.
    template <class T>
    gpu::Buffer make_buffer(Frame& frame, std::string name, const std::vector<T>& rows) {
        gpu::Buffer buffer(device, "scene/" + std::move(name), std::max<uint64_t>(rows.size(), 1) * sizeof(T));
        frame.upload(buffer, 0, std::as_bytes(std::span(rows)));
        return buffer;
    }
};

}  // namespace parhelion
