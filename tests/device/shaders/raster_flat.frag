#version 460
// Reads: nothing. Writes: colors, rows (which instance, whether seen from the front).
// variants: COLOR_ONLY
layout(location = 0) flat in vec4 color;
layout(location = 1) flat in uint row;
layout(location = 0) out vec4 colors;
#ifndef COLOR_ONLY
layout(location = 1) out uvec4 rows;
#endif

void main() {
    colors = color;
#ifndef COLOR_ONLY
    rows = uvec4(row, uint(gl_FrontFacing), 0u, 1u);
#endif
}
