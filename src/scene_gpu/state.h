#pragma once
// What SceneGpu consists of; one file per part. A scene becomes visible in three steps:
//   1. residency: what lasts (images, geometry, bottom levels) comes in, slice by slice. It is found by the scene's handles, whose
//      contents never change, so that an edit brings in only what is new, and work that has begun is never lost.
//   2. tables: once all is there, rows that refer to it are made from the scene as it is now, and uploaded, again in slices. Edits
//      of the meantime wait.
//   3. publish: the top level, the header and set 0. From then on binding() shows it.
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <tuple>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "bvh/moving_top.h"
#include "bvh/refit.h"
#include "scene_gpu/proxies.h"
#include "scene_gpu/ranges.h"
#include "scene_gpu/scene_gpu.h"
#include "scene_gpu/slice.h"
#include "shared/scene.h"

namespace parhelion {

// An image in one of the ways to read it.
struct ImageOnDevice {
    gpu::Image image;
    uint32_t stored_levels = 1;           // the others are made on the device
    std::vector<uint8_t> unpacked;        // its texels, where the device does not read its blocks; until it is ready
    uint64_t bytes = 0, done_bytes = 0;   // of the stored levels
    uint32_t level = 0, row = 0;          // where its upload goes on
    bool ready = false, wanted = false;
};

// One geometry (primitive) of a mesh.
struct PartOnDevice {
    BufferRange positions, indices, attributes;  // indices of a form that the device makes: those of its mesh at rest
    BufferRange proxy_heights;                   // Geometry's
    uint32_t vertex_count = 0, triangle_count = 0;
    uint32_t proxy_count = 0;  // triangles of its proxy, which follow in `indices`; 0: it has none
};

// What deforms a geometry: the joints of its vertices, and by morph target what that adds to positions, normals and tangents.
struct DeformersOnDevice {
    BufferRange influences;
    std::vector<std::array<BufferRange, 3>> targets;
};

// What the deformed forms of a mesh have in common: its rows in the shared arrays of plans. `host` is the plan on its way there.
struct RefitPlanOnDevice {
    std::unique_ptr<bvh::RefitPlan> host;
    uint64_t nodes = 0, node_count = 0, triangles = 0, triangle_count = 0, done_rows = 0;
    bool ready = false;
};

struct MeshOnDevice {
    Handle<Mesh> rest;       // the mesh that it is a deformed form of
    bool has_forms = false;  // wanted meshes are deformed forms of it
    bool drawn = false;      // by an instance; else it is wanted for its forms
    RefitPlanOnDevice plan;
    // How loosely boxes fit around it (decay.cpp): of a mesh with forms that of the shape which their trees were made for, 0: not known yet.
    double looseness = 0;
    bool base_asked = false, tree_of_form = false;  // it is being measured; that shape is a form's
    bool rebuild_own = false, rebuild_driver = false;
    uint32_t forms_made = 0, forms_at_rebuild = 0;
    bool looked_at = false;  // a form: it has been measured or passed over
    std::vector<PartOnDevice> parts;
    std::vector<Proxy> proxies;      // by part, once they are made
    std::vector<bool> traces_proxy;  // by part: what its bottom levels are built over
    bool made_here = false;  // a form that the device makes (Mesh::deformation)
    bool has_made = false;   // some of its forms are
    std::vector<DeformersOnDevice> deformers;  // by part, where it has such forms
    uint64_t deformer_rows_done = 0;
    bool deformers_ready = false;
    uint32_t geometry_base = 0;  // its rows in the geometry table; they stay
    uint64_t triangle_count = 0, bytes = 0;
    uint64_t done_rows = 0;
    bool uploaded = false, wanted = false;
    uint64_t drawn_at = 0;  // number of the last published scene that draws it; 0: none does

    // The driver's bottom level, and what it was built for.
    gpu::AccelStruct blas;
    gpu::AccelStruct refit_base;  // of a mesh with forms: what they are refitted from where that is a form's
    std::vector<bool> opaque;  // by part: to the driver
    bool cull_by_flag = false;  // every geometry single-sided: the driver culls
    uint64_t built_bytes = 0;   // before compaction

    // Ours: its rows in the shared arrays. `own_host` is the tree on its way there.
    std::unique_ptr<bvh::Bottoms> own_host;
    bvh::RootBoxes own_root;
    std::optional<uint32_t> own_flags;  // BvhTopItem's, as its materials have it
    uint64_t own_nodes = 0, own_node_count = 0, own_triangles = 0, own_triangle_count = 0, own_done_rows = 0;
    bool own_ready = false;

    bool has_proxy(size_t part) const { return part < traces_proxy.size() && traces_proxy[part]; }
    uint64_t traced_triangles() const;
};

// Rows of a tree of ours that its mesh has no more, until the last published scene that shows it is gone.
struct RetiredRows {
    uint64_t nodes, node_count, triangles, triangle_count, drawn_at;
};

// Bottom levels whose compacted sizes the device is about to tell.
struct Measurement {
    gpu::AccelSizes sizes;
    std::vector<Handle<Mesh>> meshes;
    std::vector<gpu::AccelStruct> built;  // a mesh may have another by then
};

// Areas that the device is about to tell (decay.cpp).
struct DecayReading {
    struct Form {
        Handle<Mesh> rest;
        size_t first, count;  // clusters
        bool is_base;
    };
    gpu::Buffer areas;
    std::vector<Form> forms;
};

// Which light of an emissive geometry comes from which triangle, in object space. Exists just if some triangle can shine.
struct EmissiveTable {
    std::vector<shared::AliasEntry> rows;  // by triangle: area x what it shows of the emissive texture
    std::vector<float> shown;              // by triangle: mean of the texture's tinted luminance; empty: 1 everywhere
    double flux = 0;                       // sum of area x shown
};

// A geometry whose material emits, and what its table follows.
struct EmissivePart {
    Handle<Mesh> mesh, rest;  // `rest`: what the mesh is a form of, itself if of none
    uint32_t primitive = 0;
    Handle<Texture> texture;  // none: uniform
    shared::TextureRef ref{};
    glm::vec3 tint{1.0f};     // textured: the emission's colour, largest channel 1
    std::shared_ptr<const EmissiveTable> table;  // none: it is black
    bool same_look(const EmissivePart& other) const;  // but for the sizes of triangles
};

// The layout that is fastest on devices of this class, by measurement, or the one asked for.
bvh::Layout choose_node_layout(const gpu::DeviceCaps& caps, NodeLayout choice);
// Constant 0 of the programs that trace our own nodes (shared/bvh.h). `plain`: both top levels are.
uint32_t traversal_variant(const gpu::DeviceCaps& caps, bvh::Layout layout, BvhLoop choice, bool plain);

// What our builder reads of a mesh; with proxies, what rays meet of it.
std::vector<bvh::BottomGeometry> bottom_geometries(const Mesh& mesh);
std::vector<bvh::BottomGeometry> bottom_geometries(const Mesh& mesh, const MeshOnDevice& on_device);

// Alias rows of non-negative weights. All-zero weights become equal ones: a table must return something.
std::vector<shared::AliasEntry> make_alias_rows(std::span<const double> weights);

// Which geometries of a mesh are opaque to a traversal, so that it need not ask about a hit, and what it culls on its own. That is a
// flag of the whole instance: a mesh that mixes single- and double-sided geometries is not culled by it; asking does it there, so its
// single-sided geometries are not opaque.
struct OpacityFlags {
    std::vector<bool> opaque;  // by part
    bool cull_by_flag = false;
};
OpacityFlags opacity_flags(const Scene& scene, const Mesh& mesh, bool culling);

// Where a drawn instance has its row. Handles of generation 0 name nothing.
struct InstanceRow {
    uint32_t generation = 0, row = 0;
};

// Which light a row of the emitter table is, in any frame.
enum : uint32_t { kOfInstance, kOfLight, kOfEnvironment };  // EmitterKey::kind
struct EmitterKey {
    uint32_t kind;
    uint32_t index, part; // row of the instance and geometry of its mesh; slot of the light
    uint32_t generation;
    auto operator<=>(const EmitterKey&) const = default;
};
// Where each of the rows `before` is among `now`, shared::kNone where it is not. Empty: those that were are where they were.
std::vector<uint32_t> translate_rows(std::span<const EmitterKey> before, std::span<const EmitterKey> now);
// How bright an emitter is, in a unit of its kind's own, and a hash of where.
struct EmitterLook {
    double radiance = 0;
    uint64_t place = 0;
};
// The radiance before over now's, of each row of now: 0 of those that are new or were elsewhere; rows_now as translate_rows() gives it. Empty: all are as they were.
std::vector<float> lit_before(std::span<const EmitterLook> before, std::span<const EmitterLook> now, std::span<const uint32_t> rows_now);

// Each frame's emitters and about what share of its light they are.
struct EmitterShares {
    std::span<const EmitterLook> looks;
    std::span<const double> shares;
};
// The share of the light that has come or gone at once: of emitters that are new, are gone, or shine otherwise from where they were. Those that move and shine before and after do not count.
double switched_share(EmitterShares before, EmitterShares now, std::span<const uint32_t> rows_now);

struct TopLevel {
    gpu::AccelStruct tlas;
    gpu::Buffer nodes, items;            // ours
    bool plain = false;                  // every geometry in it is opaque (kBvhPlain)
    std::vector<gpu::AccelStruct> kept;  // the bottom levels that it points at
};

struct SceneGpu::State {
    gpu::DevicePtr device;
    SceneGpuOptions options;
    const Scene* scene = nullptr;
    bvh::Layout layout;  // of our own nodes
    State(gpu::DevicePtr the_device, const SceneGpuOptions& the_options);

    // What sync() said since the tables were last made.
    bool anything_stale = true, materials_stale = true, textures_stale = true, environment_stale = true;
    bool edited = true;      // by the scene's owner, not by time alone
    bool tables_edited = false, tables_advance = false;  // what the running tables follow: an edit; an edit or time
    bool unsettled = false;  // the last publish followed an edit: the previous top level is another than the present one
    bool moved_by_compaction = false;  // bottom levels that are drawn have gone elsewhere
    bool environment_table_stale = true;  // its image is taken care of, its row and its light table are not
    bool has_no_past = true;  // the scene has never been published: its previous frame is the present one
    bool tables_running = false;       // step 2 has begun and waits for slices
    uint64_t published = 0, version = 0, light_switches = 0;
    SceneProgress progress;

    // geometry.cpp
    std::unordered_map<Handle<Mesh>, MeshOnDevice> meshes;
    std::vector<Handle<Mesh>> wanted_meshes;    // that instances draw, in the scene's order
    std::vector<Handle<Mesh>> resident_meshes;  // the same and those that they are forms of, these first
    BufferPool geometry_pool;
    BufferPool form_pool;      // positions and attributes of forms that the device makes
    BufferPool deformer_pool;  // what it makes them of
    FreeRanges geometry_rows{1ull << 32};
    std::vector<shared::Geometry> geometries;
    gpu::Buffer geometry_table;
    // bottoms.cpp
    RowArray bottom_nodes, bottom_triangles;
    std::vector<RetiredRows> retired_rows;
    // refit.cpp
    RowArray plan_nodes, plan_triangles;
    std::vector<Measurement> measurements;
    std::vector<DecayReading> decay_readings;
    // materials.cpp
    std::unordered_map<uint64_t, ImageOnDevice> images;  // by image_key()
    std::unordered_set<Handle<Texture>> drawn_textures;  // textures that shaders read; the others stay on the host
    std::vector<shared::Material> materials;        // by index of the handle
    uint32_t features = 0, features_shown = 0;       // shared::kScene...: of the materials; of what was last published
    std::vector<shared::TextureEntry> texture_rows;  // by index of the handle
    gpu::Buffer material_table, texture_table;
    std::vector<std::pair<gpu::Image, gpu::Sampler>> slots;  // of set 0; the environment's is the last
    // lights.cpp
    std::vector<shared::Emitter> emitters;
    gpu::Buffer emitter_table, emitter_alias, triangle_alias, geometry_emitters, environment_alias, suns;
    std::vector<uint32_t> sun_rows;
    std::vector<EmitterKey> emitter_keys;  // by row
    gpu::Buffer emitter_translation;       // from the previous frame's rows; none: nothing has changed its row
    uint32_t emitters_before = 0;          // rows of the previous frame
    std::vector<EmitterLook> emitter_looks;  // by row
    std::vector<double> emitter_shares;      // by row: of all light, about
    bool light_switched = false;             // by the edit that is published next
    gpu::Buffer emitter_lit_before;        // SceneHeader's; none: all shine as they did
    std::vector<EmissivePart> emissive_parts;  // whose tables triangle_alias holds, one after the other
    std::unordered_map<uint32_t, uint32_t> triangle_table_of_geometry;  // geometry row -> offset in triangle_alias
    std::unordered_map<uint32_t, std::shared_ptr<const EmissiveTable>> emissive_table_of_geometry;
    shared::Environment environment{};
    double environment_luminance = 0;  // mean of the map over the sphere, without its scale
    ImageOnDevice environment_image;
    // instances.cpp
    std::vector<shared::Instance> instances;
    std::vector<uint32_t> geometry_emitter_rows;
    std::vector<Handle<Instance>> instance_handles;  // by row; none: the row is free
    std::vector<InstanceRow> instance_rows;  // by index of the handle
    std::vector<Handle<Mesh>> row_meshes;  // that the rows draw
    std::vector<uint32_t> free_rows, left_rows;  // free now; left by this frame's edit, still seen by the previous top level
    gpu::Buffer instance_table, instance_translation, tlas_instances;
    uint32_t instances_before = 0;  // rows of the previous frame
    uint32_t tlas_count = 0;
    bvh::MovingTop own_top;  // stays as it is until its tables are up
    TopLevel next, now, before;
    // drawn.cpp
    DrawnGeometries drawn_next, drawn_now;
    // tables.cpp
    std::vector<RowSource> tables;
    uint64_t table_rows_done = 0;
    gpu::Buffer sampler_tables, bsdf_tables;
    std::vector<gpu::SceneSet> sets;  // the one of `binding`, those of frames on their way, and free ones
    SceneBinding binding;
    shared::SceneHeader shown_header{};  // what binding shows
    uint32_t shown_instances = 0;     // its rows
    std::vector<std::pair<gpu::Image, gpu::Sampler>> shown_slots;
    std::vector<gpu::Buffer> shown_buffers;
    bool frame_began = false;         // since the last publish
    SceneGpuStats stats;

    // Those that are not drawn serve their forms: the driver's bottom levels, and what the device makes of them.
    bool needs_geometry(const MeshOnDevice& mesh) const { return mesh.drawn || mesh.has_made || uses_hardware(); }
    std::vector<gpu::Buffer> geometry_buffers() const;
    bool uses_hardware() const { return options.hardware && (device->caps().ray_pipeline || device->caps().ray_query); }

    void begin_anew();

    // One slice of the three steps. False: nothing new is to be seen.
    bool advance(Frame& frame, Slice& slice);

    // Step 1. plan() says what the scene needs; the others bring in what is missing, as far as the slice goes.
    void plan();
    void plan_images();
    void plan_meshes();
    void upload_images(Frame& frame, Slice& slice);
    bool uses_proxies() const { return options.proxy_ratio < 1.0f; }
    void make_proxies(Slice& slice);
    PartOnDevice take_part(const Primitive& p, const Proxy& proxy);
    void upload_meshes(Frame& frame, Slice& slice);
    void choose_proxies();
    void retire_own(MeshOnDevice& mesh);
    void upload_deformers(Frame& frame, Slice& slice);
    void deform_meshes(Frame& frame, Slice& slice);
    void build_own_bottoms(Frame& frame, Slice& slice);
    struct OwnTree {
        Handle<Mesh> mesh;
        uint64_t triangles;
        std::unique_ptr<bvh::Bottoms> host;
    };
    std::vector<OwnTree> build_own_trees(Slice& slice);
    void take_own_rows(Frame& frame, MeshOnDevice& mesh, uint64_t nodes, uint64_t triangles);
    void measure_decay(Frame& frame);
    void read_decay();
    void replan_refits(Slice& slice);
    void note_rebuilt(MeshOnDevice& rest);
    void rebase_refits(MeshOnDevice& rest, const MeshOnDevice& form);
    void plan_refits(Frame& frame, Slice& slice);
    void refit_own_bottoms(Frame& frame, Slice& slice);
    void build_driver_bottoms(Frame& frame, Slice& slice);
    void compact_bottoms(Frame& frame);
    bool is_resident() const;
    void measure_progress();

    // Step 2.
    void make_tables();
    void make_sampler_tables();
    void make_materials();
    void make_textures();
    void make_geometries();
    void make_environment();
    void make_triangle_tables();
    std::vector<EmissivePart> find_emissive_parts() const;
    void place_instances();  // instance rows, driver's and our top level
    std::vector<uint32_t> assign_instance_rows();
    uint32_t base_before(uint32_t row, const MeshOnDevice& mesh, Handle<Mesh> handle) const;
    void translate_instances(std::span<const Handle<Instance>> new_ones);
    std::vector<MeshOnDevice*> note_drawn(std::span<const uint32_t> drawn);
    void place_driver_top(std::span<const uint32_t> drawn, std::span<MeshOnDevice* const> drawn_mesh);
    void place_own_top(std::span<const uint32_t> drawn, std::span<MeshOnDevice* const> drawn_mesh);
    void place_drawn(std::span<const uint32_t> drawn, std::span<MeshOnDevice* const> drawn_mesh);
    std::vector<uint32_t> shining_instances() const;
    std::vector<Handle<Light>> shown_lights() const;
    void place_emitters();   // the top of the light table

    // Step 3.
    void publish(Frame& frame);
    void write_header(Frame& frame);
    void bind_shown(Frame& frame);
    void become_past();
    void settle(Frame& frame);
    gpu::SceneSet free_set(uint32_t textures);
    void forget_unwanted();
    void forget_retired();
    void give_back(const MeshOnDevice& mesh);
    void forget_meshes(const std::function<bool(const MeshOnDevice&)>& choose);

    RowSource own_node_rows(const MeshOnDevice& mesh) const;
    RowSource own_triangle_rows(const MeshOnDevice& mesh) const;

    // A buffer of at least one element whose contents are uploaded with the tables. The rows must not change before that is done.
    template <class T>
    gpu::Buffer make_table(std::string name, std::span<const T> rows) {
        gpu::Buffer buffer(device, "scene/" + std::move(name), std::max<uint64_t>(rows.size(), 1) * sizeof(T));
        tables.push_back({buffer, 0, sizeof(T), rows.size(), [rows](std::byte* to, uint64_t first, uint64_t count) { std::memcpy(to, rows.data() + first, count * sizeof(T)); }});
        return buffer;
    }
    // The same with rows that nobody else needs.
    template <class T>
    gpu::Buffer make_table(std::string name, std::vector<T>&& rows) {
        const auto kept = std::make_shared<const std::vector<T>>(std::move(rows));
        const gpu::Buffer buffer = make_table(std::move(name), std::span<const T>(*kept));
        tables.back().write = [kept](std::byte* to, uint64_t first, uint64_t count) { std::memcpy(to, kept->data() + first, count * sizeof(T)); };
        return buffer;
    }
};

}  // namespace parhelion
