#pragma once
// How bright triangles show a texture: for choosing among lights by what they really emit.
#include <memory>
#include <vector>

#include "scene/types.h"

namespace parhelion {

// The luminance of tint x texture as the device reads it at full resolution: with the sampler's wrap modes, and its filter for
// magnification. Keeps four bytes a texel while it lives; of a mirrored axis, twice the texels.
class ShownTexture {
public:
    ShownTexture(const Image& image, const Texture& texture, glm::vec3 tint);
    ~ShownTexture();

    // Mean over the triangle with these UVs (the TextureRef's transform done), by exact coverage of the filter's cells, however many
    // they are. It is 0 just if every texel that the filter can reach is black. Otherwise it is at least as much as if the brightest
    // of them were seen on 1/256 of a texel (of the triangle, where that is smaller), so that no triangle that can shine is lost.
    // Texels count as within reach up to 1/64 of a texel, and `uv_error`, beside the triangle. `steps`: the work that may be done,
    // about one a row and column of texels; it is taken off. Where that is too little, the mean is that of the whole texture.
    double mean(glm::dvec2 a, glm::dvec2 b, glm::dvec2 c, double uv_error, double& steps) const;

    // The same for each triangle of a primitive, with the rounding of its UVs, on all cores. Steps suffice for a million triangles of 67
    // rows and columns each, and for more of fewer; a mesh in which each repeats a texture a thousand times takes seconds, not hours.
    std::vector<float> means(const Primitive& primitive, const TextureRef& ref) const;

private:
    struct Texels;
    std::unique_ptr<const Texels> texels_;
};

}  // namespace parhelion
