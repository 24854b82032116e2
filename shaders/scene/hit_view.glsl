// The view as hit and miss shaders see it that shade: a pass that lets them begins its push constants with the view's address.
#ifndef PARHELION_SCENE_HIT_VIEW_GLSL
#define PARHELION_SCENE_HIT_VIEW_GLSL
#include "shared/view.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ViewBlock { ViewData data; };
layout(push_constant, scalar) uniform Push { ViewBlock view; } push;
#endif
