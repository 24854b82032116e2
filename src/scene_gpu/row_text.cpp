// What rows of the scene's tables on the device are, in words for people.
#include "base/error.h"
#include "scene_gpu/state.h"

namespace parhelion {

namespace {

std::string named(std::string_view what, uint32_t index, const std::string& name) { return name.empty() ? fmt::format("{} {}", what, index) : fmt::format("{} {} '{}'", what, index, escape_name(name)); }

std::string text_of(const Scene& scene, Handle<Instance> handle) {
    const Instance* instance = scene.instances().find(handle);
    if (!instance) return "an instance that is gone";
    const Node* node = scene.nodes().find(instance->place.node);
    return fmt::format("{}, {}", named("instance", handle.index, node ? node->name : ""), named("mesh", instance->mesh.index, scene.get(instance->mesh).name));
}

}  // namespace

std::string SceneGpu::instance_text(uint32_t row) const {
    const auto& handles = state_->instance_handles;
    return row < handles.size() && handles[row] ? text_of(*state_->scene, handles[row]) : "nothing";
}

std::string SceneGpu::emitter_text(uint32_t row) const {
    const auto& keys = state_->emitter_keys;
    if (row >= keys.size()) return "nothing";
    const EmitterKey& key = keys[row];
    if (key.kind == kOfInstance) return fmt::format("{}, primitive {}", instance_text(key.index), key.part);
    if (key.kind == kOfEnvironment) return "the environment";
    const Light* light = state_->scene->lights().find({key.index, key.generation});
    return light ? named("light", key.index, light->name) : "a light that is gone";
}

std::string SceneGpu::material_text(uint32_t row) const {
    const auto& materials = state_->scene->materials();
    const auto handle = row < materials.slot_count() ? materials.handle_at(row) : std::nullopt;
    return handle ? named("material", row, materials.get(*handle).name) : "none";
}

}  // namespace parhelion
