#pragma once
// Scene: everything that is drawn, readable by all, changed only through SceneEdit.
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "scene/edit.h"
#include "scene/types.h"

namespace parhelion {

// What one or several edits changed, each list without doubles and in order of first change. Consumers (the scene on the device,
// light tables) read it instead of comparing scenes.
struct ChangeSet {
    template <class T>
    struct Changed {
        std::vector<Handle<T>> added, removed, changed;
        bool empty() const { return added.empty() && removed.empty() && changed.empty(); }
    };
    Changed<Image> images;
    Changed<Texture> textures;
    Changed<Material> materials;
    Changed<Mesh> meshes;
    Changed<Node> nodes;
    Changed<Skin> skins;
    Changed<Animation> animations;
    Changed<Instance> instances;  // changed: moved or posed now, or moved last frame (world_from_object_before changed)
    Changed<Light> lights;        // changed: moved or set
    Changed<Camera> cameras;
    bool environment = false;

    template <class T>
    Changed<T>& of();
    template <class T>
    const Changed<T>& of() const {
        return const_cast<ChangeSet*>(this)->of<T>();
    }
    bool empty() const;
    // The lasting handle for one that the applied edit's add() returned; handles that last already come back unchanged.
    template <class T>
    Handle<T> resolve(Handle<T> handle) const;
    // Joins what a later edit changed, so that a consumer may catch up with several at once.
    void append(const ChangeSet& later);

private:
    friend class Scene;
    uint32_t serial_ = 0;
    std::tuple<std::vector<Handle<Image>>, std::vector<Handle<Texture>>, std::vector<Handle<Material>>, std::vector<Handle<Mesh>>,
               std::vector<Handle<Node>>, std::vector<Handle<Skin>>, std::vector<Handle<Animation>>, std::vector<Handle<Instance>>, std::vector<Handle<Light>>, std::vector<Handle<Camera>>>
        resolved_;  // by the index of the pending handle
};

class Scene {
public:
    const SlotMap<Image>& images() const { return all<Image>(); }
    const SlotMap<Texture>& textures() const { return all<Texture>(); }
    const SlotMap<Material>& materials() const { return all<Material>(); }
    const SlotMap<Mesh>& meshes() const { return all<Mesh>(); }
    const SlotMap<Node>& nodes() const { return all<Node>(); }
    const SlotMap<Skin>& skins() const { return all<Skin>(); }
    const SlotMap<Animation>& animations() const { return all<Animation>(); }
    const SlotMap<Instance>& instances() const { return all<Instance>(); }
    const SlotMap<Light>& lights() const { return all<Light>(); }
    const SlotMap<Camera>& cameras() const { return all<Camera>(); }
    template <class T>
    const SlotMap<T>& all() const {
        return std::get<SlotMap<T>>(tables_);
    }
    // Throws Error for a stale handle.
    template <class T>
    const T& get(Handle<T> handle) const {
        return all<T>().get(handle);
    }
    const Environment& environment() const { return environment_; }
    const SceneSource& source() const { return source_; }

    // World bounds of all drawable instances (of their meshes' boxes: exact for axis-aligned placements, never too small). Forms that the
    // device makes are made for it on the host.
    Bounds bounds() const;

    // Does the whole edit, or throws Error (stale or foreign handle, something still in use, a value out of range) and changes nothing.
    ChangeSet apply(SceneEdit edit);

    // A new frame starts: current transforms become the previous ones. Returns the instances whose previous transform changed by that.
    ChangeSet begin_frame();

private:
    struct Checker;
    struct Applier;
    using Tables = std::tuple<SlotMap<Image>, SlotMap<Texture>, SlotMap<Material>, SlotMap<Mesh>, SlotMap<Node>, SlotMap<Skin>, SlotMap<Animation>, SlotMap<Instance>,
                              SlotMap<Light>, SlotMap<Camera>>;
    Tables tables_;
    Environment environment_;
    SceneSource source_;
    std::vector<Handle<Instance>> moved_instances_;  // since begin_frame: their previous transform differs
    std::vector<Handle<Light>> moved_lights_;
    std::vector<Handle<Camera>> moved_cameras_;
};

}  // namespace parhelion
