#include "scene/scene.h"

#include <algorithm>
#include <cmath>

#include "scene/deform.h"

namespace parhelion {

std::vector<uint8_t> rgba8_texels(const Image& image) {
    return image::decode_to_rgba8(image.format, image.width, image.height, image.level_count, image.texels);
}

std::span<const MaterialTexture> material_textures() {
    using M = Material;
    static constexpr MaterialTexture kTextures[] = {
        {&M::base_color_texture, ColorSpace::Srgb},      {&M::metal_rough_texture, ColorSpace::Linear},
        {&M::normal_texture, ColorSpace::Linear},        {&M::occlusion_texture, ColorSpace::Linear},
        {&M::emissive_texture, ColorSpace::Srgb},        {&M::specular_texture, ColorSpace::Linear},
        {&M::specular_color_texture, ColorSpace::Srgb},  {&M::transmission_texture, ColorSpace::Linear},
        {&M::thickness_texture, ColorSpace::Linear},     {&M::clearcoat_texture, ColorSpace::Linear},
        {&M::clearcoat_roughness_texture, ColorSpace::Linear},
        {&M::clearcoat_normal_texture, ColorSpace::Linear},
        {&M::sheen_color_texture, ColorSpace::Srgb},     {&M::sheen_roughness_texture, ColorSpace::Linear},
        {&M::anisotropy_texture, ColorSpace::Linear},    {&M::iridescence_texture, ColorSpace::Linear},
        {&M::iridescence_thickness_texture, ColorSpace::Linear},
    };
    return kTextures;
}

glm::mat3 uv_transform(const TextureRef& ref) {
    // Counter-clockwise as seen, with v pointing down: u turns towards -v. (The listing in KHR_texture_transform has the other
    // sign; KhronosGroup/glTF issue 1563 and the sample model agree with its text and with this.)
    const float c = std::cos(ref.rotation), s = std::sin(ref.rotation);
    return {glm::vec3(c * ref.scale.x, -s * ref.scale.x, 0.0f), glm::vec3(s * ref.scale.y, c * ref.scale.y, 0.0f),
            glm::vec3(ref.offset, 1.0f)};
}

glm::mat4 matrix_of(const Transform& transform) {
    if (transform.matrix) return *transform.matrix;
    glm::mat4 m = glm::mat4_cast(transform.rotation);
    m[0] *= transform.scale.x;
    m[1] *= transform.scale.y;
    m[2] *= transform.scale.z;
    m[3] = glm::vec4(transform.translation, 1.0f);
    return m;
}

bool mirrors(const glm::mat4& world_from_object) { return glm::determinant(glm::dmat3(glm::mat3(world_from_object))) < 0.0; }

bool drawable(const glm::mat4& world_from_object) {
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row)
            if (!std::isfinite(world_from_object[column][row])) return false;
    // The inverse, in float, must be finite too: cofactors by the determinant.
    const glm::dmat3 m{glm::mat3(world_from_object)};
    const glm::dvec3 rows[3] = {glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1])};
    const double most = 1e30 * std::abs(glm::dot(m[0], rows[0]));
    for (const glm::dvec3& row : rows)
        for (int i = 0; i < 3; ++i)
            if (!(std::abs(row[i]) < most)) return false;
    return true;
}

template <>
ChangeSet::Changed<Image>& ChangeSet::of<Image>() {
    return images;
}
template <>
ChangeSet::Changed<Texture>& ChangeSet::of<Texture>() {
    return textures;
}
template <>
ChangeSet::Changed<Material>& ChangeSet::of<Material>() {
    return materials;
}
template <>
ChangeSet::Changed<Mesh>& ChangeSet::of<Mesh>() {
    return meshes;
}
template <>
ChangeSet::Changed<Node>& ChangeSet::of<Node>() {
    return nodes;
}
template <>
ChangeSet::Changed<Skin>& ChangeSet::of<Skin>() {
    return skins;
}
template <>
ChangeSet::Changed<Animation>& ChangeSet::of<Animation>() {
    return animations;
}
template <>
ChangeSet::Changed<Instance>& ChangeSet::of<Instance>() {
    return instances;
}
template <>
ChangeSet::Changed<Light>& ChangeSet::of<Light>() {
    return lights;
}
template <>
ChangeSet::Changed<Camera>& ChangeSet::of<Camera>() {
    return cameras;
}

namespace {

// Of a form: its own is larger.
Bounds bounds_of_shape(const Scene& scene, const Mesh& form) {
    Bounds box;
    Primitive storage;
    for (size_t i = 0; i < form.primitives.size(); ++i)
        for (const glm::vec3& p : drawn_shape(scene, form, i, storage).positions) box.add(p);
    return box;
}

}  // namespace

Bounds Scene::bounds() const {
    Bounds world;
    for (const auto& [handle, instance] : instances()) {
        const Mesh& mesh = get(instance.drawn_mesh());
        const Bounds box = mesh.deformation ? bounds_of_shape(*this, mesh) : mesh.bounds;
        if (box.empty() || !can_be_seen(instance.place)) continue;
        for (int corner = 0; corner < 8; ++corner) {
            const glm::vec3 p(corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y, corner & 4 ? box.max.z : box.min.z);
            world.add(glm::vec3(instance.place.world_from_object * glm::vec4(p, 1.0f)));
        }
    }
    return world;
}

}  // namespace parhelion
