// Noise, and images of functions.
#include <cmath>

#include "base/parallel.h"
#include "scene/builtin/random.h"
#include "scene/builtin/textures.h"

namespace parhelion::builtin {

Image make_image(std::string name, uint32_t width, uint32_t height, const PixelFunction& pixel) {
    Image image{.name = std::move(name), .width = width, .height = height};
    image.texels.resize(size_t(width) * height * 4);
    parallel_for(height, 16, [&](size_t begin, size_t end) {
        for (size_t y = begin; y < end; ++y)
            for (uint32_t x = 0; x < width; ++x) {
                const glm::vec4 value = glm::clamp(pixel((float(x) + 0.5f) / float(width), (float(y) + 0.5f) / float(height)), 0.0f, 1.0f);
                for (int c = 0; c < 4; ++c)
                    image.texels[(y * width + x) * 4 + size_t(c)] = static_cast<uint8_t>(std::lround(value[c] * 255.0f));
            }
    });
    return image;
}

Image make_normal_image(std::string name, uint32_t size, float metres, const std::function<float(float u, float v)>& height) {
    std::vector<float> heights(size_t(size) * size);
    parallel_for(size, 16, [&](size_t begin, size_t end) {
        for (size_t y = begin; y < end; ++y)
            for (uint32_t x = 0; x < size; ++x)
                heights[y * size + x] = height((float(x) + 0.5f) / float(size), (float(y) + 0.5f) / float(size));
    });
    const float step = 2.0f * metres / float(size);
    return make_image(std::move(name), size, size, [&, size](float u, float v) {
        const uint32_t x = std::min(uint32_t(u * float(size)), size - 1), y = std::min(uint32_t(v * float(size)), size - 1);
        const auto at = [&](uint32_t i, uint32_t j) { return heights[size_t(j % size) * size + i % size]; };
        // glTF: green points up in the image, against v.
        const glm::vec3 n = glm::normalize(glm::vec3(at(x + size - 1, y) - at(x + 1, y), at(x, y + 1) - at(x, y + size - 1), step));
        return glm::vec4(0.5f * n + 0.5f, 1.0f);
    });
}

TextureRef add_texture(SceneEdit& edit, Image image, ColorSpace space, const Sampler& sampler) {
    const std::string name = image.name;
    const Handle<Image> handle = edit.add(std::move(image));
    return {.texture = edit.add(Texture{.name = name, .image = handle, .sampler = sampler, .color_space = space})};
}

float value_noise(glm::vec2 p, glm::ivec2 period, uint32_t seed) {
    const glm::vec2 cell = glm::floor(p), f = p - cell;
    const glm::vec2 s = f * f * f * (f * (f * 6.0f - 15.0f) + 10.0f);
    const auto wrap = [](int i, int n) { return uint32_t(i >= 0 ? i % n : n - 1 - (-1 - i) % n); };
    const uint32_t x0 = wrap(int(cell.x), period.x), x1 = x0 + 1 == uint32_t(period.x) ? 0 : x0 + 1;
    const uint32_t y0 = wrap(int(cell.y), period.y), y1 = y0 + 1 == uint32_t(period.y) ? 0 : y0 + 1;
    const uint32_t row0 = hash_u32(y0 ^ seed * 0x9e3779b9u), row1 = hash_u32(y1 ^ seed * 0x9e3779b9u);
    const auto at = [](uint32_t x, uint32_t row) { return float(hash_u32(x + row) >> 8) * 0x1p-24f; };
    return glm::mix(glm::mix(at(x0, row0), at(x1, row0), s.x), glm::mix(at(x0, row1), at(x1, row1), s.x), s.y);
}

float fractal_noise(glm::vec2 p, glm::ivec2 period, uint32_t octaves, uint32_t seed) {
    float sum = 0.0f, weight = 0.0f, height = 1.0f;
    for (uint32_t octave = 0; octave < octaves; ++octave) {
        sum += height * value_noise(p, period, seed + 131u * octave);
        weight += height;
        height *= 0.5f;
        p *= 2.0f;
        period *= 2;
    }
    return sum / weight;
}

}  // namespace parhelion::builtin
