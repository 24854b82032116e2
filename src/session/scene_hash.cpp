// A hash of everything in a scene that reaches the picture.
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
}

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
    for (const auto& [handle, instance] : scene.instances()) add_plain(hasher.add(instance.drawn_mesh().index).add(instance.ray_mask).add(instance.opacity), instance.place.world_from_object);
    for (const auto& [handle, light] : scene.lights()) {
        hasher.add(light.kind).add(light.intensity).add(light.range).add(light.inner_cone).add(light.outer_cone).add(light.angular_radius);
        add_plain(hasher, light.color);
        add_plain(hasher, light.place.world_from_object);
    }
    const Environment& environment = scene.environment();
    add_array(hasher.add(environment.width).add(environment.height).add(environment.rotation), environment.radiance);
    add_plain(hasher, environment.scale);
    return hasher.value();
}

}  // namespace parhelion
