#pragma once
// The scene on the device: buffers, textures, acceleration structures and light tables, and the passes that keep them current.
// What a scene needs comes in slices: each update() records a bounded amount of work, and what was there before is drawn until
// all of the new is there.
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "frame/frame.h"
#include "gpu/device_class.h"
#include "scene/scene.h"
#include "shared/raster.h"

namespace parhelion {

using gpu::NodeLayout;
// Loop of the traversal of our own structure (lib/traverse.glsl): rays wait for each other before leaves, or look at them in every round.
enum class BvhLoop : uint32_t { Auto, Descend, Rounds };

struct SceneGpuOptions {
    bool culling = true;           // single-sided surfaces are invisible from behind; false shows them
    float infinite_share = 0.5f;   // share of light samples for environment and directional lights where others exist too; in (0, 1), or one of them is lost
    bool hardware = true;          // build the driver's acceleration structures (pipeline, query), where the device has them
    bool own_bvh = true;           // build our own (compute)
    bool raster = false;           // keep the table of what raster passes draw (SceneGpu::drawn)
    NodeLayout node_layout = NodeLayout::Auto;
    BvhLoop bvh_loop = BvhLoop::Auto;
    bool compact = true;           // give back what the driver's bottom levels do not need
    // Proxies: rays meet fewer triangles than raster passes draw (proxies.cpp). Share of a geometry's triangles that is to stay, 1: all; and
    // how far the others may go away at most, in lengths of the mesh.
    float proxy_ratio = 1.0f, proxy_error = 0.001f;
    // What one update() records, about: what cannot be divided (a row of an image, a mesh's bottom level) is done whole.
    uint64_t slice_bytes = 64ull << 20;      // of uploads; also bounds the scratch memory of builds, at four times as much
    uint64_t slice_triangles = 1ull << 18;   // whose bottom levels are built
    uint64_t geometry_buffer_bytes = 256ull << 20;  // geometry shares buffers of this size; a larger array has its own
};

struct SceneGpuStats {
    uint64_t triangles = 0, instanced_triangles = 0, emissive_triangles = 0;
    uint64_t traced_triangles = 0, instanced_traced_triangles = 0;  // fewer where geometries have proxies
    uint32_t meshes = 0, instances = 0, materials = 0, textures = 0, emitters = 0;
    uint32_t instance_rows = 0;  // of the table of instances, free ones too
    double tree_decay = 1;         // of the deformed form measured last: how loosely boxes fit it, over what it was when its mesh's tree was made
    uint32_t rebuilt_trees = 0;    // of deforming meshes, made anew because they had become loose (scene_gpu/decay.cpp)
    uint32_t own_top_refits = 0;   // how often the tree of our top level has got new boxes since it was built (bvh/moving_top.h)
    double own_build_seconds = 0;  // host time of our bottom levels
    double own_top_seconds = 0;    // and of the newest top level
    uint64_t own_bottom_bytes = 0, own_top_bytes = 0;  // of our own: nodes with triangles, nodes with instances
    std::string_view node_layout;                      // of our own, by name
    uint64_t bottom_bytes_built = 0, bottom_bytes = 0;  // the driver's bottom levels as they were built, and as they are now
};

struct SceneProgress {
    bool drawable = false;  // binding() shows a scene, the newest or the one before
    bool complete = false;  // nothing is left to do: binding() shows the scene as it was at the last sync()
    double done = 0, total = 1;  // work, in bytes of uploads and their like
};

// What raster passes draw: one row (shared::DrawnGeometry) a geometry of an instance, kind by kind. Rows in between fill up.
struct DrawnGeometries {
    gpu::Buffer table;
    std::array<uint32_t, shared::kRasterKindCount + 1> begin{};  // first rows of the kinds, and the end; multiples of kRasterGroup
    std::array<uint32_t, shared::kRasterKindCount> count{};      // rows that draw
};

class SceneGpu {
public:
    // Copies nothing yet: call sync() and then update() in a frame.
    SceneGpu(gpu::DevicePtr device, const SceneGpuOptions& options);
    ~SceneGpu();
    SceneGpu(const SceneGpu&) = delete;
    SceneGpu& operator=(const SceneGpu&) = delete;

    // Notes what an edit changed (the result of Scene::apply or begin_frame). The first call takes the whole scene whatever it
    // says. `scene` must outlive the next update(). An interactive program calls this every frame, also when nothing changed: that
    // is how the previous frame's scene becomes the present one.
    void sync(const Scene& scene, const ChangeSet& changes);
    void sync(const Scene& scene);  // another scene, or one whose changes nobody knows: everything is brought in anew

    // Records the next slice of the uploads and builds that sync() made necessary: the first passes of a frame. Nothing to do:
    // records nothing. The pictures do not depend on how the work is cut. Throws Error, naming the limit, for what the device
    // cannot hold.
    SceneProgress update(Frame& frame);
    // Runs frames until the scene is complete, for those who own the loop and need neither progress nor a way to stop.
    void finish(Frame& frame);

    // Set 0 for the passes of this frame. Valid once update() has said `drawable`.
    const SceneBinding& binding() const;
    const DrawnGeometries& drawn() const;  // of the same scene, with SceneGpuOptions::raster; what its table names lies in binding()
    // Grows whenever binding() begins to show another scene: samples of different versions do not belong into one film.
    uint64_t version() const;
    // How often lights that are at least a twentieth of the light table have been switched, dimmed, brought or taken away at once.
    uint64_t light_switches() const;
    const SceneGpuStats& stats() const;
    // What rows of its tables are (AOV `ids`, light ids), in words for people: "instance 3 'Lamp', mesh 7 'Bulb'", "light 0 'Sun'".
    std::string instance_text(uint32_t row) const;
    std::string emitter_text(uint32_t row) const;
    std::string material_text(uint32_t row) const;
    uint32_t features() const;  // shared::kScene...: what the shaders that draw binding() must know

    struct State;

private:
    std::unique_ptr<State> state_;
};

}  // namespace parhelion
