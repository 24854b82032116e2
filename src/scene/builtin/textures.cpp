// Patterns of the built-in scenes' textures; the noise and the images under them are in noise.cpp.
#include "scene/builtin/textures.h"

#include <cmath>
#include <numbers>

#include "scene/builtin/random.h"
#include "scene/builtin/scenes.h"

namespace parhelion::builtin {

namespace {

const Sampler kClamp{.wrap_u = Wrap::ClampToEdge, .wrap_v = Wrap::ClampToEdge};

float fraction(float x) { return x - std::floor(x); }
float hashed(int x, int y, uint32_t seed) { return float(hash_u32(uint32_t(x), hash_u32(uint32_t(y), seed)) >> 8) * 0x1p-24f; }
glm::vec4 opaque(glm::vec3 color) { return glm::vec4(color, 1.0f); }
// 1 inside |x| < width, 0 outside, with a soft rim.
float band(float x, float width, float soft) { return 1.0f - glm::smoothstep(width - soft, width + soft, std::abs(x)); }

// Grain of wood along u: rings that wander, and fine fibres. p in metres of a board, `repeat` metres wide.
float wood_grain(glm::vec2 p, float repeat, uint32_t seed) {
    const glm::ivec2 coarse(int(repeat * 5.0f), int(repeat * 40.0f)), fine(int(repeat * 15.0f), int(repeat * 500.0f));
    const float wander = fractal_noise(p * glm::vec2(coarse) / repeat, coarse, 3, seed);
    const float rings = 0.5f + 0.5f * std::sin(float(kTurn) * 5.0f * wander);
    return 0.45f * wander + 0.2f * rings + 0.35f * fractal_noise(p * glm::vec2(fine) / repeat, fine, 2, seed + 7u);
}

struct Plank {
    int row = 0, number = 0;
    float edge = 0.0f;  // metres to its nearest edge
};
constexpr float kFloorWidth = 2.4f, kPlankWidth = 0.15f;
constexpr int kPlankRows = 16;

// Three planks to a row, every row shifted by a random length.
Plank plank_at(float u, float v) {
    Plank plank;
    const float y = v * kPlankRows;
    plank.row = std::min(int(y), kPlankRows - 1);
    const float x = fraction(u + hashed(plank.row, 3, 11u)) * 3.0f;
    plank.number = std::min(int(x), 2);
    const float across = std::min(fraction(y), 1.0f - fraction(y)) * kPlankWidth,
                along = std::min(fraction(x), 1.0f - fraction(x)) * kFloorWidth / 3.0f;
    plank.edge = std::min(across, along);
    return plank;
}

float plank_grain(float u, float v, const Plank& plank) {
    const uint32_t seed = uint32_t(plank.row * 3 + plank.number);
    return wood_grain({u * kFloorWidth, v * kFloorWidth}, kFloorWidth, 100u + seed);
}

}  // namespace

SurfaceMaps add_plank_floor(SceneEdit& edit) {
    SurfaceMaps maps;
    maps.color = add_texture(edit,
                             make_image("oak planks", 1024, 1024,
                                        [](float u, float v) {
                                            const Plank plank = plank_at(u, v);
                                            const float tone = hashed(plank.row, plank.number, 5u), grain = plank_grain(u, v, plank);
                                            glm::vec3 color = glm::mix(glm::vec3(0.40f, 0.25f, 0.14f), glm::vec3(0.68f, 0.48f, 0.30f),
                                                                       glm::clamp(1.25f * grain - 0.05f, 0.0f, 1.0f));
                                            color *= 0.82f + 0.3f * tone;
                                            return opaque(color * glm::mix(0.35f, 1.0f, glm::smoothstep(0.0005f, 0.003f, plank.edge)));
                                        }),
                             ColorSpace::Srgb);
    maps.normal = add_texture(edit,
                              make_normal_image("oak planks normals", 1024, kFloorWidth,
                                                [](float u, float v) {
                                                    const Plank plank = plank_at(u, v);
                                                    const float tilt = 0.0006f * hashed(plank.row, plank.number, 9u);
                                                    return tilt + 0.0025f * glm::smoothstep(0.0f, 0.006f, plank.edge) +
                                                           0.0004f * plank_grain(u, v, plank);
                                                }),
                              ColorSpace::Linear);
    maps.metal_rough =
        add_texture(edit,
                    make_image("oak planks roughness", 512, 512,
                               [](float u, float v) {
                                   const Plank plank = plank_at(u, v);
                                   const float worn = fractal_noise({u * 12.0f, v * 12.0f}, {12, 12}, 4, 21u);
                                   return glm::vec4(1.0f, 0.3f + 0.3f * worn + 0.15f * hashed(plank.row, plank.number, 6u), 0.0f, 1.0f);
                               }),
                    ColorSpace::Linear);
    return maps;
}

SurfaceMaps add_wood(SceneEdit& edit, glm::vec3 light, glm::vec3 dark, const std::string& name) {
    const auto grain = [](float u, float v) { return wood_grain({0.6f * u, 0.6f * v}, 0.6f, 31u); };
    SurfaceMaps maps;
    maps.color = add_texture(
        edit,
        make_image(name, 512, 512,
                   [=](float u, float v) { return opaque(glm::mix(dark, light, glm::clamp(1.3f * grain(u, v) - 0.1f, 0.0f, 1.0f))); }),
        ColorSpace::Srgb);
    maps.normal = add_texture(
        edit, make_normal_image(name + " normals", 256, 0.6f, [=](float u, float v) { return 0.0006f * grain(u, v); }), ColorSpace::Linear);
    maps.metal_rough = add_texture(edit,
                                   make_image(name + " roughness", 128, 128,
                                              [=](float u, float v) { return glm::vec4(1.0f, 0.55f - 0.2f * grain(u, v), 0.0f, 1.0f); }),
                                   ColorSpace::Linear);
    return maps;
}

// A kilim: steps of a coarse grid of knots, mirrored in both directions.
TextureRef add_rug(SceneEdit& edit) {
    const glm::vec3 red(0.56f, 0.17f, 0.13f), navy(0.13f, 0.18f, 0.28f), cream(0.85f, 0.77f, 0.62f), gold(0.76f, 0.53f, 0.24f),
        teal(0.22f, 0.42f, 0.42f);
    const auto pixel = [=](float u, float v) {
        constexpr float kAcross = 120.0f, kDown = 80.0f;
        const glm::vec2 knot(std::floor(u * kAcross), std::floor(v * kDown));
        const glm::vec2 p(std::abs(knot.x + 0.5f - 0.5f * kAcross), std::abs(knot.y + 0.5f - 0.5f * kDown));
        const float rim = std::min(0.5f * kAcross - p.x, 0.5f * kDown - p.y);
        glm::vec3 color = red;
        const float diamond = p.x * 0.62f + p.y;
        if (rim < 2.0f) {
            color = navy;
        } else if (rim < 4.0f) {
            color = gold;
        } else if (rim < 11.0f) {
            // Triangles in a row.
            const float along = 0.5f * kAcross - p.x < 0.5f * kDown - p.y ? p.y : p.x;
            color = std::abs(std::fmod(along, 12.0f) - 6.0f) > rim - 4.5f ? navy : cream;
        } else if (rim < 13.0f) {
            color = teal;
        } else {
            const float ring = std::fmod(diamond, 17.0f);
            if (diamond < 6.0f)
                color = cream;
            else if (diamond < 17.0f)
                color = navy;
            else if (ring < 3.0f)
                color = gold;
            else if (ring < 6.0f)
                color = diamond < 30.0f ? cream : teal;
            else if (std::fmod(p.x, 10.0f) < 3.0f && std::fmod(p.y, 10.0f) < 3.0f)
                color = cream;
        }
        // Threads, and wool that took the dye unevenly.
        const float thread = 0.5f + 0.5f * std::sin(float(kTurn) * v * 320.0f) * std::sin(float(kTurn) * u * 240.0f);
        const float dye = fractal_noise({u * 6.0f, v * 40.0f}, {6, 40}, 4, 41u);
        return opaque(color * (0.72f + 0.14f * thread + 0.26f * dye));
    };
    return add_texture(edit, make_image("kilim", 1024, 768, pixel), ColorSpace::Srgb, kClamp);
}

// Hills behind hills towards an evening sun over a lake.
TextureRef add_painting(SceneEdit& edit) {
    const auto pixel = [](float u, float v) {
        glm::vec3 color =
            glm::mix(glm::vec3(0.40f, 0.58f, 0.76f), glm::vec3(1.0f, 0.84f, 0.60f), std::pow(glm::clamp(v / 0.6f, 0.0f, 1.0f), 1.3f));
        const float sun = std::hypot((u - 0.64f) * 1.33f, v - 0.42f);
        color = glm::mix(color, glm::vec3(1.0f, 0.93f, 0.72f), band(sun, 0.065f, 0.006f) + 0.5f * std::exp(-sun * 7.0f));
        const float cloud = fractal_noise({u * 6.0f, v * 22.0f}, {6, 22}, 4, 51u);
        color =
            glm::mix(color, glm::vec3(0.96f, 0.66f, 0.56f), 0.6f * glm::smoothstep(0.52f, 0.75f, cloud) * glm::smoothstep(0.55f, 0.2f, v));
        const glm::vec3 hills[4] = {{0.66f, 0.64f, 0.72f}, {0.50f, 0.56f, 0.62f}, {0.36f, 0.50f, 0.46f}, {0.27f, 0.38f, 0.26f}};
        for (int i = 0; i < 4; ++i) {
            const float line = 0.47f + 0.07f * float(i) -
                               0.16f * (fractal_noise({u * float(2 + i) + 3.7f * float(i), 0.5f}, {64, 1}, 4, 60u + uint32_t(i)) - 0.5f) *
                                   (1.0f + 0.4f * float(i));
            if (v > line) color = glm::mix(hills[i], hills[i] * 0.8f, glm::clamp((v - line) * 4.0f, 0.0f, 1.0f));
        }
        if (v > 0.76f) {
            const float ripple = fractal_noise({u * 9.0f, v * 90.0f}, {9, 90}, 3, 71u);
            color = glm::mix(glm::vec3(0.30f, 0.42f, 0.50f), glm::vec3(0.98f, 0.80f, 0.55f),
                             glm::smoothstep(0.45f, 0.75f, ripple) * band(u - 0.64f, 0.10f + 0.5f * (v - 0.76f), 0.08f));
        }
        // Strokes of the brush.
        return opaque(color * (0.9f + 0.2f * fractal_noise({u * 60.0f + 3.0f * v, v * 90.0f}, {60, 90}, 3, 81u)));
    };
    return add_texture(edit, make_image("painting", 512, 384, pixel), ColorSpace::Srgb, kClamp);
}

SurfaceMaps add_plaster(SceneEdit& edit, glm::vec3 color) {
    SurfaceMaps maps;
    maps.color = add_texture(
        edit,
        make_image("plaster", 512, 512,
                   [=](float u, float v) { return opaque(color * (0.9f + 0.2f * fractal_noise({u * 5.0f, v * 5.0f}, {5, 5}, 6, 91u))); }),
        ColorSpace::Srgb);
    maps.normal =
        add_texture(edit,
                    make_normal_image("plaster normals", 512, 1.2f,
                                      [](float u, float v) { return 0.004f * fractal_noise({u * 14.0f, v * 14.0f}, {14, 14}, 5, 92u); }),
                    ColorSpace::Linear);
    return maps;
}

SurfaceMaps add_weave(SceneEdit& edit, glm::vec3 color, const std::string& name) {
    constexpr float kThreads = 24.0f;
    // Over one, under one: the thread on top bulges.
    const auto height = [](float u, float v) {
        const float x = u * kThreads, y = v * kThreads;
        const bool over = (int(x) + int(y)) % 2 == 0;
        const float along = fraction(over ? x : y), across = fraction(over ? y : x);
        return std::sin(float(kTurn) * 0.5f * across) * (0.6f + 0.4f * std::sin(float(kTurn) * 0.5f * along));
    };
    SurfaceMaps maps;
    maps.color = add_texture(edit,
                             make_image(name, 256, 256,
                                        [=](float u, float v) {
                                            const float fibre = fractal_noise({u * 32.0f, v * 32.0f}, {32, 32}, 3, 95u);
                                            return opaque(color * (0.68f + 0.25f * height(u, v) + 0.2f * fibre));
                                        }),
                             ColorSpace::Srgb);
    maps.normal =
        add_texture(edit, make_normal_image(name + " normals", 256, 0.16f, [=](float u, float v) { return 0.0016f * height(u, v); }),
                    ColorSpace::Linear);
    return maps;
}

TextureRef add_book_spines(SceneEdit& edit) {
    const auto pixel = [](float u, float v) {
        static const glm::vec3 kCovers[kSpines - 1] = {
            {0.50f, 0.13f, 0.12f}, {0.12f, 0.22f, 0.36f}, {0.16f, 0.33f, 0.24f}, {0.77f, 0.62f, 0.36f}, {0.30f, 0.18f, 0.13f},
            {0.83f, 0.78f, 0.68f}, {0.16f, 0.38f, 0.42f}, {0.72f, 0.36f, 0.17f}, {0.26f, 0.20f, 0.34f}, {0.60f, 0.24f, 0.26f},
            {0.18f, 0.18f, 0.20f}, {0.45f, 0.50f, 0.36f}, {0.35f, 0.45f, 0.56f}, {0.70f, 0.52f, 0.42f}, {0.55f, 0.43f, 0.20f}};
        const int spine = std::min(int(u * kSpines), int(kSpines) - 1);
        const float x = fraction(u * kSpines), cloth = fractal_noise({u * 128.0f, v * 96.0f}, {128, 96}, 3, 101u);
        if (spine == int(kSpines) - 1)
            return opaque(glm::vec3(0.90f, 0.85f, 0.74f) * (0.82f + 0.25f * value_noise({u * 700.0f, v * 3.0f}, {700, 3}, 102u)));
        glm::vec3 color = kCovers[spine] * (0.88f + 0.24f * cloth);
        const glm::vec3 foil = spine % 3 == 1             ? glm::vec3(0.86f, 0.84f, 0.78f)
                               : spine == 3 || spine == 5 ? glm::vec3(0.30f, 0.16f, 0.12f)
                                                          : glm::vec3(0.86f, 0.68f, 0.34f);
        const float top = 0.08f + 0.05f * hashed(spine, 1, 103u);
        float print = band(v - top, 0.006f, 0.002f) + band(v - (1.0f - top), 0.006f, 0.002f) + band(v - top - 0.025f, 0.003f, 0.002f);
        // A title in letters that nobody can read.
        const float y0 = 0.2f + 0.1f * hashed(spine, 2, 104u), y1 = y0 + 0.25f + 0.2f * hashed(spine, 3, 105u);
        if (v > y0 && v < y1 && x > 0.34f && x < 0.66f)
            print +=
                hashed(int(v * 90.0f), spine, 106u) > 0.22f && value_noise({x * 8.0f, v * 180.0f}, {8, 180}, 107u) > 0.42f ? 1.0f : 0.0f;
        if (spine % 4 == 2) print += band(v - 0.82f, 0.03f, 0.002f) * band(x - 0.5f, 0.16f, 0.01f);
        return opaque(glm::mix(color, foil, glm::clamp(print, 0.0f, 1.0f)));
    };
    return add_texture(edit, make_image("book spines", 1024, 256, pixel), ColorSpace::Srgb, kClamp);
}

TextureRef add_broad_leaf(SceneEdit& edit, glm::vec3 color, const std::string& name) {
    const auto pixel = [=](float u, float v) {
        const float along = 1.0f - v, x = u - 0.5f;
        const float width = 0.46f * std::pow(std::max(0.0f, std::sin(0.5f * float(kTurn) * std::pow(along, 0.8f))), 0.75f);
        const float veins = band(fraction(along * 9.0f - 6.0f * std::abs(x)) - 0.5f, 0.05f, 0.04f) * glm::smoothstep(0.0f, 0.1f, width);
        const float rib = band(x, 0.012f + 0.01f * v, 0.008f);
        const float patches = fractal_noise({u * 6.0f, v * 6.0f}, {6, 6}, 4, 111u);
        glm::vec3 leaf = color * (0.75f + 0.5f * patches);
        leaf = glm::mix(leaf, glm::min(color * 1.5f + 0.12f, glm::vec3(1.0f)), glm::clamp(rib + 0.45f * veins, 0.0f, 1.0f));
        const float alpha = std::max(0.5f + 40.0f * (width - std::abs(x)), along < 0.12f ? band(x, 0.012f, 0.004f) : 0.0f);
        return glm::vec4(leaf, alpha);
    };
    return add_texture(edit, make_image(name, 256, 256, pixel), ColorSpace::Srgb, kClamp);
}

TextureRef add_twig(SceneEdit& edit) {
    struct Leaf {
        glm::vec2 base, axis;
        float tone;
    };
    std::vector<Leaf> leaves;
    Random random(121u);
    for (int i = 0; i < 26; ++i) {
        const float along = 0.08f + 0.80f * float(i) / 25.0f, side = i % 2 == 0 ? 1.0f : -1.0f;
        const float angle = side * random.range(0.6f, 1.2f), length = random.range(0.2f, 0.3f) * (1.05f - 0.4f * along);
        leaves.push_back({{0.5f + side * random.range(0.0f, 0.12f), along + random.range(-0.02f, 0.02f)},
                          length * glm::vec2(std::sin(angle), std::cos(angle)),
                          random.unit()});
    }
    const auto pixel = [leaves](float u, float v) {
        const glm::vec2 p(u, 1.0f - v);
        float alpha = p.y < 0.8f ? 0.5f + 120.0f * (0.008f - std::abs(p.x - 0.5f)) : 0.0f;
        glm::vec3 color(0.32f, 0.24f, 0.15f);
        for (const Leaf& leaf : leaves) {
            const float length = glm::length(leaf.axis);
            const glm::vec2 axis = leaf.axis / length, d = p - leaf.base;
            const float t = glm::dot(d, axis) / length, across = d.x * axis.y - d.y * axis.x;
            if (t <= 0.0f || t >= 1.0f) continue;
            const float inside = 0.5f + 60.0f * (0.26f * length * std::sin(0.5f * float(kTurn) * std::pow(t, 0.8f)) - std::abs(across));
            if (inside < 0.5f) continue;
            alpha = std::max(alpha, inside);
            color = glm::mix(glm::vec3(0.22f, 0.38f, 0.10f), glm::vec3(0.47f, 0.58f, 0.18f), leaf.tone) * (0.85f + 0.3f * t);
            if (std::abs(across) < 0.004f) color *= 1.25f;
        }
        return glm::vec4(color, alpha);
    };
    return add_texture(edit, make_image("twig", 256, 256, pixel), ColorSpace::Srgb, kClamp);
}

TextureRef add_bark(SceneEdit& edit) {
    const auto pixel = [](float u, float v) {
        const float ridges = std::abs(fractal_noise({u * 14.0f, v * 4.0f}, {14, 4}, 4, 131u) - 0.5f) * 2.0f;
        const float height = 0.7f * std::sqrt(ridges) + 0.3f * fractal_noise({u * 30.0f, v * 16.0f}, {30, 16}, 3, 132u);
        return opaque(glm::mix(glm::vec3(0.20f, 0.15f, 0.11f), glm::vec3(0.52f, 0.45f, 0.37f), height));
    };
    return add_texture(edit, make_image("bark", 256, 256, pixel), ColorSpace::Srgb);
}

TextureRef add_smudges(SceneEdit& edit) {
    const auto pixel = [](float u, float v) {
        return glm::vec4(1.0f, 0.6f + 0.4f * fractal_noise({u * 7.0f, v * 7.0f}, {7, 7}, 5, 141u), 1.0f, 1.0f);
    };
    return add_texture(edit, make_image("smudges", 256, 256, pixel), ColorSpace::Linear);
}

}  // namespace parhelion::builtin
