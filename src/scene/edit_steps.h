#pragma once
// What a SceneEdit is made of; for what records and carries out edits. Apart from edit.h, because a variant of so many types is long to compile.
#include <type_traits>
#include <variant>

#include "scene/edit.h"

namespace parhelion {

namespace edit_step {
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
struct Show {
    Handle<Node> handle;
    bool visible;
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
}  // namespace edit_step

template <class... Ts>
struct TypeList {};
using SceneTypes = TypeList<Image, Texture, Material, Mesh, Node, Skin, Animation, Instance, Light, Camera>;

// The position of a type in the list.
template <class T, class... Ts>
constexpr size_t position_in(TypeList<Ts...>) {
    size_t position = 0;
    bool found = false;
    ((found = found || std::is_same_v<T, Ts>, position += found ? 0 : 1), ...);
    return position;
}
template <class T>
constexpr size_t kKind = position_in<T>(SceneTypes{});
constexpr size_t kKindCount = position_in<void>(SceneTypes{});

template <class... Ts>
using StepOf = std::variant<edit_step::Add<Ts>..., edit_step::Remove<Ts>..., edit_step::Move<Node>, edit_step::Move<Instance>, edit_step::Move<Light>, edit_step::Move<Camera>, edit_step::Show, edit_step::Pose,
                            edit_step::Replace<Material>, edit_step::Replace<Light>, edit_step::Replace<Camera>, Environment, SceneSource>;
struct SceneEdit::Step {
    StepOf<Image, Texture, Material, Mesh, Node, Skin, Animation, Instance, Light, Camera> value;
};

}  // namespace parhelion
