// Scene::apply: an edit is checked whole before anything is touched, then carried out step by step; world transforms are
// brought up to date once at the end, however many nodes moved.
#include <algorithm>
#include <unordered_map>
#include <unordered_set>

#include "scene/deform.h"
#include "scene/edit_steps.h"
#include "scene/scene_refs.h"

namespace parhelion {

namespace {

template <class F, class... Ts>
void for_each_type(TypeList<Ts...>, F&& f) {
    (f.template operator()<Ts>(), ...);
}

template <class T>
using HandleSet = std::unordered_set<Handle<T>>;
template <class T>
struct HandleSetOf {
    HandleSet<T> set;
};

// Added and removed within the span of the set cancel; changes of those are no news.
template <class T>
void normalize(ChangeSet::Changed<T>& lists) {
    if (lists.removed.empty() && lists.changed.empty()) return;
    const HandleSet<T> added(lists.added.begin(), lists.added.end()), removed(lists.removed.begin(), lists.removed.end());
    std::erase_if(lists.added, [&](Handle<T> h) { return removed.contains(h); });
    std::erase_if(lists.removed, [&](Handle<T> h) { return added.contains(h); });
    HandleSet<T> seen;
    std::erase_if(lists.changed, [&](Handle<T> h) { return added.contains(h) || removed.contains(h) || !seen.insert(h).second; });
}

}  // namespace

// ---- change sets ----

bool ChangeSet::empty() const {
    bool none = !environment;
    for_each_type(SceneTypes{}, [&]<class T>() { none = none && of<T>().empty(); });
    return none;
}

template <class T>
Handle<T> ChangeSet::resolve(Handle<T> handle) const {
    if (!handle.pending()) return handle;
    const auto& resolved = std::get<std::vector<Handle<T>>>(resolved_);
    if ((handle.generation & ~Handle<T>::kPendingBit) != serial_ || handle.index >= resolved.size())
        throw Error(ErrorCode::Failed, "a pending handle of another edit", std::string(T::kTypeName),
                    "resolve it with the change set of its own edit");
    return resolved[handle.index];
}
template Handle<Image> ChangeSet::resolve(Handle<Image>) const;
template Handle<Texture> ChangeSet::resolve(Handle<Texture>) const;
template Handle<Material> ChangeSet::resolve(Handle<Material>) const;
template Handle<Mesh> ChangeSet::resolve(Handle<Mesh>) const;
template Handle<Node> ChangeSet::resolve(Handle<Node>) const;
template Handle<Skin> ChangeSet::resolve(Handle<Skin>) const;
template Handle<Animation> ChangeSet::resolve(Handle<Animation>) const;
template Handle<Instance> ChangeSet::resolve(Handle<Instance>) const;
template Handle<Light> ChangeSet::resolve(Handle<Light>) const;
template Handle<Camera> ChangeSet::resolve(Handle<Camera>) const;

void ChangeSet::append(const ChangeSet& later) {
    environment = environment || later.environment;
    for_each_type(SceneTypes{}, [&]<class T>() {
        Changed<T>& mine = of<T>();
        const Changed<T>& theirs = later.of<T>();
        mine.added.insert(mine.added.end(), theirs.added.begin(), theirs.added.end());
        mine.removed.insert(mine.removed.end(), theirs.removed.begin(), theirs.removed.end());
        mine.changed.insert(mine.changed.end(), theirs.changed.begin(), theirs.changed.end());
        normalize(mine);
    });
}

// ---- checking ----

// Walks the steps as apply will, keeping only what is alive; then looks for users of what was removed.
struct Scene::Checker {
    const Scene& scene;
    const SceneEdit& edit;
    uint32_t added[kKindCount] = {};
    std::tuple<HandleSetOf<Image>, HandleSetOf<Texture>, HandleSetOf<Material>, HandleSetOf<Mesh>, HandleSetOf<Node>, HandleSetOf<Skin>, HandleSetOf<Animation>, HandleSetOf<Instance>,
               HandleSetOf<Light>, HandleSetOf<Camera>>
        removed = {};
    bool removes = false;
    std::unordered_map<Handle<Material>, const Material*> replaced = {};  // the last value of each
    std::unordered_map<Handle<Instance>, Handle<Mesh>> posed = {};        // likewise
    std::vector<const Mesh*> added_meshes = {};                           // by index of the pending handle

    template <class T>
    bool alive(Handle<T> handle) const {
        if (std::get<HandleSetOf<T>>(removed).set.contains(handle)) return false;
        if (!handle.pending()) return scene.all<T>().contains(handle);
        return (handle.generation & ~Handle<T>::kPendingBit) == edit.serial_ && handle.index < added[kKind<T>];
    }
    template <class T>
    void require(Handle<T> handle, std::string_view user) const {
        if (alive(handle)) return;
        throw Error(ErrorCode::Failed,
                    handle ? fmt::format("there is no such {} (slot {}, generation {})", T::kTypeName, handle.index, handle.generation)
                           : fmt::format("names no {}", T::kTypeName),
                    fmt::format("scene edit: {}", user), "it was removed, is added later, or belongs to another edit");
    }
    template <class T>
    void check_refs(const T& value) const {
        detail::visit_const_refs(value, [&](auto handle, bool required) {
            if (handle || required) require(handle, T::kTypeName);
        });
    }

    template <class T>
    void operator()(const edit_step::Add<T>& step) {
        detail::check_value(step.value);
        check_refs(step.value);
        ++added[kKind<T>];
    }
    // What Scene keeps of a mesh is filled in here: a deformation is checked by how far it reaches.
    void operator()(edit_step::Add<Mesh>& step) {
        Mesh& mesh = step.value;
        detail::check_value(mesh);
        check_refs(mesh);
        const Mesh* rest = !mesh.rest ? nullptr : mesh.rest.pending() ? added_meshes[mesh.rest.index] : &scene.get(mesh.rest);
        if (rest) check_form(mesh, *rest);
        mesh.bounds = {};
        mesh.triangle_count = 0;
        for (size_t i = 0; i < mesh.primitives.size(); ++i) {
            Primitive& primitive = mesh.primitives[i];
            if (mesh.deformation) primitive.bounds = deformed_bounds(rest->primitives[i], *mesh.deformation);
            else detail::keep_bounds(primitive);
            mesh.bounds.add(primitive.bounds);
            mesh.triangle_count += mesh.deformation ? rest->primitives[i].triangles.size() : primitive.triangles.size();
        }
        if (mesh.deformation) check_reach(mesh);
        added_meshes.push_back(&mesh);
        ++added[kKind<Mesh>];
    }
    static void check_reach(const Mesh& form) {
        const glm::vec3 far = glm::max(glm::abs(form.bounds.min), glm::abs(form.bounds.max));
        if (form.bounds.empty() || std::max({far.x, far.y, far.z}) <= kLargestCoordinate) return;
        throw Error(ErrorCode::Failed, fmt::format("is deformed beyond {:g} metres", kLargestCoordinate), fmt::format("mesh '{}'", escape_name(form.name)), "look at its skin and its morph weights");
    }
    // The joints and targets that a deformation names exist.
    static void check_deformation(const Mesh& form, const Mesh& rest) {
        const auto fail = [&](std::string what) { throw Error(ErrorCode::Failed, std::move(what), fmt::format("mesh '{}'", escape_name(form.name))); };
        const MeshDeformation& d = *form.deformation;
        for (const Primitive& primitive : rest.primitives) {
            if (d.weights.size() > primitive.targets.size()) fail(fmt::format("has {} morph weights, but '{}' has {} targets", d.weights.size(), escape_name(rest.name), primitive.targets.size()));
            if (!d.object_from_rest.empty() && primitive.joint_bounds.size() > d.object_from_rest.size())
                fail(fmt::format("names joint {}, but its skin has {}", primitive.joint_bounds.size() - 1, d.object_from_rest.size()));
        }
        if (any_mirrors(d)) fail("has a joint that mirrors: make the form's arrays with deformed() instead");
    }
    // What a refit leans on.
    static void check_form(const Mesh& form, const Mesh& rest) {
        const bool same = std::ranges::equal(form.primitives, rest.primitives, [&](const Primitive& a, const Primitive& b) {
            return form.deformation || (a.positions.size() == b.positions.size() && a.triangles.size() == b.triangles.size());
        });
        if (form.deformation && same && !rest.rest) check_deformation(form, rest);
        if (same && !rest.rest) return;
        throw Error(ErrorCode::Failed, fmt::format("is no deformed form of '{}', which {}", escape_name(rest.name), same ? "is a form itself" : "has other numbers of primitives, vertices or triangles"),
                    fmt::format("mesh '{}'", escape_name(form.name)), "name the mesh at rest in Mesh::rest, or none");
    }
    template <class T>
    void operator()(const edit_step::Remove<T>& step) {
        require(step.handle, "remove");
        std::get<HandleSetOf<T>>(removed).set.insert(step.handle);
        removes = true;
    }
    template <class T>
    void operator()(const edit_step::Move<T>& step) const {
        require(step.handle, "set_transform");
        detail::check_value(step.local);
    }
    void operator()(const edit_step::Show& step) const { require(step.handle, "set_visible"); }
    void operator()(const edit_step::Pose& step) {
        require(step.handle, "set_pose");
        if (step.posed) require(step.posed, "set_pose");
        posed[step.handle] = step.posed;
    }
    template <class T>
    void operator()(const edit_step::Replace<T>& step) {
        require(step.handle, "set");
        detail::check_value(step.value);
        if constexpr (std::is_same_v<T, Material>) {
            check_refs(step.value);
            replaced[step.handle] = &step.value;
        }
    }
    void operator()(const Environment& environment) const { detail::check_value(environment); }
    void operator()(const SceneSource&) const {}

    // This edit says what takes its place.
    bool is_posed_anew(Handle<Instance> user, const Instance& value, const Handle<Mesh>& used) const { return &used == &value.posed && posed.contains(user); }
    template <class T, class U>
    bool is_posed_anew(Handle<T>, const T&, const Handle<U>&) const {
        return false;
    }
    template <class T>
    void check_uses(Handle<T> user, const T& value) const {
        if (!alive(user)) return;
        detail::visit_const_refs(value, [&]<class U>(const Handle<U>& used, bool) {
            if (is_posed_anew(user, value, used)) return;
            if (used && std::get<HandleSetOf<U>>(removed).set.contains(used))
                throw Error(ErrorCode::Failed, fmt::format("cannot remove a {} that is still in use ({})", U::kTypeName, T::kTypeName),
                            "scene edit: remove", "remove or change its users in the same edit");
        });
    }
    template <class T>
    const T& final_value(Handle<T> handle, const T& value) const {
        if constexpr (std::is_same_v<T, Material>) {
            const auto found = replaced.find(handle);
            if (found != replaced.end()) return *found->second;
        }
        return value;
    }
    void check_removed_unused() const {
        for_each_type(SceneTypes{}, [&]<class T>() {
            for (const auto& [handle, value] : scene.all<T>()) check_uses(handle, final_value(handle, value));
        });
        uint32_t serials[kKindCount] = {};
        for (const SceneEdit::Step& step : edit.steps_)
            std::visit([&](const auto& s) { check_added(s, serials); }, step.value);
    }
    template <class T>
    void check_added(const edit_step::Add<T>& step, uint32_t (&serials)[kKindCount]) const {
        const Handle<T> handle{serials[kKind<T>]++, edit.serial_ | Handle<T>::kPendingBit};
        check_uses(handle, final_value(handle, step.value));
    }
    template <class Other>
    void check_added(const Other&, uint32_t (&)[kKindCount]) const {}
};

// ---- applying ----

struct Scene::Applier {
    Scene& scene;
    ChangeSet& changes;
    std::vector<Handle<Node>> dirty_nodes = {};
    std::vector<Handle<Instance>> dirty_instances = {};
    std::vector<Handle<Light>> dirty_lights = {};
    std::vector<Handle<Camera>> dirty_cameras = {};

    template <class T>
    SlotMap<T>& table() {
        return std::get<SlotMap<T>>(scene.tables_);
    }
    template <class T>
    std::vector<Handle<T>>& dirty() {
        if constexpr (std::is_same_v<T, Node>)
            return dirty_nodes;
        else if constexpr (std::is_same_v<T, Instance>)
            return dirty_instances;
        else if constexpr (std::is_same_v<T, Light>)
            return dirty_lights;
        else
            return dirty_cameras;
    }
    template <class T>
    static std::vector<Handle<T>>& attached(Node& node) {
        if constexpr (std::is_same_v<T, Node>)
            return node.children;
        else if constexpr (std::is_same_v<T, Instance>)
            return node.instances;
        else if constexpr (std::is_same_v<T, Light>)
            return node.lights;
        else
            return node.cameras;
    }
    template <class T>
    static Handle<Node> owner(const T& value) {
        if constexpr (std::is_same_v<T, Node>)
            return value.parent;
        else
            return value.place.node;
    }
    template <class T>
    static constexpr bool kPlaced =
        std::is_same_v<T, Node> || std::is_same_v<T, Instance> || std::is_same_v<T, Light> || std::is_same_v<T, Camera>;

    template <class T>
    void operator()(edit_step::Add<T>& step) {
        detail::visit_refs(step.value, [&](auto& handle, bool) { handle = changes.resolve(handle); });
        if constexpr (std::is_same_v<T, Node>) {
            step.value.children.clear();
            step.value.instances.clear();
            step.value.lights.clear();
            step.value.cameras.clear();
        }
        const Handle<T> handle = table<T>().insert(std::move(step.value));
        std::get<std::vector<Handle<T>>>(changes.resolved_).push_back(handle);
        changes.of<T>().added.push_back(handle);
        if constexpr (kPlaced<T>) {
            if (const Handle<Node> node = owner(table<T>().get(handle))) attached<T>(table<Node>().change(node)).push_back(handle);
            dirty<T>().push_back(handle);
        }
    }
    template <class T>
    void operator()(edit_step::Remove<T>& step) {
        const Handle<T> handle = changes.resolve(step.handle);
        if constexpr (kPlaced<T>) {
            const Handle<Node> node = owner(table<T>().get(handle));
            // The owner may be gone already if it is removed in this edit too.
            if (node && table<Node>().contains(node)) std::erase(attached<T>(table<Node>().change(node)), handle);
        }
        table<T>().erase(handle);
        changes.of<T>().removed.push_back(handle);
    }
    template <class T>
    void operator()(edit_step::Move<T>& step) {
        const Handle<T> handle = changes.resolve(step.handle);
        if constexpr (std::is_same_v<T, Node>) {
            table<Node>().change(handle).local = step.local;
            changes.nodes.changed.push_back(handle);
        } else {
            table<T>().change(handle).place.node_from_object = *step.local.matrix;
        }
        dirty<T>().push_back(handle);
    }
    void operator()(edit_step::Show& step) {
        const Handle<Node> handle = changes.resolve(step.handle);
        table<Node>().change(handle).visible = step.visible;
        changes.nodes.changed.push_back(handle);
        dirty_nodes.push_back(handle);
    }
    void operator()(edit_step::Pose& step) {
        const Handle<Instance> handle = changes.resolve(step.handle);
        Instance& instance = table<Instance>().change(handle);
        instance.posed = changes.resolve(step.posed);
        instance.weights = std::move(step.weights);
        changes.instances.changed.push_back(handle);
    }
    template <class T>
    void operator()(edit_step::Replace<T>& step) {
        const Handle<T> handle = changes.resolve(step.handle);
        T& current = table<T>().change(handle);
        if constexpr (kPlaced<T>)
            step.value.place = current.place;
        else
            detail::visit_refs(step.value, [&](auto& ref, bool) { ref = changes.resolve(ref); });
        current = std::move(step.value);
        changes.of<T>().changed.push_back(handle);
    }
    void operator()(Environment& environment) {
        scene.environment_ = std::move(environment);
        changes.environment = true;
    }
    void operator()(SceneSource& source) { scene.source_ = std::move(source); }

    // The highest nodes of the dirty ones: updating their subtrees updates all. Each node is climbed over once.
    std::vector<Handle<Node>> topmost_dirty() {
        const HandleSet<Node> dirty_set(dirty_nodes.begin(), dirty_nodes.end());
        std::unordered_map<Handle<Node>, bool> covered;  // has a dirty node at or above it
        std::vector<Handle<Node>> tops, path;
        for (const Handle<Node> start : dirty_nodes) {
            if (!table<Node>().contains(start)) continue;
            path.clear();
            Handle<Node> at = start;
            for (; at && !covered.contains(at); at = table<Node>().get(at).parent) path.push_back(at);
            bool above = at && covered[at];
            for (auto node = path.rbegin(); node != path.rend(); ++node) {
                const bool is_dirty = dirty_set.contains(*node);
                if (is_dirty && !above) tops.push_back(*node);
                above = above || is_dirty;
                covered[*node] = above;
            }
        }
        return tops;
    }

    void update_subtree(Handle<Node> top) {
        std::vector<Handle<Node>> stack{top};
        while (!stack.empty()) {
            const Handle<Node> handle = stack.back();
            stack.pop_back();
            Node& node = table<Node>().change(handle);
            const glm::dmat4 local(matrix_of(node.local));
            const glm::dmat4 world = node.parent ? table<Node>().get(node.parent).world_from_node * local : local;
            const bool shown = node.visible && (!node.parent || table<Node>().get(node.parent).shown);
            if (world != node.world_from_node || shown != node.shown) changes.nodes.changed.push_back(handle);
            node.world_from_node = world;
            node.shown = shown;
            stack.insert(stack.end(), node.children.begin(), node.children.end());
            dirty_instances.insert(dirty_instances.end(), node.instances.begin(), node.instances.end());
            dirty_lights.insert(dirty_lights.end(), node.lights.begin(), node.lights.end());
            dirty_cameras.insert(dirty_cameras.end(), node.cameras.begin(), node.cameras.end());
        }
    }

    template <class T>
    void update_places(const std::vector<Handle<T>>& handles, std::vector<Handle<T>>& moved) {
        const auto& added = changes.of<T>().added;
        const HandleSet<T> fresh(added.begin(), added.end());
        for (const Handle<T> handle : handles) {
            if (!table<T>().contains(handle)) continue;
            Placement& place = table<T>().change(handle).place;
            glm::mat4 world = place.node_from_object;
            if (place.node) world = glm::mat4(table<Node>().get(place.node).world_from_node * glm::dmat4(place.node_from_object));
            const bool shown = !place.node || table<Node>().get(place.node).shown, shows_or_hides = shown != place.shown;
            place.shown = shown;
            if (fresh.contains(handle)) {
                place.world_from_object = place.world_from_object_before = world;
                continue;
            }
            if (world == place.world_from_object && !shows_or_hides) continue;
            if (world != place.world_from_object && place.world_from_object == place.world_from_object_before) moved.push_back(handle);
            place.world_from_object = world;
            changes.of<T>().changed.push_back(handle);
        }
    }

    void finish() {
        for (const Handle<Node> top : topmost_dirty()) update_subtree(top);
        update_places(dirty_instances, scene.moved_instances_);
        update_places(dirty_lights, scene.moved_lights_);
        update_places(dirty_cameras, scene.moved_cameras_);
        for_each_type(SceneTypes{}, [&]<class T>() { normalize(changes.of<T>()); });
    }
};

ChangeSet Scene::apply(SceneEdit edit) {
    Checker checker{*this, edit};
    for (SceneEdit::Step& step : edit.steps_) std::visit(checker, step.value);
    if (checker.removes) checker.check_removed_unused();

    ChangeSet changes;
    changes.serial_ = edit.serial_;
    Applier applier{*this, changes};
    for (SceneEdit::Step& step : edit.steps_) std::visit(applier, step.value);
    applier.finish();
    return changes;
}

ChangeSet Scene::begin_frame() {
    ChangeSet changes;
    const auto settle = [&]<class T>(std::vector<Handle<T>>& moved) {
        for (const Handle<T> handle : moved) {
            if (!all<T>().contains(handle)) continue;
            Placement& place = std::get<SlotMap<T>>(tables_).change(handle).place;
            if (place.world_from_object_before == place.world_from_object) continue;
            place.world_from_object_before = place.world_from_object;
            changes.of<T>().changed.push_back(handle);
        }
        moved.clear();
    };
    settle(moved_instances_);
    settle(moved_lights_);
    settle(moved_cameras_);
    return changes;
}

}  // namespace parhelion
