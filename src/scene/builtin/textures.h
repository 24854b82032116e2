#pragma once
// Pictures made by code for built-in scenes. Colours are given as sRGB values in [0, 1], as they are stored.
#include <functional>
#include <string>

#include "scene/edit.h"

namespace parhelion::builtin {

// Row by row from the top; `pixel` gets the texel's middle, (0, 0) being the upper left corner. Called from several threads.
using PixelFunction = std::function<glm::vec4(float u, float v)>;
Image make_image(std::string name, uint32_t width, uint32_t height, const PixelFunction& pixel);

// The normal map of a height field that repeats over [0, 1]^2: `metres` says how wide the image is, heights are in metres.
Image make_normal_image(std::string name, uint32_t size, float metres, const std::function<float(float u, float v)>& height);

TextureRef add_texture(SceneEdit& edit, Image image, ColorSpace space, const Sampler& sampler = {});

// Value noise in [0, 1] on a lattice of one point per unit that repeats after `period` points, smooth by a quintic; `octaves` of it
// add up, each half as high and twice as fine (Perlin, "Improving Noise", 2002, gives the quintic).
float value_noise(glm::vec2 p, glm::ivec2 period, uint32_t seed);
float fractal_noise(glm::vec2 p, glm::ivec2 period, uint32_t octaves, uint32_t seed);

// A surface's maps: colour, normals, and roughness in green with metallic in blue.
struct SurfaceMaps {
    TextureRef color, normal, metal_rough;
};
SurfaceMaps add_plank_floor(SceneEdit& edit);                                                     // 2.4 m wide; planks along u
SurfaceMaps add_wood(SceneEdit& edit, glm::vec3 light, glm::vec3 dark, const std::string& name);  // 0.6 m wide, grain along u
TextureRef add_rug(SceneEdit& edit);                                                              // one rug
TextureRef add_painting(SceneEdit& edit);                                                         // a landscape, 4 : 3
SurfaceMaps add_plaster(SceneEdit& edit, glm::vec3 color);                                        // 1.2 m wide
SurfaceMaps add_weave(SceneEdit& edit, glm::vec3 color, const std::string& name);                 // 0.16 m wide
TextureRef add_book_spines(SceneEdit& edit);                                           // kSpines columns side by side, the last is paper
TextureRef add_broad_leaf(SceneEdit& edit, glm::vec3 color, const std::string& name);  // alpha
TextureRef add_twig(SceneEdit& edit);                                                  // a twig with many small leaves; alpha
TextureRef add_bark(SceneEdit& edit);                                                 // 1 m wide, grain along v
TextureRef add_smudges(SceneEdit& edit);                                               // metal_rough: roughness varies, metallic 1
constexpr uint32_t kSpines = 16;

}  // namespace parhelion::builtin
