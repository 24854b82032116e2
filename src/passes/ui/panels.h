#pragma once
// Panels over a picture: triangles with a texture of letters, as user interface libraries give them.
#include <vector>

#include "frame/frame.h"

namespace parhelion::passes {

struct PanelVertex {
    float x, y;      // pixels of the target, from its upper left corner
    float u, v;      // in the font
    uint32_t color;  // display values, 8 bits each, red lowest, not premultiplied
};
struct PanelDraw {
    gpu::Rect clip;
    uint32_t first_index = 0, index_count = 0;
};
struct PanelMesh {
    std::vector<PanelVertex> vertices;
    std::vector<uint32_t> indices;  // three a triangle
    std::vector<PanelDraw> draws;   // in this order, over one another
};

// Draws the mesh over what `target` (rgba8) holds. `font`: coverage, r8. Needs DeviceCaps::raster.
void panels(Frame& frame, const gpu::Image& target, const gpu::Image& font, const PanelMesh& mesh);

}  // namespace parhelion::passes
