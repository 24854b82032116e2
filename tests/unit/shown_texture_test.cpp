// What a triangle shows of a texture, against a filter written out again and many points.
#include <cmath>
#include <ctime>
#include <random>

#include <gtest/gtest.h>

#include "image/image.h"
#include "scene/shown_texture.h"

namespace parhelion::shown_texture_test {
namespace {

constexpr double kUnlimited = 1e9;

struct Source {
    Image image;
    Texture texture;
};

Source random_source(uint32_t width, uint32_t height, Wrap wrap_u, Wrap wrap_v, Filter filter, uint32_t seed) {
    std::mt19937 random(seed);
    Source out{.image = {.width = width, .height = height}, .texture = {.sampler = {.wrap_u = wrap_u, .wrap_v = wrap_v, .mag = filter}}};
    for (uint32_t i = 0; i < 4 * width * height; ++i) out.image.texels.push_back(random() % 3 == 0 ? static_cast<uint8_t>(random()) : uint8_t{0});
    return out;
}

Source black_but(uint32_t size, uint32_t x, uint32_t y, Wrap wrap, Filter filter) {
    Source out{.image = {.width = size, .height = size, .texels = std::vector<uint8_t>(size_t(4) * size * size)}, .texture = {.sampler = {.wrap_u = wrap, .wrap_v = wrap, .mag = filter}}};
    for (size_t c = 0; c < 4; ++c) out.image.texels[4 * (size_t(y) * size + x) + c] = 255;
    return out;
}

int64_t wrapped(int64_t i, int64_t size, Wrap wrap) {
    const auto modulo = [](int64_t a, int64_t b) { return (a % b + b) % b; };
    if (wrap == Wrap::Repeat) return modulo(i, size);
    if (wrap == Wrap::ClampToEdge) return std::clamp<int64_t>(i, 0, size - 1);
    const int64_t m = modulo(i, 2 * size);
    return m < size ? m : 2 * size - 1 - m;
}

// Vulkan 1.3, 16.8 and 16.9.
double shown_at(const Source& s, glm::vec3 tint, glm::dvec2 uv) {
    const auto texel = [&](int64_t x, int64_t y) {
        const Sampler& sampler = s.texture.sampler;
        const size_t at = 4 * size_t(wrapped(y, s.image.height, sampler.wrap_v) * s.image.width + wrapped(x, s.image.width, sampler.wrap_u));
        glm::vec3 light;
        for (int c = 0; c < 3; ++c) {
            const float encoded = static_cast<float>(s.image.texels[at + size_t(c)]) / 255.0f;
            light[c] = tint[c] * (s.texture.color_space == ColorSpace::Srgb ? image::linear_from_srgb(encoded) : encoded);
        }
        return double(image::luminance(light.r, light.g, light.b));
    };
    const bool linear = s.texture.sampler.mag == Filter::Linear;
    const glm::dvec2 p = uv * glm::dvec2(s.image.width, s.image.height) - (linear ? 0.5 : 0.0), f = p - glm::floor(p);
    const auto x = static_cast<int64_t>(std::floor(p.x)), y = static_cast<int64_t>(std::floor(p.y));
    if (!linear) return texel(x, y);
    return (1 - f.y) * ((1 - f.x) * texel(x, y) + f.x * texel(x + 1, y)) + f.y * ((1 - f.x) * texel(x, y + 1) + f.x * texel(x + 1, y + 1));
}

double mean_of(const Source& s, glm::dvec2 a, glm::dvec2 b, glm::dvec2 c, glm::vec3 tint = glm::vec3(1.0f), double steps = kUnlimited) {
    return ShownTexture(s.image, s.texture, tint).mean(a, b, c, 0, steps);
}

// Over a regular grid of small triangles' middles.
double mean_by_points(const Source& s, glm::vec3 tint, glm::dvec2 a, glm::dvec2 b, glm::dvec2 c, int n) {
    double sum = 0;
    for (int i = 0; i < n; ++i)
        for (int k = 0; i + k < n; ++k) {
            sum += shown_at(s, tint, a + (b - a) * ((i + 1.0 / 3) / n) + (c - a) * ((k + 1.0 / 3) / n));
            if (i + k < n - 1) sum += shown_at(s, tint, a + (b - a) * ((i + 2.0 / 3) / n) + (c - a) * ((k + 2.0 / 3) / n));
        }
    return sum / (double(n) * n);
}

}  // namespace

TEST(ShownTexture, the_mean_is_that_of_many_points_in_every_wrap_mode_and_filter) {
    const glm::vec3 tint(0.8f, 0.5f, 0.25f);
    std::mt19937 random(3);
    const auto unit = [&] { return static_cast<double>(random() >> 8) * 0x1p-24; };
    for (const Filter filter : {Filter::Linear, Filter::Nearest})
        for (const Wrap wrap_u : {Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge})
            for (const Wrap wrap_v : {Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge}) {
                const Source s = random_source(13, 7, wrap_u, wrap_v, filter, random());
                const ShownTexture shown(s.image, s.texture, tint);
                for (const double size : {0.6, 3.0}) {  // of the image, from where it begins on
                    const auto corner = [&] { return glm::dvec2(unit(), unit()) * size - 0.4 * size; };
                    const glm::dvec2 a = corner(), b = a + glm::dvec2(size, 0.3 * unit()), c = a + glm::dvec2(0.5 * unit(), -size);
                    double steps = kUnlimited;
                    const double mean = shown.mean(a, b, c, 0, steps), expected = mean_by_points(s, tint, a, b, c, 200);
                    // Cells that the outline cuts are taken at the middle of what is seen of them.
                    EXPECT_NEAR(mean, expected, 0.01 * expected) << int(filter) << int(wrap_u) << int(wrap_v) << ' ' << size;
                    EXPECT_LT(steps, kUnlimited);
                }
            }
}

TEST(ShownTexture, whole_cells_are_exact) {
    for (const Wrap wrap : {Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge})
        for (const Filter filter : {Filter::Linear, Filter::Nearest}) {
            const Source s = random_source(200, 130, wrap, wrap, filter, 5);
            double sum = 0;
            for (uint32_t y = 0; y < 130; ++y)
                for (uint32_t x = 0; x < 200; ++x) sum += shown_at(s, glm::vec3(1.0f), {(x + 0.5) / 200, (y + 0.5) / 130});
            const double half = 0.5 * (mean_of(s, {0, 0}, {1, 0}, {1, 1}) + mean_of(s, {0, 0}, {1, 1}, {0, 1}));
            // Bilinear weights of a clamped image's edge texels differ from the plain mean's.
            EXPECT_NEAR(half, sum / (200 * 130), (wrap == Wrap::ClampToEdge && filter == Filter::Linear ? 0.01 : 0.002) * half) << int(wrap) << int(filter);
        }
}

TEST(ShownTexture, only_what_the_filter_can_reach_makes_a_triangle_shine) {
    for (const Filter filter : {Filter::Linear, Filter::Nearest})
        for (const Wrap wrap : {Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge}) {
            const Source s = black_but(64, 20, 33, wrap, filter);
            const double reach = filter == Filter::Linear ? 1.0 : 0.5;  // texels from the bright one's middle
            const auto at = [](double x, double y) { return glm::dvec2(x, y) / 64.0; };
            const auto left_of = [&](double x) { return mean_of(s, at(x, 33.5), at(x - 9, 20), at(x - 9, 45)); };
            EXPECT_EQ(left_of(20.5 - reach - 0.02), 0.0);
            EXPECT_GT(left_of(20.5 - reach - 0.01), 0.0);  // devices round
            EXPECT_GT(left_of(20.5 - reach + 0.01), 0.0);
            const auto below = [&](double y) { return mean_of(s, at(20.5, y), at(1, y + 25), at(40, y + 25)); };
            EXPECT_EQ(below(33.5 + reach + 0.02), 0.0);
            EXPECT_GT(below(33.5 + reach - 0.01), 0.0);
            EXPECT_GT(mean_of(s, at(20.5, 33.5), at(20.5, 33.5), at(20.5, 33.5)), 0.9);  // a point
            EXPECT_EQ(mean_of(s, at(25, 33.5), at(25, 33.5), at(25, 33.5)), 0.0);
            EXPECT_GT(mean_of(s, at(0, 33.5), at(60, 33.5), at(30, 33.5)), 0.0);  // a line
            EXPECT_EQ(mean_of(s, at(0, 36), at(60, 36), at(30, 36)), 0.0);
        }
}

TEST(ShownTexture, one_bright_texel_of_thousands_counts_as_what_it_is) {
    const Source s = black_but(512, 300, 200, Wrap::Repeat, Filter::Linear);
    EXPECT_NEAR(mean_of(s, {0, 0}, {1, 0}, {1, 1}) * 0.5, 1.0 / (512 * 512), 1e-12);
    EXPECT_EQ(mean_of(s, {0, 0}, {1, 1}, {0, 1}), 0.0);
    EXPECT_NEAR(mean_of(s, {-7, -7}, {93, -7}, {93, 93}), 1.0 / (512 * 512), 0.02 / (512 * 512));  // repeated 5000 times
}

TEST(ShownTexture, a_brightest_texel_within_reach_has_a_share_however_little_is_seen_of_it) {
    const Source s = black_but(64, 20, 33, Wrap::Repeat, Filter::Linear);
    const auto at = [](double x, double y) { return glm::dvec2(x, y) / 64.0; };
    EXPECT_GE(mean_of(s, at(19.501, 33.5), at(19.4, 33.4), at(19.4, 33.6)), 1.0 / 256);
    EXPECT_GE(mean_of(s, at(19.501, 33.5), at(9.5, 23.5), at(9.5, 43.5)), 1.0 / 256 / 100.1);
}

TEST(ShownTexture, tint_and_colour_space_decide_what_is_black) {
    Source s{.image = {.width = 1, .height = 1, .texels = {0, 128, 0, 255}}};
    EXPECT_EQ(mean_of(s, {0, 0}, {1, 0}, {0, 1}, {1.0f, 0.0f, 1.0f}), 0.0);
    EXPECT_NEAR(mean_of(s, {0, 0}, {1, 0}, {0, 1}, {0.0f, 0.5f, 0.0f}), 0.7152 * 0.5 * std::pow((128 / 255.0 + 0.055) / 1.055, 2.4), 1e-6);
    s.texture.color_space = ColorSpace::Linear;
    EXPECT_NEAR(mean_of(s, {0, 0}, {1, 0}, {0, 1}), 0.7152 * 128 / 255, 1e-6);
}

TEST(ShownTexture, a_primitive_reads_its_uv_set_through_the_transform) {
    const Source s = black_but(64, 20, 33, Wrap::ClampToEdge, Filter::Linear);
    Primitive primitive;
    primitive.positions.resize(3);
    primitive.triangles = {{0, 1, 2}};
    primitive.uv0 = {{0.9f, 0.9f}, {0.91f, 0.9f}, {0.9f, 0.91f}};
    primitive.uv1 = {{0.0f, 0.0f}, {1.0f, 0.0f}, {0.0f, 1.0f}};
    TextureRef ref{.uv_set = 1, .offset = {20.4f / 64, 33.4f / 64}, .scale = glm::vec2(0.1f / 64)};
    const ShownTexture shown(s.image, s.texture, glm::vec3(1.0f));
    EXPECT_NEAR(shown.means(primitive, ref)[0], 0.86, 0.03);
    ref.uv_set = 0;
    EXPECT_NEAR(shown.means(primitive, ref)[0], 0.98, 0.03);  // 0.09 texels on
    ref.offset += 0.5f;
    EXPECT_EQ(shown.means(primitive, ref)[0], 0.0f);
    // Far from the origin the device's UVs have few digits left, and all within their rounding may shine.
    for (glm::vec2& uv : primitive.uv0) uv += 40000.0f;
    ref.scale = glm::vec2(1.0f), ref.offset = glm::vec2(-40000.0f - 0.9f + 20.5f / 64 + 0.02f, -40000.0f - 0.9f + 33.5f / 64);
    EXPECT_GT(shown.means(primitive, ref)[0], 0.0f);
    ref.uv_set = 1, ref.scale = ref.offset = glm::vec2(0.0f);
    primitive.uv1.clear();
    EXPECT_EQ(shown.means(primitive, ref)[0], 0.0f);
}

TEST(ShownTexture, what_would_take_too_long_shows_the_whole_textures_mean) {
    const Source s = black_but(64, 20, 33, Wrap::Repeat, Filter::Linear);
    EXPECT_NEAR(mean_of(s, {0, 0}, {1e6, 0}, {0, 1e6}, glm::vec3(1.0f), 1e5), 1.0 / 4096, 1e-9);
    EXPECT_NEAR(mean_of(s, {0, 0}, {1e30, 0}, {0, 1e30}), 1.0 / 4096, 1e-9);
    EXPECT_NEAR(mean_of(s, {0, 0}, {std::nan(""), 0}, {0, 1}), 1.0 / 4096, 1e-9);
}

TEST(ShownTexture, a_million_triangles_take_seconds) {
    constexpr uint32_t kSide = 708;
    const Source s = random_source(1024, 1024, Wrap::Repeat, Wrap::Repeat, Filter::Linear, 9);
    Primitive primitive;
    for (uint32_t y = 0; y <= kSide; ++y)
        for (uint32_t x = 0; x <= kSide; ++x) primitive.uv0.push_back(glm::vec2(x, y) / float(kSide));
    for (uint32_t y = 0; y < kSide; ++y)
        for (uint32_t x = 0; x < kSide; ++x) {
            const uint32_t i = y * (kSide + 1) + x;
            primitive.triangles.push_back({i, i + 1, i + kSide + 1});
            primitive.triangles.push_back({i + 1, i + kSide + 2, i + kSide + 1});
        }
    const std::clock_t start = std::clock();
    const std::vector<float> means = ShownTexture(s.image, s.texture, glm::vec3(1.0f)).means(primitive, {});
    const double seconds = double(std::clock() - start) / CLOCKS_PER_SEC;  // of all cores
    RecordProperty("seconds", std::to_string(seconds));
    EXPECT_LT(seconds, 10.0);  // about 2
    double sum = 0, whole = 0;
    for (const float mean : means) sum += double(mean);
    for (size_t i = 0; i < s.image.texels.size(); ++i)
        if (i % 4 != 3) whole += double(image::linear_from_srgb(static_cast<float>(s.image.texels[i]) / 255.0f)) * (i % 4 == 0 ? 0.2126 : i % 4 == 1 ? 0.7152 : 0.0722);
    EXPECT_NEAR(sum / double(means.size()), whole / (1024.0 * 1024.0), 0.001 * sum / double(means.size()));
}

}  // namespace parhelion::shown_texture_test
