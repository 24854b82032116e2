// SceneEdit: its steps, as they are asked for.
#include <atomic>

#include "scene/edit_steps.h"

namespace parhelion {

using namespace edit_step;

SceneEdit::SceneEdit() {
    static std::atomic<uint32_t> next = 0;
    serial_ = next++ & ~Handle<Node>::kPendingBit;
}
SceneEdit::SceneEdit(const SceneEdit&) = default;
SceneEdit::SceneEdit(SceneEdit&&) noexcept = default;
SceneEdit& SceneEdit::operator=(const SceneEdit&) = default;
SceneEdit& SceneEdit::operator=(SceneEdit&&) noexcept = default;
SceneEdit::~SceneEdit() = default;

bool SceneEdit::empty() const { return steps_.empty(); }

template <class T>
Handle<T> SceneEdit::push_add(T&& value) {
    steps_.push_back({Add<T>{std::move(value)}});
    return {added_[kKind<T>]++, serial_ | Handle<T>::kPendingBit};
}
Handle<Image> SceneEdit::add(Image value) { return push_add(std::move(value)); }
Handle<Texture> SceneEdit::add(Texture value) { return push_add(std::move(value)); }
Handle<Material> SceneEdit::add(Material value) { return push_add(std::move(value)); }
Handle<Mesh> SceneEdit::add(Mesh value) { return push_add(std::move(value)); }
Handle<Node> SceneEdit::add(Node value) { return push_add(std::move(value)); }
Handle<Skin> SceneEdit::add(Skin value) { return push_add(std::move(value)); }
Handle<Animation> SceneEdit::add(Animation value) { return push_add(std::move(value)); }
Handle<Instance> SceneEdit::add(Instance value) { return push_add(std::move(value)); }
Handle<Light> SceneEdit::add(Light value) { return push_add(std::move(value)); }
Handle<Camera> SceneEdit::add(Camera value) { return push_add(std::move(value)); }

template <class T>
void SceneEdit::remove(Handle<T> handle) {
    steps_.push_back({Remove<T>{handle}});
}
template void SceneEdit::remove(Handle<Image>);
template void SceneEdit::remove(Handle<Texture>);
template void SceneEdit::remove(Handle<Material>);
template void SceneEdit::remove(Handle<Mesh>);
template void SceneEdit::remove(Handle<Node>);
template void SceneEdit::remove(Handle<Skin>);
template void SceneEdit::remove(Handle<Animation>);
template void SceneEdit::remove(Handle<Instance>);
template void SceneEdit::remove(Handle<Light>);
template void SceneEdit::remove(Handle<Camera>);

void SceneEdit::set_transform(Handle<Node> node, const Transform& local) { steps_.push_back({Move<Node>{node, local}}); }
void SceneEdit::set_transform(Handle<Instance> instance, const glm::mat4& matrix) { steps_.push_back({Move<Instance>{instance, {.matrix = matrix}}}); }
void SceneEdit::set_transform(Handle<Light> light, const glm::mat4& matrix) { steps_.push_back({Move<Light>{light, {.matrix = matrix}}}); }
void SceneEdit::set_transform(Handle<Camera> camera, const glm::mat4& matrix) { steps_.push_back({Move<Camera>{camera, {.matrix = matrix}}}); }
void SceneEdit::set_visible(Handle<Node> node, bool visible) { steps_.push_back({Show{node, visible}}); }
void SceneEdit::set_pose(Handle<Instance> instance, Handle<Mesh> posed, std::vector<float> weights) { steps_.push_back({Pose{instance, posed, std::move(weights)}}); }
void SceneEdit::set_material(Handle<Material> handle, Material value) { steps_.push_back({Replace<Material>{handle, std::move(value)}}); }
void SceneEdit::set_light(Handle<Light> handle, Light value) { steps_.push_back({Replace<Light>{handle, std::move(value)}}); }
void SceneEdit::set_camera(Handle<Camera> handle, Camera value) { steps_.push_back({Replace<Camera>{handle, std::move(value)}}); }
void SceneEdit::set_environment(Environment value) { steps_.push_back({std::move(value)}); }
void SceneEdit::set_source(SceneSource value) { steps_.push_back({std::move(value)}); }

}  // namespace parhelion
