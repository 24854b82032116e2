#pragma once
// What a scene is made of, as plain structs: the core of glTF 2.0 and the material extensions that are drawn. Metres, radians,
// right-handed with +Y up, column vectors; radiance in nits. Fields marked "kept by Scene" are computed by Scene::apply.
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include "image/texels.h"
#include "scene/handle.h"

namespace parhelion {

struct Mesh;
struct Material;
struct Image;
struct Texture;
struct Node;
struct Skin;
struct Animation;
struct Instance;
struct Light;
struct Camera;

// No coordinate of a scene is larger, so that products of two (areas, squared distances) stay within float. Metres.
constexpr float kLargestCoordinate = 1e18f;

struct Bounds {
    glm::vec3 min{2.0f * kLargestCoordinate}, max{-2.0f * kLargestCoordinate};  // empty until something is added
    bool empty() const { return !(min.x <= max.x); }
    glm::vec3 center() const { return 0.5f * (min + max); }
    float diagonal() const { return empty() ? 0.0f : glm::length(max - min); }
    void add(glm::vec3 p) { min = glm::min(min, p), max = glm::max(max, p); }
    void add(const Bounds& b) { min = glm::min(min, b.min), max = glm::max(max, b.max); }
};

// ---- images and materials ----

using image::TexelFormat;

// Rows from the top. How the numbers are to be read (sRGB or linear) is said by the Texture.
struct Image {
    static constexpr std::string_view kTypeName = "image";
    std::string name;
    uint32_t width = 0, height = 0;
    TexelFormat format = TexelFormat::Rgba8;
    uint32_t level_count = 1;     // levels that are stored; of one level the others are made on the device (never of blocks)
    std::vector<uint8_t> texels;  // all levels, finest first
    // The file that it was decoded from, where the loader was asked to keep it, for writing it again as it was.
    std::shared_ptr<const std::vector<std::byte>> encoded;
};
// All levels as Rgba8, blocks decoded (image/texels.h).
std::vector<uint8_t> rgba8_texels(const Image& image);

enum class Wrap { Repeat, MirroredRepeat, ClampToEdge };
enum class Filter { Nearest, Linear };

struct Sampler {
    Wrap wrap_u = Wrap::Repeat, wrap_v = Wrap::Repeat;
    Filter mag = Filter::Linear, min = Filter::Linear;
    std::optional<Filter> mip = Filter::Linear;  // none: only the finest level is read
    friend bool operator==(const Sampler&, const Sampler&) = default;
};

// Srgb for colours (base colour, emission), Linear for data (normals, metallic-roughness). A file that uses one image both ways
// becomes two textures of one image.
enum class ColorSpace { Srgb, Linear };

struct Texture {
    static constexpr std::string_view kTypeName = "texture";
    std::string name;
    Handle<Image> image;
    Sampler sampler;
    ColorSpace color_space = ColorSpace::Srgb;
};

// A texture as a material uses it. UVs have their origin at the image's upper left, v down.
struct TextureRef {
    Handle<Texture> texture;  // none: constant 1
    uint32_t uv_set = 0;      // 0 or 1
    glm::vec2 offset{0.0f}, scale{1.0f};
    float rotation = 0.0f;  // radians, of the UVs, counter-clockwise as the image is seen (KHR_texture_transform)
};
// uv' = uv_transform(ref) * vec3(uv, 1): scale, then rotation, then offset.
glm::mat3 uv_transform(const TextureRef& ref);

constexpr int kMostNestedPriority = 1000;

enum class AlphaMode { Opaque, Mask, Blend };

// glTF's metallic-roughness material with the extensions of KHR_materials_*, each under its own defaults (which change nothing).
// Factors multiply textures; colours are linear Rec. 709. Which channel of a texture counts is said beside it.
struct Material {
    static constexpr std::string_view kTypeName = "material";
    std::string name;
    glm::vec4 base_color{1.0f};
    TextureRef base_color_texture;
    float metallic = 1.0f, roughness = 1.0f;  // perceptual roughness: alpha = roughness^2
    TextureRef metal_rough_texture;           // metallic in blue, roughness in green
    TextureRef normal_texture;
    float normal_scale = 1.0f;
    TextureRef occlusion_texture;  // red; kept for export: paths find their own occlusion
    float occlusion_strength = 1.0f;
    glm::vec3 emission{0.0f};  // nits: emissiveFactor x emissiveStrength
    TextureRef emissive_texture;
    AlphaMode alpha_mode = AlphaMode::Opaque;
    float alpha_cutoff = 0.5f;
    bool double_sided = false;
    bool unlit = false;  // KHR_materials_unlit
    float ior = 1.5f;    // KHR_materials_ior; 0: reflects everything
    // KHR_materials_specular; specular 0 with metallic 0: pure Lambert
    float specular = 1.0f;
    TextureRef specular_texture;  // alpha
    glm::vec3 specular_color{1.0f};
    TextureRef specular_color_texture;
    // KHR_materials_transmission
    float transmission = 0.0f;
    TextureRef transmission_texture;  // red
    // KHR_materials_volume
    float thickness = 0.0f;         // metres in object space; 0: thin walls, no refraction
    TextureRef thickness_texture;   // green
    // Where volumes overlap, the one of the highest priority is there (Schmidt and Budge 2002, "Simple Nested Dielectrics in Ray Traced
    // Images"); of equal ones that which was entered last. glTF has no word for it: extras.nested_priority.
    int nested_priority = 0;  // from -kMostNestedPriority to it
    float attenuation_distance = std::numeric_limits<float>::infinity();  // metres after which attenuation_color is left
    glm::vec3 attenuation_color{1.0f};
    // KHR_materials_dispersion: 20 / Abbe number
    float dispersion = 0.0f;
    // KHR_materials_clearcoat
    float clearcoat = 0.0f, clearcoat_roughness = 0.0f;
    TextureRef clearcoat_texture, clearcoat_roughness_texture;  // red; green
    TextureRef clearcoat_normal_texture;
    float clearcoat_normal_scale = 1.0f;
    // KHR_materials_sheen
    glm::vec3 sheen_color{0.0f};
    float sheen_roughness = 0.0f;
    TextureRef sheen_color_texture, sheen_roughness_texture;  // roughness in alpha
    // KHR_materials_anisotropy
    float anisotropy = 0.0f, anisotropy_rotation = 0.0f;  // radians, counter-clockwise from the tangent
    TextureRef anisotropy_texture;                        // direction in red and green, strength in blue
    // KHR_materials_iridescence
    float iridescence = 0.0f, iridescence_ior = 1.3f;
    float iridescence_thickness_min = 100.0f, iridescence_thickness_max = 400.0f;  // nanometres
    TextureRef iridescence_texture, iridescence_thickness_texture;                 // red; green
};

// Every texture that a material may have.
struct MaterialTexture {
    TextureRef Material::*ref;
    ColorSpace color_space;
};
std::span<const MaterialTexture> material_textures();

// ---- geometry ----

// What one morph target adds to each vertex at weight 1; arrays are empty or as long as the primitive's positions.
struct MorphTarget {
    std::vector<glm::vec3> positions, normals, tangents;
    Bounds reach;  // kept by Scene: of `positions`, the zero too
};

// Triangles with one material. Attribute arrays are empty or as long as `positions`; indices lie below that length.
struct Primitive {
    std::vector<glm::vec3> positions;
    std::vector<glm::vec3> normals;   // unit; empty: flat, the triangle's own normal is the shading normal
    std::vector<glm::vec4> tangents;  // unit, handedness in w (bitangent = cross(n, t) * w); filled where a normal map needs them
    std::vector<glm::vec2> uv0, uv1;
    std::vector<glm::vec4> colors;      // linear, in [0, 1]
    std::vector<glm::uvec3> triangles;  // counter-clockwise seen from the front
    Handle<Material> material;
    std::vector<Handle<Material>> variant_materials;  // by variant of SceneSource::variants, where that many; none: `material`
    std::vector<MorphTarget> targets;
    // Skinning: influence_count joints (numbers in the instance's Skin) and weights a vertex, one vertex after the other.
    uint32_t influence_count = 0;
    std::vector<uint16_t> joints;
    std::vector<float> joint_weights;  // not negative, sum 1
    std::vector<Bounds> joint_bounds;  // kept by Scene: by joint, of the vertices that it moves
    Bounds bounds;                     // kept by Scene; of a form that has a deformation: not too small
};

// What moves the vertices of a mesh at rest: its morph targets, then a skin (glTF 2.0, 3.7.2.2 and 3.7.3.3). Normals and tangents go along.
struct MeshDeformation {
    std::vector<float> weights;                 // of the first morph targets; the others have none
    std::vector<glm::mat4x3> object_from_rest;  // by joint; empty: no skin. None of them mirrors
    bool operator==(const MeshDeformation&) const = default;
};

struct Mesh {
    static constexpr std::string_view kTypeName = "mesh";
    std::string name;
    std::vector<Primitive> primitives;
    std::vector<float> weights;             // of the morph targets, which all primitives have alike; default 0
    std::vector<std::string> target_names;  // of the morph targets, where the file names them
    // The mesh that this one is a deformed form of, which says that its acceleration structures can be refitted instead of built: as
    // many primitives, of as many vertices and triangles each. A form of a form is refused; none: a mesh of its own.
    Handle<Mesh> rest;
    // A form may say how `rest` is deformed, and then has no arrays of its own, but primitives with materials: the device makes them from
    // those of `rest`, drawn_shape() (scene/deform.h) on the host.
    std::optional<MeshDeformation> deformation;
    Bounds bounds;                // kept by Scene, as Primitive::bounds
    uint64_t triangle_count = 0;  // kept by Scene
};

// ---- placement ----

// Translation * rotation * scale, or a matrix instead.
struct Transform {
    glm::vec3 translation{0.0f};
    glm::quat rotation{1.0f, 0.0f, 0.0f, 0.0f};  // w, x, y, z; unit
    glm::vec3 scale{1.0f};
    std::optional<glm::mat4> matrix;
};
glm::mat4 matrix_of(const Transform& transform);

// A node of the hierarchy. Add parents before their children.
struct Node {
    static constexpr std::string_view kTypeName = "node";
    std::string name;
    Handle<Node> parent;  // none: a root
    Transform local;
    bool visible = true;  // false: nothing that stands on it or below it is there, but cameras (KHR_node_visibility)
    bool shown = true;    // kept by Scene, like all below: visible, and so are all above
    glm::dmat4 world_from_node{1.0};
    std::vector<Handle<Node>> children;
    std::vector<Handle<Instance>> instances;
    std::vector<Handle<Light>> lights;
    std::vector<Handle<Camera>> cameras;
};

// Where something stands: relative to a node, or in the world if it has none.
struct Placement {
    Handle<Node> node;
    glm::mat4 node_from_object{1.0f};
    bool shown = true;                         // kept by Scene: Node::shown
    glm::mat4 world_from_object{1.0f};         // kept by Scene
    glm::mat4 world_from_object_before{1.0f};  // kept by Scene: one frame ago
};

// Which hits on an instance ask its materials whether they count (alpha masks and blending).
enum class InstanceOpacity {
    ByMaterial,  // those on materials that are not opaque
    Opaque,      // none: masks have no holes
    Asked,       // all; looks like ByMaterial
};

struct Instance {
    static constexpr std::string_view kTypeName = "instance";
    Handle<Mesh> mesh;  // at rest
    Placement place;
    Handle<Skin> skin;           // none: rigid
    std::vector<float> weights;  // of the mesh's morph targets now; empty: the mesh's own
    Handle<Mesh> posed;          // the mesh as skin and weights deform it, set by SceneEdit::set_pose; none: as it is at rest
    uint32_t ray_mask = 0xFFu;   // rays see it if their mask, of 8 bits, shares one; renderers' rays have all of them
    InstanceOpacity opacity = InstanceOpacity::ByMaterial;
    Handle<Mesh> drawn_mesh() const { return posed ? posed : mesh; }
};

// True if the transform mirrors: front faces then wind clockwise (glTF 2.0, 3.7.4).
bool mirrors(const glm::mat4& world_from_object);
// False for singular or non-finite transforms: nothing of the instance can be seen.
bool drawable(const glm::mat4& world_from_object);
inline bool can_be_seen(const Placement& place) { return place.shown && drawable(place.world_from_object); }

// ---- animation ----

// glTF 2.0, 3.7.3.3: world_from_joint x inverse_bind takes a vertex of the mesh at rest to the world.
struct Skin {
    static constexpr std::string_view kTypeName = "skin";
    std::string name;
    std::vector<Handle<Node>> joints;
    std::vector<glm::mat4> inverse_bind;  // as many as joints
};

// Properties of a node, of a light, of a camera, in this order.
enum class AnimatedPath { Translation, Rotation, Scale, Weights, Visible, Color, Intensity, InnerCone, OuterCone, Yfov, Xmag, Ymag };
enum class AnimatedObject { Node, Light, Camera };
constexpr AnimatedObject object_of(AnimatedPath path) {
    return path < AnimatedPath::Color ? AnimatedObject::Node : path < AnimatedPath::Yfov ? AnimatedObject::Light : AnimatedObject::Camera;
}
enum class Interpolation { Step, Linear, CubicSpline };

// One property of one object over time (glTF 2.0, 3.11 and appendix C; KHR_animation_pointer).
struct AnimationChannel {
    Handle<Node> node;  // or `light` or `camera`: see object_of(path)
    AnimatedPath path = AnimatedPath::Translation;
    Interpolation interpolation = Interpolation::Linear;
    uint32_t width = 3;         // numbers a key: 3; rotation 4 (x, y, z, w); weights: the number of targets; of what is one number 1
    std::vector<float> times;   // seconds, increasing; not empty
    std::vector<float> values;  // width numbers a key; cubic spline: in-tangent, value, out-tangent of width numbers each
    Handle<Light> light;
    Handle<Camera> camera;
};

struct Animation {
    static constexpr std::string_view kTypeName = "animation";
    std::string name;
    std::vector<AnimationChannel> channels;
};

// ---- lights, cameras, environment ----

enum class LightKind { Directional, Point, Spot };

// KHR_lights_punctual. Stands at the origin of its placement and shines along its -Z; scale has no effect.
struct Light {
    static constexpr std::string_view kTypeName = "light";
    std::string name;
    LightKind kind = LightKind::Point;
    glm::vec3 color{1.0f};
    float intensity = 1.0f;                             // directional: lux on a surface that faces it; point, spot: candela
    float range = 0.0f;                                 // metres; 0: infinite
    float inner_cone = 0.0f, outer_cone = 0.78539816f;  // spot: half angles
    float angular_radius = 0.0f;                        // directional: 0 is a delta light
    Placement place;
};

enum class CameraKind { Perspective, Orthographic };

// Looks along the -Z of its placement with +Y up; scale has no effect.
struct Camera {
    static constexpr std::string_view kTypeName = "camera";
    std::string name;
    CameraKind kind = CameraKind::Perspective;
    float yfov = 0.8f;               // perspective: full vertical angle
    float xmag = 1.0f, ymag = 1.0f;  // orthographic: half extents in metres
    float near_plane = 0.01f;        // for depth values; rays start at the camera
    std::optional<float> far_plane;  // none: infinite
    Placement place;
};

// Radiance from infinitely far. Equirectangular: u = 0.5 is seen along -Z and grows to the right, v from +Y (0) to -Y (1).
// Nits along a direction are `scale` x the image, or `scale` alone where there is no image.
struct Environment {
    std::string name;
    uint32_t width = 0, height = 0;
    std::vector<glm::vec3> radiance;  // width * height, rows from the top, linear Rec. 709
    glm::vec3 scale{0.0f};            // 0: black
    float rotation = 0.0f;            // radians about +Y, counter-clockwise seen from above
    bool black() const { return scale == glm::vec3(0.0f); }
};

// Where a scene came from, for `parhelion info`.
struct SceneSource {
    std::string name;  // file or builtin:name
    std::string generator, copyright;
    std::vector<std::string> extensions_used, extensions_required;
    std::vector<std::string> extensions_not_drawn;  // used by the file, not (fully) in the picture
    std::vector<std::string> warnings;
    std::vector<std::string> variants;  // names of the material variants (KHR_materials_variants)
    uint64_t file_bytes = 0;  // all files that were read
};

}  // namespace parhelion
