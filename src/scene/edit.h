#pragma once
// SceneEdit: the only way a scene changes, for the glTF loader, built-in scenes, scripts and embedding programs alike.
// An edit is a list of steps that knows no scene; Scene::apply does all of it or, on an Error, nothing.
#include <vector>

#include "scene/types.h"

namespace parhelion {

class SceneEdit {
public:
    SceneEdit();
    SceneEdit(const SceneEdit&);
    SceneEdit(SceneEdit&&) noexcept;
    SceneEdit& operator=(const SceneEdit&);
    SceneEdit& operator=(SceneEdit&&) noexcept;
    ~SceneEdit();

    // The handle is pending: usable in this edit (in values added later, and in its other calls); ChangeSet::resolve makes it last.
    Handle<Image> add(Image value);
    Handle<Texture> add(Texture value);
    Handle<Material> add(Material value);
    Handle<Mesh> add(Mesh value);
    Handle<Node> add(Node value);
    Handle<Skin> add(Skin value);
    Handle<Animation> add(Animation value);
    Handle<Instance> add(Instance value);
    Handle<Light> add(Light value);
    Handle<Camera> add(Camera value);

    // What is still used at the end of the edit (a mesh by instances, a texture by materials, a node by children ...) is an Error.
    template <class T>
    void remove(Handle<T> handle);

    void set_transform(Handle<Node> node, const Transform& local);
    // Relative to the node it hangs on, in the world if it hangs on none.
    void set_transform(Handle<Instance> instance, const glm::mat4& matrix);
    void set_transform(Handle<Light> light, const glm::mat4& matrix);
    void set_transform(Handle<Camera> camera, const glm::mat4& matrix);

    // Whether what stands on the node and below it is there: see Node::visible.
    void set_visible(Handle<Node> node, bool visible);

    // How an instance is deformed now: the mesh to draw (none: its own), and the weights of its morph targets (empty: the mesh's).
    // A mesh that names the instance's own as its Mesh::rest comes onto the device much faster.
    void set_pose(Handle<Instance> instance, Handle<Mesh> posed, std::vector<float> weights);

    // Replace everything but the placement.
    void set_material(Handle<Material> handle, Material value);
    void set_light(Handle<Light> handle, Light value);
    void set_camera(Handle<Camera> handle, Camera value);
    void set_environment(Environment value);
    void set_source(SceneSource value);

    bool empty() const;

private:
    friend class Scene;
    struct Step;  // edit_steps.h
    template <class T>
    Handle<T> push_add(T&& value);

    std::vector<Step> steps_;
    uint32_t serial_;          // marks the pending handles of this edit
    uint32_t added_[10] = {};  // adds so far by type, in the order of the overloads above
};

}  // namespace parhelion
