#pragma once
// SceneEdit: the only way a scene changes, for the glTF loader, built-in scenes, scripts and embedding programs alike.
// An edit is a list of steps that knows no scene; Scene::apply does all of it or, on an Error, nothing.
#include <variant>
#include <vector>

#include "scene/types.h"

namespace parhelion {

class SceneEdit {
public:
    SceneEdit();

    // The handle is pending: usable in this edit (in values added later, and in its other calls); ChangeSet::resolve makes it last.
    Handle<Image> add(Image value) { return push_add(std::move(value)); }
    Handle<Texture> add(Texture value) { return push_add(std::move(value)); }
    Handle<Material> add(Material value) { return push_add(std::move(value)); }
    Handle<Mesh> add(Mesh value) { return push_add(std::move(value)); }
    Handle<Node> add(Node value) { return push_add(std::move(value)); }
    Handle<Skin> add(Skin value) { return push_add(std::move(value)); }
    Handle<Animation> add(Animation value) { return push_add(std::move(value)); }
    Handle<Instance> add(Instance value) { return push_add(std::move(value)); }
    Handle<Light> add(Light value) { return push_add(std::move(value)); }
    Handle<Camera> add(Camera value) { return push_add(std::move(value)); }

    // What is still used at the end of the edit (a mesh by instances, a texture by materials, a node by children ...) is an Error.
    template <class T>
    void remove(Handle<T> handle) {
        steps_.push_back(Remove<T>{handle});
    }

    void set_transform(Handle<Node> node, const Transform& local) { steps_.push_back(Move<Node>{node, local}); }
    // Relative to the node it hangs on, in the world if it hangs on none.
    void set_transform(Handle<Instance> instance, const glm::mat4& matrix) {
        steps_.push_back(Move<Instance>{instance, {.matrix = matrix}});
    }
    void set_transform(Handle<Light> light, const glm::mat4& matrix) { steps_.push_back(Move<Light>{light, {.matrix = matrix}}); }
    void set_transform(Handle<Camera> camera, const glm::mat4& matrix) { steps_.push_back(Move<Camera>{camera, {.matrix = matrix}}); }

    // How an instance is deformed now: the mesh to draw (none: its own), and the weights of its morph targets (empty: the mesh's).
    // A mesh that names the instance's own as its Mesh::rest comes onto the device much faster.
    void set_pose(Handle<Instance> instance, Handle<Mesh> posed, std::vector<float> weights) {
        steps_.push_back(Pose{instance, posed, std::move(weights)});
    }

    // Replace everything but the placement.
    void set_material(Handle<Material> handle, Material value) { steps_.push_back(Replace<Material>{handle, std::move(value)}); }
    void set_light(Handle<Light> handle, Light value) { steps_.push_back(Replace<Light>{handle, std::move(value)}); }
    void set_camera(Handle<Camera> handle, Camera value) { steps_.push_back(Replace<Camera>{handle, std::move(value)}); }
    void set_environment(Environment value) { steps_.push_back(std::move(value)); }
    void set_source(SceneSource value) { steps_.push_back(std::move(value)); }

    bool empty() const { return steps_.empty(); }

private:
    friend class Scene;
    template <class T>
    struct Add {
        T value;
    };
    template <class T>
    struct Remove {
        Handle<T> handle;
    };
    template <class T>
    struct Move {
        Handle<T> handle;
        Transform local;
    };
    struct Pose {
        Handle<Instance> handle;
        Handle<Mesh> posed;
        std::vector<float> weights;
    };
    template <class T>
    struct Replace {
        Handle<T> handle;
        T value;
    };
    template <class T>
    Handle<T> push_add(T&& value);

    using Step = std::variant<Add<Image>, Add<Texture>, Add<Material>, Add<Mesh>, Add<Node>, Add<Skin>, Add<Animation>, Add<Instance>, Add<Light>, Add<Camera>,
                              Remove<Image>, Remove<Texture>, Remove<Material>, Remove<Mesh>, Remove<Node>, Remove<Skin>, Remove<Animation>, Remove<Instance>, Remove<Light>,
                              Remove<Camera>, Move<Node>, Move<Instance>, Move<Light>, Move<Camera>, Pose, Replace<Material>, Replace<Light>,
                              Replace<Camera>, Environment, SceneSource>;
    std::vector<Step> steps_;
    uint32_t serial_;         // marks the pending handles of this edit
    uint32_t added_[10] = {};  // adds so far by type, in the order of the overloads above
};

}  // namespace parhelion
