#pragma once
// The world cache's options, for the layers above the renderers.
#include "scene_gpu/light_cache.h"
