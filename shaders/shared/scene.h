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
SHARED_CONST uint kMaterialTransmits = 16u;  // light goes through it: never culled
SHARED_CONST uint kMaterialThin = 32u;       // it transmits without enclosing a volume: a wall without thickness
SHARED_CONST uint kMaterialCoated = 64u;
SHARED_CONST uint kMaterialSheen = 128u;
SHARED_CONST uint kMaterialOnlyEmits = 256u;  // no light is reflected or let through
SHARED_CONST uint kMaterialMirror = 512u;     // metal without roughness: one lobe, where its textures leave it so

// Below this perceptual roughness surfaces are exact mirrors and clear glass: GGX lobes with alpha < 0.0009 are narrower than a pixel.
SHARED_CONST float kDeltaRoughness = 0.03f;

// SceneHeader::features: what some material of the scene has, and whether some geometry has a proxy.
SHARED_CONST uint kSceneLayers = 1u;  // transmission, a clear coat or sheen: path tracers need their variant LAYERS
SHARED_CONST uint kScenePanes = 2u;   // thin-walled transmission: shadow rays may pass
SHARED_CONST uint kSceneTransmits = 4u;
SHARED_CONST uint kSceneCoats = 8u;     // a clear coat or sheen on what does not transmit
SHARED_CONST uint kSceneEmitters = 16u; // kMaterialOnlyEmits
SHARED_CONST uint kSceneMirrors = 32u;  // kMaterialMirror
SHARED_CONST uint kSceneProxies = 64u;  // rays meet proxies of some geometries (Geometry::proxy_heights)

// A row-major 3x4 affine transform: column vectors, p' = (dot(row0, vec4(p, 1)), ...).
struct Affine {
    vec4 row0, row1, row2;
};

struct Instance {
    Affine world_from_object;
    Affine object_from_world;
    Affine world_from_object_before;  // previous frame
    uint geometry_base;               // first of its mesh's geometries in the geometry table
    uint geometry_base_before;        // the same of the mesh as it was deformed in the previous frame: equal vertices, triangles of other positions
    uint geometry_count;
    uint emitter_base;  // first of its geometries' entries in the geometry-to-emitter table
    uint flags;
    uint mask;
};

// One primitive of a glTF mesh. All addresses are device addresses; strides are fixed.
struct Geometry {
    uint64_t positions;   // vec3[vertex_count], object space
    uint64_t indices;     // uvec3[triangle_count]
    uint64_t attributes;  // VertexAttributes[vertex_count]
    // uint[triangle_count]: how far the proxy rises over each triangle (scene/proxy.glsl). Rays then meet the proxy's triangles alone, which
    // follow these in `indices`; raster passes draw these. 0: there is no proxy.
    uint64_t proxy_heights;
    uint triangle_count;
    uint vertex_count;
    uint material;
    uint flags;
    uint triangle_table;  // emissive: offset of its triangle alias table, kNone otherwise
};

struct VertexAttributes {
    vec3 normal;    // object space, unit
    vec4 tangent;   // object space, handedness in w
    vec2 uv0, uv1;
    uint color;     // RGBA8 unorm, linear
};

// One texture of the scene: where it lies now. Materials name it by its row, so that it can move without their being touched.
struct TextureEntry {
    uint slot;           // of the texture array in set 0
    uint width, height;  // of its finest level, texels
    uint level_count;    // that may be read: 1 where the sampler has no mip levels
};

// A texture reference: row of the texture table (kNone: constant 1), which UV set, and KHR_texture_transform as 2x3 rows.
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
    float specular;  // KHR_materials_specular; 0: a pure Lambert surface
    vec3 specular_color;
    uint flags;
    vec3 absorption;  // of the volume that it encloses, 1/m
    int priority;     // of that volume where several overlap: the highest is there
    float coat, coat_roughness, coat_normal_scale;
    vec3 sheen_color;
    float sheen_roughness;
    TextureRef base_color_texture, metal_rough_texture, normal_texture, emissive_texture;
    TextureRef specular_texture, specular_color_texture;
    TextureRef transmission_texture;
    TextureRef coat_texture, coat_roughness_texture, coat_normal_texture;
    TextureRef sheen_color_texture, sheen_roughness_texture;
};

// Emitter::kind
SHARED_CONST uint kEmitterMesh = 0u;         // emissive triangles of one instance's geometry
SHARED_CONST uint kEmitterPoint = 1u;
SHARED_CONST uint kEmitterSpot = 2u;
SHARED_CONST uint kEmitterDirectional = 3u;  // infinitely far; a disk of uniform radiance, or a delta light
SHARED_CONST uint kEmitterEnvironment = 4u;

// The top level of the light table. Light ids are (emitter, triangle).
struct Emitter {
    uint kind;
    uint instance;        // mesh
    uint geometry;        // mesh: index in the geometry table
    uint triangle_count;  // mesh
    uint triangle_table;  // mesh: offset of its AliasEntry rows
    vec3 position_ws;     // point, spot: metres
    vec3 direction_ws;    // spot, directional: where the light goes, unit
    vec3 intensity;       // point, spot: candela; directional: lux on a surface that faces it
    float cos_inner, cos_outer;
    float opening;        // directional: 1 - cos of its angular radius; 0: a delta light
};

// One row of an alias table (Vose 1991): a bin keeps itself with `probability`, else gives `alias`; `pmf` is its own share.
struct AliasEntry {
    float probability;
    uint alias;
    float pmf;
};

// Equirectangular environment: u grows with the azimuth, v from +Y (0) to -Y (1). Radiance is the bilinear texture times
// `scale`; the alias table has `table_width` x `table_height` cells, each a rectangle in (azimuth, cosine of the polar angle).
struct Environment {
    vec3 scale;
    uint texture;  // slot, kNone: constant radiance `scale`
    float rotation_sin, rotation_cos;
    uint table_width, table_height;
    uint emitter;  // its row in the emitter table, kNone: black
};

struct SceneHeader {
    uint64_t instances;          // Instance[]
    uint64_t geometries;         // Geometry[]
    uint64_t materials;          // Material[]
    uint64_t textures;           // TextureEntry[]
    uint64_t geometry_emitters;  // uint[]: emitter of (instance.emitter_base + geometry of the mesh), kNone if it does not emit
    uint64_t emitters;           // Emitter[]
    uint64_t emitter_table;      // AliasEntry[emitter_count]
    uint64_t triangle_tables;    // AliasEntry[], one table per emissive geometry, in object space
    uint64_t environment_table;  // AliasEntry[table_width * table_height], their pmf a density per solid angle
    uint64_t bottom_nodes;       // own BVH (shared/bvh.h): nodes
    uint64_t bottom_triangles;   // BvhTriangle[]
    uint64_t top_nodes, top_items;                // nodes, BvhTopItem[]
    uint64_t top_nodes_before, top_items_before;  // of the previous frame
    uint64_t sobol;              // uint[kSobolDimensions * 32]
    uint64_t blue_noise;         // uint[128 * 128 / 2], two 16-bit ranks a word
    uint64_t bsdf_tables;        // directional albedos (lib/bsdf_tables.glsl)
    uint64_t suns;               // uint[sun_count]: emitters that are disks at infinity, which rays can meet
    uint64_t instance_before_of_now;  // uint[]: by row, what was the previous frame's; kNone: it is new; 0: all rows are what they were (scene/previous.glsl)
    uint64_t emitter_now_of_before;   // uint[emitter_before_count]: by the previous frame's row; kNone: it is gone; 0: likewise
    uint64_t emitter_lit_before;      // float[emitter_count]: radiance of the previous frame over now's, 0 of those that were elsewhere; none: all shine as they did
    uint instance_before_count;  // rows of the previous frame; 0: there was none
    uint emitter_before_count;
    uint moving;                 // 0: nothing has moved since the previous frame, whatever the rows of instances say
    uint emitter_count;
    uint sun_count;
    uint culling;                // 1: single-sided surfaces that do not transmit are invisible from behind
    uint features;               // kScene...
    Environment environment;
};

SHARED_END
#endif
