#pragma once
// The scene on the device: buffers, textures, acceleration structures and light tables, and the passes that keep them current.
#include <memory>
#include <string>
#include <vector>

#include "frame/frame.h"
#include "scene/scene.h"

namespace parhelion {

struct SceneGpuOptions {
    bool culling = true;           // single-sided surfaces are invisible from behind; false shows them
    float infinite_share = 0.5f;   // share of light samples for environment and directional lights where others exist too
    bool hardware = true;          // build the driver's acceleration structures (pipeline, query), where the device has them
    bool own_bvh = true;           // build our own (compute)
};

struct SceneGpuStats {
    uint64_t triangles = 0, instanced_triangles = 0, emissive_triangles = 0;
    uint32_t meshes = 0, instances = 0, materials = 0, textures = 0, emitters = 0;
    double own_build_seconds = 0;  // host time of our bottom levels
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
    // is how the previous frame's scene becomes the present one. A change of meshes or materials has no previous frame.
    void sync(const Scene& scene, const ChangeSet& changes);
    void sync(const Scene& scene);  // everything changed

    // Records the uploads and builds that sync() made necessary: the first passes of a frame. Nothing to do: records nothing.
    void update(Frame& frame);

    // Set 0 for the passes of this frame. Valid after update().
    const SceneBinding& binding() const;
    const SceneGpuStats& stats() const;

    struct State;

private:
    std::unique_ptr<State> state_;
};

}  // namespace parhelion
