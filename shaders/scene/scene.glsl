// Set 0: the scene. Bindings and accessors; the layout is gpu::SceneSet's.
#ifndef PARHELION_SCENE_SCENE_GLSL
#define PARHELION_SCENE_SCENE_GLSL
#include "lib/ray_cone.glsl"
#include "shared/scene.h"

#extension GL_EXT_nonuniform_qualifier : require

layout(set = 0, binding = 2, scalar) readonly buffer SceneBlock { SceneHeader header; } scene;
layout(set = 0, binding = 3) uniform sampler2D textures[];

// Of a shaded surface's material: a kernel that shades one class of materials defines the flags that it never has, and pays nothing for them.
#ifndef ABSENT_MATERIAL_FLAGS
#define ABSENT_MATERIAL_FLAGS 0u
#endif

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer InstanceArray { Instance v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer GeometryArray { Geometry v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer MaterialArray { Material v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer TextureArray { TextureEntry v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer EmitterArray { Emitter v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer AliasArray { AliasEntry v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer UintArray { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer PositionArray { vec3 v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer IndexArray { uvec3 v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer AttributeArray { VertexAttributes v[]; };

#define scene_instance(i) (InstanceArray(scene.header.instances).v[i])
#define scene_geometry(i) (GeometryArray(scene.header.geometries).v[i])
#define scene_material(i) (MaterialArray(scene.header.materials).v[i])
#define scene_texture(i) (TextureArray(scene.header.textures).v[i])
#define scene_emitter(i) (EmitterArray(scene.header.emitters).v[i])

// Geometry::flags of what a ray met.
uint scene_flags(uint instance, uint geometry) { return scene_geometry(scene_instance(instance).geometry_base + geometry).flags; }

vec2 transform_uv(TextureRef ref, vec2 uv) {
    precise const vec2 moved = vec2((ref.row0.x * uv.x + ref.row0.y * uv.y) + ref.row0.z, (ref.row1.x * uv.x + ref.row1.y * uv.y) + ref.row1.z);
    return moved;
}

// How finely textures are read at a surface: the level of a texture of one texel, by UV set (lib/ray_cone.glsl).
struct TextureFootprint {
    bool filtered;  // false: full resolution
    vec2 level;
};
const TextureFootprint kFullResolution = TextureFootprint(false, vec2(0.0));

// A texel of a material's texture; `fallback` where the material has none.
vec4 fetch_texture(TextureRef ref, vec2 uv0, vec2 uv1, TextureFootprint footprint, vec4 fallback) {
    if (ref.texture == kNone) return fallback;
    const TextureEntry entry = scene_texture(ref.texture);
    const vec2 uv = transform_uv(ref, ref.uv_set == 0u ? uv0 : uv1);
    if (!footprint.filtered) return textureLod(textures[nonuniformEXT(entry.slot)], uv, 0.0);
    const float area_scale = abs(ref.row0.x * ref.row1.y - ref.row0.y * ref.row1.x);
    const float level = texture_level(ref.uv_set == 0u ? footprint.level.x : footprint.level.y, float(entry.width), float(entry.height), area_scale);
    // A quarter of a level chooses between the two filters of a sampler that has no levels (Vulkan 1.3, VkSamplerCreateInfo).
    return textureLod(textures[nonuniformEXT(entry.slot)], uv, clamp(level, 0.0, max(float(entry.level_count) - 1.0, 0.25)));
}
vec4 fetch_texture(TextureRef ref, vec2 uv0, vec2 uv1, vec4 fallback) { return fetch_texture(ref, uv0, uv1, kFullResolution, fallback); }
#endif
