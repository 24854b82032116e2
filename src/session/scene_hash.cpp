// Hashes of everything in a scene that reaches the picture, and of all that moves it.
#include "base/hash.h"
#include "session/scene_setup.h"

namespace parhelion {

namespace {

template <class T>
void add_array(Hasher& hasher, const std::vector<T>& values) {
    hasher.add(static_cast<uint64_t>(values.size())).bytes(values.data(), values.size() * sizeof(T));
}

template <class T>
void add_plain(Hasher& hasher, const T& value) {
    static_assert(std::has_unique_object_representations_v<T> || sizeof(T) % sizeof(float) == 0);
    hasher.bytes(&value, sizeof(T));
}

void add_texture(Hasher& hasher, const TextureRef& ref) {
    hasher.add(ref.texture.index).add(ref.uv_set).add(ref.rotation);
    add_plain(hasher, ref.offset);
    add_plain(hasher, ref.scale);
}

void add_material(Hasher& hasher, const Material& m) {
    add_plain(hasher, m.base_color);
    add_plain(hasher, m.emission);
    hasher.add(m.metallic).add(m.roughness).add(m.normal_scale).add(m.alpha_mode).add(m.alpha_cutoff).add(m.double_sided).add(m.unlit);
    hasher.add(m.ior).add(m.specular).add(m.transmission);
    hasher.add(m.thickness).add(m.attenuation_distance).add(m.dispersion).add(m.nested_priority);
    hasher.add(m.clearcoat).add(m.clearcoat_roughness).add(m.clearcoat_normal_scale);
    hasher.add(m.sheen_roughness).add(m.anisotropy).add(m.anisotropy_rotation);
    hasher.add(m.iridescence).add(m.iridescence_ior).add(m.iridescence_thickness_min).add(m.iridescence_thickness_max);
    for (const glm::vec3& color : {m.specular_color, m.attenuation_color, m.sheen_color}) add_plain(hasher, color);
    for (const MaterialTexture& texture : material_textures()) add_texture(hasher, m.*texture.ref);
}

void add_primitive(Hasher& hasher, const Primitive& p) {
    add_array(hasher, p.positions);
    add_array(hasher, p.normals);
    add_array(hasher, p.tangents);
    add_array(hasher, p.uv0);
    add_array(hasher, p.uv1);
    add_array(hasher, p.colors);
    add_array(hasher, p.triangles);
    hasher.add(p.material.index);
    for (const MorphTarget& target : p.targets) {
        add_array(hasher, target.positions);
        add_array(hasher, target.normals);
        add_array(hasher, target.tangents);
    }
    if (p.joints.empty()) return;
    add_array(hasher.add(p.influence_count), p.joints);
    add_array(hasher, p.joint_weights);
}

void add_place(Hasher& hasher, const Placement& place) { add_plain(hasher.add(place.node.index), place.node_from_object); }

}  // namespace

uint64_t hash_scene(const Scene& scene) {
    Hasher hasher;
    for (const auto& [handle, image] : scene.images()) add_array(hasher.add(image.width).add(image.height), image.texels);
    for (const auto& [handle, texture] : scene.textures()) {
        const Sampler& s = texture.sampler;
        hasher.add(texture.image.index)
            .add(texture.color_space)
            .add(s.wrap_u)
            .add(s.wrap_v)
            .add(s.mag)
            .add(s.min)
            .add(s.mip ? static_cast<int>(*s.mip) : -1);
    }
    for (const auto& [handle, material] : scene.materials()) add_material(hasher, material);
    for (const auto& [handle, mesh] : scene.meshes()) {
        for (const Primitive& primitive : mesh.primitives) add_primitive(hasher.add(handle.index), primitive);
        if (!mesh.deformation) continue;
        add_array(hasher.add(mesh.rest.index), mesh.deformation->weights);
        add_array(hasher, mesh.deformation->object_from_rest);
    }
    for (const auto& [handle, instance] : scene.instances()) add_plain(hasher.add(instance.drawn_mesh().index).add(instance.ray_mask).add(instance.opacity).add(instance.place.shown), instance.place.world_from_object);
    for (const auto& [handle, light] : scene.lights()) {
        hasher.add(light.kind).add(light.intensity).add(light.range).add(light.inner_cone).add(light.outer_cone).add(light.angular_radius);
        add_plain(hasher.add(light.place.shown), light.color);
        add_plain(hasher, light.place.world_from_object);
    }
    const Environment& environment = scene.environment();
    add_array(hasher.add(environment.width).add(environment.height).add(environment.rotation), environment.radiance);
    add_plain(hasher, environment.scale);
    return hasher.value();
}

uint64_t hash_motion(const Scene& scene) {
    Hasher hasher;
    for (const auto& [handle, node] : scene.nodes()) {
        add_plain(hasher.add(handle.index).add(node.parent.index).add(node.visible), node.world_from_node);
        add_plain(hasher, matrix_of(node.local));
    }
    for (const auto& [handle, skin] : scene.skins()) {
        for (const Handle<Node> joint : skin.joints) hasher.add(joint.index);
        add_array(hasher.add(handle.index), skin.inverse_bind);
    }
    for (const auto& [handle, animation] : scene.animations()) {
        hasher.text(animation.name);
        for (const AnimationChannel& channel : animation.channels) {
            add_array(hasher.add(channel.node.index).add(channel.light.index).add(channel.camera.index).add(channel.path).add(channel.interpolation).add(channel.width), channel.times);
            add_array(hasher, channel.values);
        }
    }
    for (const auto& [handle, instance] : scene.instances()) {
        add_place(hasher.add(instance.skin.index), instance.place);
        add_array(hasher, instance.weights);
    }
    for (const auto& [handle, light] : scene.lights()) add_place(hasher, light.place);
    for (const auto& [handle, camera] : scene.cameras()) {
        add_place(hasher.text(camera.name).add(camera.kind).add(camera.yfov).add(camera.xmag).add(camera.ymag), camera.place);
    }
    return hasher.value();
}

}  // namespace parhelion
