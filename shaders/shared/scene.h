// The scene as every shader sees it: one header block with addresses, and the structs they point to.
#ifndef PARHELION_SHARED_SCENE_H
#define PARHELION_SHARED_SCENE_H
#include "shared/types.h"
SHARED_BEGIN

SHARED_CONST uint kNone = 0xFFFFFFFFu;

// Instance::flags
SHARED_CONST uint kInstanceFlipsFacing = 1u;  // the transform mirrors: front and back faces change places
SHARED_CONST uint kInstanceDeforms = 2u;

// Geometry::flags and Material::flags (alpha mode in the two lowest bits)
SHARED_CONST uint kAlphaOpaque = 0u;
SHARED_CONST uint kAlphaMask = 1u;
SHARED_CONST uint kAlphaBlend = 2u;
SHARED_CONST uint kAlphaModeMask = 3u;
SHARED_CONST uint kMaterialDoubleSided = 4u;
SHARED_CONST uint kMaterialUnlit = 8u;

// A row-major 3x4 affine transform: column vectors, p' = (dot(row0, vec4(p, 1)), ...).
struct Affine {
    vec4 row0, row1, row2;
};

struct Instance {
    Affine world_from_object;
    Affine object_from_world;
    Affine world_from_object_before;  // previous frame
    uint geometry_base;               // first of its mesh's geometries in the geometry table
    uint geometry_count;
    uint emitter_base;  // first of its geometries' entries in the geometry-to-emitter table
    uint flags;
    uint bottom_root;   // own BVH: root node of its mesh in the node array
    uint mask;
};

// One primitive of a glTF mesh. All addresses are device addresses; strides are fixed.
struct Geometry {
    uint64_t positions;   // vec3[vertex_count], object space
    uint64_t indices;     // uvec3[triangle_count]
    uint64_t attributes;  // VertexAttributes[vertex_count]
    uint triangle_count;
    uint vertex_count;
    uint material;
    uint flags;
    uint triangle_table;  // emissive: offset of its triangle alias table, kNone otherwise
    uint triangle_base;   // index of its first triangle among the mesh's triangles
};

struct VertexAttributes {
    vec3 normal;    // object space, unit
    vec4 tangent;   // object space, handedness in w
    vec2 uv0, uv1;
    uint color;     // RGBA8 unorm, linear
};

// A texture reference: slot of the texture table (kNone: constant 1), which UV set, and KHR_texture_transform as 2x3 rows.
struct TextureRef {
    uint texture;
    uint uv_set;
    vec3 row0, row1;  // uv' = (dot(row0, vec3(uv, 1)), dot(row1, vec3(uv, 1)))
};

struct Material {
    vec4 base_color;  // linear, alpha in w
    vec3 emission;    // nits: factor x strength
    float metallic;
    float roughness;  // perceptual; alpha = roughness^2
    float normal_scale;
    float alpha_cutoff;
    float ior;
    float transmission;
    uint flags;
    TextureRef base_color_texture, metal_rough_texture, normal_texture, emissive_texture;
};

SHARED_END
#endif
