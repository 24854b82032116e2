#pragma once
// Internal to the scene layer: which handles a value holds. visit(handle, required) is called for each; `required` handles must
// name something, the others may be empty.
#include "scene/types.h"

namespace parhelion::detail {

template <class V>
void visit_refs(Image&, V&&) {}
template <class V>
void visit_refs(Texture& texture, V&& visit) {
    visit(texture.image, true);
}
template <class V>
void visit_refs(Material& material, V&& visit) {
    for (const MaterialTexture& texture : material_textures()) visit((material.*texture.ref).texture, false);
}
template <class V>
void visit_refs(Mesh& mesh, V&& visit) {
    visit(mesh.rest, false);
    for (Primitive& primitive : mesh.primitives) {
        visit(primitive.material, true);
        for (Handle<Material>& material : primitive.variant_materials) visit(material, false);
    }
}
template <class V>
void visit_refs(Node& node, V&& visit) {
    visit(node.parent, false);
}
template <class V>
void visit_refs(Instance& instance, V&& visit) {
    visit(instance.mesh, true);
    visit(instance.posed, false);
    visit(instance.skin, false);
    visit(instance.place.node, false);
}
template <class V>
void visit_refs(Skin& skin, V&& visit) {
    for (Handle<Node>& joint : skin.joints) visit(joint, true);
}
template <class V>
void visit_refs(Animation& animation, V&& visit) {
    for (AnimationChannel& channel : animation.channels) {
        const AnimatedObject object = object_of(channel.path);
        visit(channel.node, object == AnimatedObject::Node);
        visit(channel.light, object == AnimatedObject::Light);
        visit(channel.camera, object == AnimatedObject::Camera);
    }
}
template <class V>
void visit_refs(Light& light, V&& visit) {
    visit(light.place.node, false);
}
template <class V>
void visit_refs(Camera& camera, V&& visit) {
    visit(camera.place.node, false);
}
template <class T, class V>
void visit_const_refs(const T& value, V&& visit) {
    visit_refs(const_cast<T&>(value), [&](const auto& handle, bool required) { visit(handle, required); });
}

// Value checks: throw Error naming the object and what is wrong with it.
void check_value(const Image& image);
void check_value(const Texture& texture);
void check_value(const Material& material);
void check_value(const Mesh& mesh);
void check_value(const Node& node);
void check_value(const Skin& skin);
void check_value(const Animation& animation);
void check_value(const Instance& instance);
void check_value(const Light& light);
void check_value(const Camera& camera);
void check_value(const Environment& environment);
void check_value(const Transform& transform);

}  // namespace parhelion::detail
