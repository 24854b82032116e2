#pragma once
// A scene that is edited at random before every frame, while it is drawn: instances, lights, materials, textures, forms and the environment come, change
// and go.
#include <vector>

#include "scene/builtin/random.h"
#include "support/render_fixture.h"

namespace parhelion::testing {

class RandomEdits {
public:
    explicit RandomEdits(uint32_t seed);

    Scene make_scene();            // the one that is edited; call it once
    SceneEdit next(const Scene& scene);
    SceneEdit take_all_away(const Scene& scene);  // but the camera
    // After each edit: what it made of what was asked for.
    void applied(const ChangeSet& changes);
    CameraView camera();           // near the last one, now and then far from it

private:
    void edit_instances(SceneEdit& edit, const Scene& scene);
    void edit_lights(SceneEdit& edit, const Scene& scene);
    void edit_materials(SceneEdit& edit, const Scene& scene);
    void edit_environment(SceneEdit& edit);
    void remove(SceneEdit& edit, const Scene& scene, Handle<Instance> instance);
    glm::mat4 place();
    glm::vec3 color(float most);

    builtin::Random random_;
    std::vector<Handle<Node>> nodes_;           // what comes stands on one of them, which may be hidden
    std::vector<Handle<Mesh>> meshes_;          // each of a material of its own
    std::vector<Handle<Material>> materials_;
    std::vector<Handle<Instance>> instances_, new_instances_;
    std::vector<Handle<Light>> lights_, new_lights_;
    Handle<Texture> texture_, new_texture_;     // of the first material
    glm::vec3 eye_{0.0f, 1.0f, 4.0f};
};

// The most bytes that are allocated, on the device and by the process, in a tenth of the frames.
struct MemoryUsed {
    uint64_t device = 0, host = 0;
};
// Draws so many frames of such a scene in realtime, with reservoirs and cache; then takes all light away. The running test fails where a frame is not finite, or
// negative, where one is lit after that, or something of the scene is left over.
std::vector<MemoryUsed> draw_random_edits(const gpu::DevicePtr& device, uint32_t frames, uint32_t seed);

}  // namespace parhelion::testing
