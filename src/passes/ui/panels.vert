#version 460
// Corners of panels. Reads: vertices, indices. Writes: position, place in the font, colour.
#extension GL_GOOGLE_include_directive : require
#include "shared/types.h"

struct PanelVertex {
    vec2 position_px, uv;
    uint color;
};
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer PanelVertices { PanelVertex v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer PanelIndices { uint v[]; };
layout(push_constant, scalar) uniform Push {
    PanelVertices vertices;
    PanelIndices indices;
    vec2 clip_from_px;
} push;

layout(location = 0) out vec2 uv;
layout(location = 1) out vec4 tint;

void main() {
    const PanelVertex vertex = push.vertices.v[push.indices.v[gl_VertexIndex]];
    uv = vertex.uv;
    tint = unpackUnorm4x8(vertex.color);
    gl_Position = vec4(vertex.position_px * push.clip_from_px - 1.0, 0.0, 1.0);
}
