// Surfaces that a pixel is followed through: exact mirrors of metal, which have one lobe, and panes. What is seen there stands in their place
// for whatever is divided by a surface's colours, compared and filtered ("primary surface replacement").
#ifndef PARHELION_SCENE_FOLLOW_GLSL
#define PARHELION_SCENE_FOLLOW_GLSL
#include "scene/panes.glsl"

bool is_mirror(Surface s) { return (scene_material(s.material).flags & kMaterialMirror) != 0u && s.scattering.metallic >= 1.0 && s.scattering.roughness < kDeltaRoughness; }

bool is_followed(Surface s) { return is_mirror(s) || (kLayers && is_pane(s.scattering)); }
#endif
