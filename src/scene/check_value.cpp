// What an edit may put into a scene: sizes that agree, indices in range, finite numbers. Renderers rely on it.
#include <algorithm>
#include <bit>
#include <cmath>

#include "scene/scene_refs.h"

namespace parhelion::detail {

namespace {

template <class T>
[[noreturn]] void fail(const T& object, std::string what, std::string hint = {}) {
    throw Error(ErrorCode::Failed, std::move(what), fmt::format("{} '{}'", T::kTypeName, escape_name(object.name)), std::move(hint));
}

bool finite(float x) { return std::isfinite(x); }
template <glm::length_t N>
bool finite(const glm::vec<N, float, glm::defaultp>& v) {
    for (glm::length_t i = 0; i < N; ++i)
        if (!std::isfinite(v[i])) return false;
    return true;
}
bool finite(const glm::mat4& m) { return finite(m[0]) && finite(m[1]) && finite(m[2]) && finite(m[3]); }

template <class V>
bool all_finite(const std::vector<V>& values) {
    for (const V& v : values)
        if (!finite(v)) return false;
    return true;
}

bool valid_ref(const TextureRef& ref) { return ref.uv_set <= 1 && finite(ref.offset) && finite(ref.scale) && finite(ref.rotation); }

template <class V>
void check_attribute(const Mesh& mesh, const Primitive& primitive, const std::vector<V>& values, std::string_view name) {
    if (!values.empty() && values.size() != primitive.positions.size())
        fail(mesh, fmt::format("has {} {} for {} positions", values.size(), name, primitive.positions.size()));
    if (!all_finite(values)) fail(mesh, fmt::format("its {} have a value that is not finite", name));
}

// Their sums are 1 but for roundings: where the joints are bounds where the vertices can be (deformed_bounds()).
void check_joint_weights(const Mesh& mesh, const Primitive& primitive) {
    if (!all_finite(primitive.joint_weights)) fail(mesh, "its joint weights have a value that is not finite");
    const uint32_t n = primitive.influence_count;
    for (size_t vertex = 0; n != 0 && vertex < primitive.positions.size(); ++vertex) {
        double sum = 0.0;
        for (size_t k = vertex * n; k < (vertex + 1) * n; ++k) {
            if (primitive.joint_weights[k] < 0.0f) fail(mesh, fmt::format("vertex {} has a negative joint weight", vertex));
            sum += double(primitive.joint_weights[k]);
        }
        if (std::abs(sum - 1.0) > 1e-5) fail(mesh, fmt::format("the joint weights of vertex {} sum to {:g}, not to 1", vertex, sum));
    }
}

void check_deformation(const Mesh& mesh) {
    if (!mesh.rest) fail(mesh, "has a deformation, but is no form of a mesh");
    const auto has_arrays = [](const Primitive& p) { return !p.positions.empty() || !p.triangles.empty() || !p.targets.empty() || p.influence_count != 0; };
    if (std::ranges::any_of(mesh.primitives, has_arrays)) fail(mesh, "has both a deformation and arrays");
    if (!all_finite(mesh.deformation->weights)) fail(mesh, "has a morph weight that is not finite");
    for (const glm::mat4x3& m : mesh.deformation->object_from_rest)
        for (int column = 0; column < 4; ++column)
            if (!finite(m[column])) fail(mesh, "has a joint whose place is not finite");
}

}  // namespace

void check_value(const Image& image) {
    if (image.width == 0 || image.height == 0 || image.level_count == 0 ||
        image.level_count > static_cast<uint32_t>(std::bit_width(std::max(image.width, image.height))))
        fail(image, fmt::format("is empty: {} x {} pixels, {} levels", image.width, image.height, image.level_count));
    const uint64_t expected = image::image_bytes(image.format, image.width, image.height, image.level_count);
    if (image.texels.size() != expected)
        fail(image, fmt::format("has {} bytes, expected {} for {} x {} pixels in {} levels", image.texels.size(), expected, image.width,
                                image.height, image.level_count));
}

void check_value(const Texture&) {}

void check_value(const Material& m) {
    const float numbers[] = {m.metallic, m.roughness, m.normal_scale, m.occlusion_strength, m.alpha_cutoff, m.ior, m.specular,
                             m.transmission, m.thickness, m.dispersion, m.clearcoat, m.clearcoat_roughness, m.clearcoat_normal_scale,
                             m.sheen_roughness, m.anisotropy, m.anisotropy_rotation, m.iridescence, m.iridescence_ior,
                             m.iridescence_thickness_min, m.iridescence_thickness_max};
    bool all = finite(m.base_color) && finite(m.emission) && finite(m.specular_color) && finite(m.attenuation_color) && finite(m.sheen_color);
    for (const float number : numbers) all = all && finite(number);
    if (std::abs(m.nested_priority) > kMostNestedPriority) fail(m, fmt::format("its nested priority {} is not within +-{}", m.nested_priority, kMostNestedPriority));
    if (!(m.attenuation_distance > 0.0f)) fail(m, "its attenuation distance is not above 0");
    if (!all) fail(m, "has a number that is not finite");
    if (m.emission.x < 0.0f || m.emission.y < 0.0f || m.emission.z < 0.0f) fail(m, "emits negative light");
    for (const MaterialTexture& texture : material_textures())
        if (!valid_ref(m.*texture.ref)) fail(m, "has a texture with a UV set other than 0 and 1, or a transform that is not finite");
}

void check_value(const Mesh& mesh) {
    if (mesh.deformation) check_deformation(mesh);
    for (const Primitive& primitive : mesh.primitives) {
        const size_t vertices = primitive.positions.size();
        if (vertices > 0xFFFFFFFFull || primitive.triangles.size() > 0xFFFFFFFFull / 3) fail(mesh, "has more than 2^32 indices");
        for (const glm::vec3& p : primitive.positions)
            if (!(glm::max(glm::abs(p.x), glm::max(glm::abs(p.y), glm::abs(p.z))) <= kLargestCoordinate && finite(p)))
                fail(mesh, fmt::format("has a position that is not finite or beyond {:g} metres", kLargestCoordinate));
        check_attribute(mesh, primitive, primitive.normals, "normals");
        check_attribute(mesh, primitive, primitive.tangents, "tangents");
        check_attribute(mesh, primitive, primitive.uv0, "texture coordinates");
        check_attribute(mesh, primitive, primitive.uv1, "second texture coordinates");
        check_attribute(mesh, primitive, primitive.colors, "colours");
        for (const MorphTarget& target : primitive.targets) {
            check_attribute(mesh, primitive, target.positions, "morphed positions");
            check_attribute(mesh, primitive, target.normals, "morphed normals");
            check_attribute(mesh, primitive, target.tangents, "morphed tangents");
        }
        const uint64_t influences = uint64_t(primitive.influence_count) * vertices;
        if (primitive.joints.size() != influences || primitive.joint_weights.size() != influences)
            fail(mesh, fmt::format("has {} joints and {} weights, expected {}", primitive.joints.size(), primitive.joint_weights.size(), influences));
        check_joint_weights(mesh, primitive);
        for (const glm::uvec3& t : primitive.triangles)
            if (t.x >= vertices || t.y >= vertices || t.z >= vertices)
                fail(mesh, fmt::format("triangle ({}, {}, {}) names a vertex beyond {}", t.x, t.y, t.z, vertices));
    }
}

void check_value(const Transform& transform) {
    const glm::quat& q = transform.rotation;
    const bool good = transform.matrix ? finite(*transform.matrix)
                                       : finite(transform.translation) && finite(transform.scale) && finite(glm::vec4(q.x, q.y, q.z, q.w));
    if (!good) throw Error(ErrorCode::Failed, "has a number that is not finite", "transform");
}

void check_value(const Node& node) { check_value(node.local); }

void check_value(const Skin& skin) {
    if (skin.joints.empty() || skin.joints.size() != skin.inverse_bind.size())
        fail(skin, fmt::format("has {} joints and {} inverse bind matrices", skin.joints.size(), skin.inverse_bind.size()));
    for (const glm::mat4& matrix : skin.inverse_bind)
        if (!finite(matrix)) fail(skin, "has an inverse bind matrix that is not finite");
}

void check_value(const Animation& animation) {
    for (const AnimationChannel& c : animation.channels) {
        const uint64_t keys = c.times.size(), values = keys * c.width * (c.interpolation == Interpolation::CubicSpline ? 3 : 1);
        if (keys == 0 || c.width == 0 || c.values.size() != values)
            fail(animation, fmt::format("a channel has {} values for {} keys of {} numbers", c.values.size(), keys, c.width));
        if (!all_finite(c.times) || !all_finite(c.values)) fail(animation, "has a number that is not finite");
        for (size_t i = 1; i < c.times.size(); ++i)
            if (!(c.times[i] > c.times[i - 1])) fail(animation, "has times that do not increase");
    }
}

void check_value(const Instance& instance) {
    if (!finite(instance.place.node_from_object)) throw Error(ErrorCode::Failed, "has a number that is not finite", "instance transform");
    if (instance.ray_mask > 0xFFu) throw Error(ErrorCode::Failed, fmt::format("has the ray mask {:#x}", instance.ray_mask), "instance", "a ray mask has 8 bits");
}

void check_value(const Light& light) {
    if (!finite(light.color) || !finite(light.intensity) || !finite(light.range) || !finite(light.angular_radius) ||
        !finite(light.place.node_from_object))
        fail(light, "has a number that is not finite");
    if (light.intensity < 0.0f || light.color.x < 0.0f || light.color.y < 0.0f || light.color.z < 0.0f)
        fail(light, "has negative intensity");
    if (light.range < 0.0f || light.angular_radius < 0.0f) fail(light, "has a negative range or size");
    constexpr float kHalfPi = 1.5707964f;
    if (light.kind == LightKind::Spot && !(light.inner_cone >= 0.0f && light.inner_cone <= light.outer_cone && light.outer_cone <= kHalfPi))
        fail(light, "its cone angles are out of order", "0 <= inner <= outer <= 90 degrees");
}

void check_value(const Camera& camera) {
    constexpr float kPi = 3.1415927f;
    if (!finite(camera.place.node_from_object)) fail(camera, "has a number that is not finite");
    const bool perspective = camera.kind == CameraKind::Perspective;
    if (perspective && !(camera.yfov > 0.0f && camera.yfov < kPi)) fail(camera, "its vertical angle is not between 0 and 180 degrees");
    if (!perspective && !(camera.xmag > 0.0f && camera.ymag > 0.0f && finite(camera.xmag) && finite(camera.ymag)))
        fail(camera, "its extents are not positive");
    if (!(camera.near_plane >= 0.0f && finite(camera.near_plane)) || (perspective && camera.near_plane == 0.0f))
        fail(camera, "its near plane is not positive");
    if (camera.far_plane && !(*camera.far_plane > camera.near_plane && finite(*camera.far_plane)))
        fail(camera, "its far plane is not beyond the near plane");
}

void check_value(const Environment& environment) {
    const auto bad = [&](std::string what) {
        throw Error(ErrorCode::Failed, std::move(what), fmt::format("environment '{}'", escape_name(environment.name)));
    };
    if (uint64_t(environment.width) * environment.height != environment.radiance.size())
        bad(fmt::format("has {} values for {} x {} pixels", environment.radiance.size(), environment.width, environment.height));
    if (!finite(environment.scale) || !finite(environment.rotation) || !all_finite(environment.radiance))
        bad("has a number that is not finite");
    for (const glm::vec3& radiance : environment.radiance)
        if (radiance.x < 0.0f || radiance.y < 0.0f || radiance.z < 0.0f) bad("has negative radiance");
    if (environment.scale.x < 0.0f || environment.scale.y < 0.0f || environment.scale.z < 0.0f) bad("has negative intensity");
}

}  // namespace parhelion::detail
