// Makes the shared headers valid C++20 and GLSL 4.60 at once. All blocks are `layout(scalar)`: natural C++ layout, no padding.
// No bool and no mat3 in shared structs; 64-bit members first.
#ifndef PARHELION_SHARED_TYPES_H
#define PARHELION_SHARED_TYPES_H
#ifdef __cplusplus
#include <cstdint>

#include <glm/glm.hpp>

#define SHARED_BEGIN namespace parhelion::shared {
#define SHARED_END }
#define SHARED_CONST constexpr
namespace parhelion::shared {
using glm::ivec2;
using glm::u64vec2;
using glm::uvec2;
using glm::uvec3;
using glm::uvec4;
using glm::vec2;
using glm::vec3;
using glm::vec4;
using uint = uint32_t;
}  // namespace parhelion::shared
#else
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference2 : require
#extension GL_EXT_buffer_reference_uvec2 : require
#define SHARED_BEGIN
#define SHARED_END
#define SHARED_CONST const
#endif
#endif
