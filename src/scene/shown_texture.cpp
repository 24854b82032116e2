// A bilinear filter makes of a texture a patchwork of cells, each between the centres of four texels and bilinear inside; a nearest one
// makes cells of one value. Cells that a triangle covers whole come from sums along the rows, so that the work is that of the outline;
// of the others each is clipped to its square.
#include "scene/shown_texture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/parallel.h"
#include "image/image.h"

namespace parhelion {

namespace {

constexpr double kReach = 1.0 / 64;            // texels: how far devices may round coordinates (1/256 in practice)
constexpr double kLeastSeen = 1.0 / 256;       // of the brightest texel within reach
constexpr int64_t kBlock = 64;                 // texels between two stored sums of a row
constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Interval {
    double low = kInfinity, high = -kInfinity;
    void add(double x) { low = std::min(low, x), high = std::max(high, x); }
    bool empty() const { return !(low <= high); }
};

// Convex, with room for a triangle that four lines have cut.
struct Polygon {
    std::array<glm::dvec2, 8> corners;
    int count = 0;
    void add(glm::dvec2 p) { corners[size_t(count++)] = p; }
};

// What of the polygon lies at or beyond `at` on the axis (side 1), or before it (side -1). Sutherland and Hodgman 1974.
Polygon clip(const Polygon& polygon, int axis, double at, double side) {
    if (std::isinf(at)) return polygon;
    Polygon out;
    for (int i = 0; i < polygon.count; ++i) {
        const glm::dvec2 a = polygon.corners[size_t(i)], b = polygon.corners[size_t((i + 1) % polygon.count)];
        const double da = side * (a[axis] - at), db = side * (b[axis] - at);
        if (da >= 0) out.add(a);
        if ((da >= 0) != (db >= 0)) {
            glm::dvec2 cut = a + (b - a) * (da / (da - db));
            cut[axis] = at;
            out.add(cut);
        }
    }
    return out;
}

struct Area {
    double area = 0;
    glm::dvec2 centroid{0.0};
};
Area area_of(const Polygon& polygon) {
    Area out;
    glm::dvec2 sum(0.0);
    const glm::dvec2 origin = polygon.corners[0];
    for (int i = 2; i < polygon.count; ++i) {
        const glm::dvec2 e1 = polygon.corners[size_t(i - 1)] - origin, e2 = polygon.corners[size_t(i)] - origin;
        const double twice = e1.x * e2.y - e1.y * e2.x;
        out.area += 0.5 * twice;
        sum += twice / 6 * (e1 + e2);
    }
    out.centroid = out.area != 0 ? origin + sum / out.area : origin;
    out.area = std::abs(out.area);
    return out;
}

// Where the triangle is on the strip low <= y <= high.
Interval reach_in_x(const Polygon& triangle, double low, double high) {
    Interval out;
    for (int i = 0; i < 3; ++i) {
        glm::dvec2 a = triangle.corners[size_t(i)], b = triangle.corners[size_t((i + 1) % 3)];
        if (a.y > b.y) std::swap(a, b);
        if (b.y < low || a.y > high) continue;
        const auto x_at = [&](double y) { return b.y > a.y ? a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y)) : a.x; };
        out.add(a.y < low ? x_at(low) : a.x);
        out.add(b.y > high ? x_at(high) : b.x);
    }
    return out;
}

// A row or a column of texels as the wrap mode continues it; mirrored ones are written out.
struct Axis {
    int64_t size = 0;   // of the image
    int64_t count = 0;  // texels that are kept
    bool periodic = false;

    int64_t kept(int64_t i) const { return periodic ? (i % count + count) % count : std::clamp<int64_t>(i, 0, count - 1); }
    int64_t of_image(int64_t i) const { return i < size ? i : 2 * size - 1 - i; }
    // The cell at a coordinate. Beyond a clamped edge there is one cell without end.
    int64_t cell(double at, bool linear) const {
        const double i = std::floor(at);
        return static_cast<int64_t>(periodic ? i : std::clamp(i, linear ? -1.0 : 0.0, double(count - 1)));
    }
    double begin(int64_t i, bool linear) const { return !periodic && i == (linear ? -1 : 0) ? -kInfinity : double(i); }
    double end(int64_t i) const { return !periodic && i == count - 1 ? kInfinity : double(i + 1); }
};

Axis make_axis(uint32_t size, Wrap wrap) {
    return {.size = size, .count = wrap == Wrap::MirroredRepeat ? 2 * int64_t(size) : int64_t(size), .periodic = wrap != Wrap::ClampToEdge};
}

struct Sum {
    double area = 0, shown = 0, brightest = 0;
};

}  // namespace

struct ShownTexture::Texels {
    Axis u, v;
    bool linear = true;
    int64_t row_blocks = 0;
    std::vector<float> luminance;      // [v * u.count + u]
    std::vector<double> sums;          // [v * row_blocks + block]: of the row's texels before the block
    double mean = 0;

    Texels(const Image& image, const Texture& texture, glm::vec3 tint);

    double texel(int64_t x, int64_t y) const { return luminance[static_cast<size_t>(v.kept(y) * u.count + u.kept(x))]; }

    // Of a kept row's first `end` texels. Added in one order whatever `end`: what is black between two ends leaves the bits as they are.
    double row_before(int64_t row, int64_t end) const {
        const float* texels = luminance.data() + row * u.count;
        double sum = sums[static_cast<size_t>(row * row_blocks + end / kBlock)];
        for (int64_t i = end / kBlock * kBlock; i < end; ++i) sum += double(texels[i]);
        return sum;
    }
    // Of the texels [first, end) of a row that goes on for ever; of a clamped one, of those that are kept.
    double row_sum(int64_t y, int64_t first, int64_t end) const {
        const int64_t row = v.kept(y);
        if (!u.periodic) return row_before(row, end) - row_before(row, first);
        const int64_t first_kept = u.kept(first), end_kept = u.kept(end);
        const auto periods = static_cast<double>((end - end_kept - (first - first_kept)) / u.count);
        return periods * row_before(row, u.count) + (row_before(row, end_kept) - row_before(row, first_kept));
    }
    double cell_sum(int64_t y, int64_t first, int64_t end) const {
        if (!linear) return row_sum(y, first, end);
        return 0.25 * (row_sum(y, first, end) + row_sum(y, first + 1, end + 1) + row_sum(y + 1, first, end) + row_sum(y + 1, first + 1, end + 1));
    }
    double value(int64_t x, int64_t y, glm::dvec2 at) const {
        if (!linear) return texel(x, y);
        const double fx = std::clamp(at.x - double(x), 0.0, 1.0), fy = std::clamp(at.y - double(y), 0.0, 1.0);
        return (1 - fy) * ((1 - fx) * texel(x, y) + fx * texel(x + 1, y)) + fy * ((1 - fx) * texel(x, y + 1) + fx * texel(x + 1, y + 1));
    }
    double value(glm::dvec2 at) const { return value(u.cell(at.x, linear), v.cell(at.y, linear), at); }
    double brightest(int64_t x, int64_t y) const {
        return linear ? std::max({texel(x, y), texel(x + 1, y), texel(x, y + 1), texel(x + 1, y + 1)}) : texel(x, y);
    }

    void add_row(const Polygon& triangle, double margin, int64_t y, Sum& sum) const;
};

ShownTexture::Texels::Texels(const Image& image, const Texture& texture, glm::vec3 tint)
    : u(make_axis(image.width, texture.sampler.wrap_u)), v(make_axis(image.height, texture.sampler.wrap_v)), linear(texture.sampler.mag == Filter::Linear) {
    std::array<std::array<float, 256>, 3> of_byte;
    for (size_t i = 0; i < 256; ++i) {
        const float encoded = static_cast<float>(i) / 255.0f, light = texture.color_space == ColorSpace::Srgb ? image::linear_from_srgb(encoded) : encoded;
        of_byte[0][i] = image::luminance(tint.r * light, 0.0f, 0.0f);
        of_byte[1][i] = image::luminance(0.0f, tint.g * light, 0.0f);
        of_byte[2][i] = image::luminance(0.0f, 0.0f, tint.b * light);
    }
    std::vector<uint8_t> decoded;
    if (image.format != TexelFormat::Rgba8) decoded = rgba8_texels(image);
    const uint8_t* bytes = decoded.empty() ? image.texels.data() : decoded.data();
    luminance.resize(static_cast<size_t>(u.count * v.count));
    row_blocks = u.count / kBlock + 1;
    sums.resize(static_cast<size_t>(row_blocks * v.count));
    for (int64_t y = 0; y < v.count; ++y) {
        double sum = 0;
        for (int64_t x = 0; x < u.count; ++x) {
            if (x % kBlock == 0) sums[static_cast<size_t>(y * row_blocks + x / kBlock)] = sum;
            const uint8_t* rgba = bytes + 4 * (v.of_image(y) * u.size + u.of_image(x));
            const float light = of_byte[0][rgba[0]] + of_byte[1][rgba[1]] + of_byte[2][rgba[2]];
            luminance[static_cast<size_t>(y * u.count + x)] = light;
            sum += double(light);
        }
        if (u.count % kBlock == 0) sums[static_cast<size_t>(y * row_blocks + u.count / kBlock)] = sum;
        mean += sum / double(u.count * v.count);
    }
}

// The cells of one row that the triangle covers or comes near to.
void ShownTexture::Texels::add_row(const Polygon& triangle, double margin, int64_t y, Sum& sum) const {
    const double low = v.begin(y, linear), high = v.end(y);
    const Interval near = reach_in_x(triangle, low - margin, high + margin);
    if (near.empty()) return;
    const int64_t first = u.cell(near.low - margin, linear), last = u.cell(near.high + margin, linear);
    // Cells [full, full_end) lie inside: both their edges in y do. Cells without end never.
    int64_t full = first, full_end = first;
    const Interval at_low = reach_in_x(triangle, low, low), at_high = reach_in_x(triangle, high, high);
    if (!at_low.empty() && !at_high.empty()) {
        const double from = std::ceil(std::max(at_low.low, at_high.low)), to = std::floor(std::min(at_low.high, at_high.high));
        const int64_t least = u.periodic ? first : std::max<int64_t>(first, linear ? 0 : 1), most = u.periodic ? last + 1 : std::min<int64_t>(last + 1, u.count - 1);
        const double inside_from = std::max(from, double(least)), inside_to = std::min(to, double(most));
        if (inside_from < inside_to) full = static_cast<int64_t>(inside_from), full_end = static_cast<int64_t>(inside_to);
    }
    if (full < full_end) {
        sum.area += double(full_end - full);
        sum.shown += cell_sum(y, full, full_end);
    }
    const Polygon strip = clip(clip(triangle, 1, low, 1), 1, high, -1);
    for (int64_t x = first; x <= last; ++x) {
        if (x == full && full < full_end) x = full_end;
        if (x > last) break;
        sum.brightest = std::max(sum.brightest, brightest(x, y));
        if (strip.count < 3) continue;
        const Polygon part = clip(clip(strip, 0, u.begin(x, linear), 1), 0, u.end(x), -1);
        if (part.count < 3) continue;
        const Area seen = area_of(part);
        sum.area += seen.area;
        sum.shown += seen.area * value(x, y, seen.centroid);
    }
}

ShownTexture::ShownTexture(const Image& image, const Texture& texture, glm::vec3 tint) : texels_(std::make_unique<Texels>(image, texture, tint)) {}
ShownTexture::~ShownTexture() = default;

double ShownTexture::mean(glm::dvec2 a, glm::dvec2 b, glm::dvec2 c, double uv_error, double& steps) const {
    const Texels& t = *texels_;
    const glm::dvec2 size(double(t.u.size), double(t.v.size)), shift(t.linear ? 0.5 : 0.0);
    const double margin = kReach + uv_error * std::max(size.x, size.y);
    Polygon triangle;
    for (const glm::dvec2 uv : {a, b, c}) triangle.add(uv * size - shift);
    Interval x, y;
    for (int i = 0; i < 3; ++i) x.add(triangle.corners[size_t(i)].x), y.add(triangle.corners[size_t(i)].y);
    // Beyond clamped edges there is nothing to count.
    const auto steps_in = [&](const Interval& i, const Axis& axis) { return std::min(i.high - i.low + 2 * margin, axis.periodic ? kInfinity : double(axis.count)); };
    const double needed = 1 + steps_in(x, t.u) + steps_in(y, t.v);
    double farthest = 0;
    for (int i = 0; i < 3; ++i) farthest += std::abs(triangle.corners[size_t(i)].x) + std::abs(triangle.corners[size_t(i)].y);
    if (!(needed <= steps) || !(farthest < 1e15)) return t.mean;
    steps -= needed;

    Sum sum;
    const int64_t last = t.v.cell(y.high + margin, t.linear);
    for (int64_t row = t.v.cell(y.low - margin, t.linear); row <= last; ++row) t.add_row(triangle, margin, row, sum);
    double mean = 0;
    if (sum.area > 1e-12)
        mean = sum.shown / sum.area;
    else  // a line or a point
        for (int i = 0; i < 3; ++i) mean += t.value(0.5 * (triangle.corners[size_t(i)] + triangle.corners[size_t((i + 1) % 3)])) / 3;
    return std::max(mean, sum.brightest * kLeastSeen / std::max(1.0, sum.area));
}

std::vector<float> ShownTexture::means(const Primitive& primitive, const TextureRef& ref) const {
    const glm::dmat3 transform(uv_transform(ref));
    const std::vector<glm::vec2>& uvs = ref.uv_set == 0 ? primitive.uv0 : primitive.uv1;
    std::vector<float> out(primitive.triangles.size());
    const auto mean_of = [&](const glm::uvec3& triangle, double& steps) {
        glm::dvec2 moved[3];
        double error = 0;
        for (int corner = 0; corner < 3; ++corner) {
            const glm::dvec2 uv = uvs.empty() ? glm::dvec2(0.0) : glm::dvec2(uvs[triangle[corner]]);  // what is missing is 0 on the device
            moved[corner] = glm::dvec2(transform * glm::dvec3(uv, 1.0));
            constexpr double kRounding = 1e-6;  // of interpolation, and of the transform's three products and sums
            for (int row = 0; row < 2; ++row)
                error = std::max(error, kRounding * (std::abs(transform[0][row] * uv.x) + std::abs(transform[1][row] * uv.y) + std::abs(transform[2][row])));
        }
        return mean(moved[0], moved[1], moved[2], error, steps);
    };
    // Triangles share their steps with their neighbours in fixed groups, whatever the number of cores.
    constexpr size_t kGroup = 1024;
    constexpr double kStepsOfAll = 1u << 26, kStepsOfTriangle = 32;
    const double steps_of_group = std::max(kStepsOfAll * kGroup / double(std::max<size_t>(out.size(), kGroup)), kStepsOfTriangle * kGroup);
    parallel_for((out.size() + kGroup - 1) / kGroup, 1, [&](size_t begin, size_t end) {
        for (size_t group = begin; group < end; ++group) {
            double steps = steps_of_group;
            for (size_t i = group * kGroup; i < std::min(out.size(), (group + 1) * kGroup); ++i) {
                const double mean = mean_of(primitive.triangles[i], steps);
                out[i] = mean > 0 ? std::max(static_cast<float>(mean), std::numeric_limits<float>::min()) : 0.0f;  // 0 is for black alone
            }
        }
    });
    return out;
}

}  // namespace parhelion
