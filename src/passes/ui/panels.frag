#version 460
// Panels and their letters, blended as display values. Reads: font (coverage). Writes: color.
layout(set = 1, binding = 0) uniform sampler2D font;
layout(location = 0) in vec2 uv;
layout(location = 1) in vec4 tint;
layout(location = 0) out vec4 color;

void main() { color = vec4(tint.rgb, tint.a * textureLod(font, uv, 0.0).r); }
