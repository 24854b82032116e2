// The shell of the diorama: floor, walls, ceiling, window, curtains, painting.
#include <cmath>

#include "scene/builtin/diorama.h"

namespace parhelion::builtin {

namespace {

constexpr float kWall = 0.16f, kRail = 0.77f;

// A box between two corners with UVs from its place in the room, so that what lies beside it goes on.
void add_wall(Model& model, glm::vec3 low, glm::vec3 high, Handle<Material> material) {
    Primitive box = make_rounded_box(high - low, 0.0008f, 1);
    const glm::vec3 middle = 0.5f * (low + high);
    for (size_t i = 0; i < box.positions.size(); ++i) {
        const glm::vec3 p = box.positions[i] + middle, n = glm::abs(box.normals[i]);
        box.uv0[i] = n.x > 0.6f ? glm::vec2(p.z, -p.y) : n.y > 0.6f ? glm::vec2(p.x, p.z) : glm::vec2(p.x, -p.y);
    }
    model.add(box, material, placed(middle));
}

// Panels with a raised frame along one stretch of wall of the given length, in the plane z = 0, from x = 0.
void add_wainscot(Model& model, const Palette& palette, float length, const glm::mat4& place) {
    const auto box = [&](glm::vec3 size, glm::vec3 middle, float radius) {
        model.add(make_rounded_box(size, radius), palette.paint, place * placed(middle));
    };
    box({length, kRail, 0.012f}, {0.5f * length, 0.5f * kRail, 0.006f}, 0.001f);
    box({length, 0.11f, 0.024f}, {0.5f * length, 0.055f, 0.012f}, 0.006f);
    box({length, 0.03f, 0.04f}, {0.5f * length, kRail, 0.02f}, 0.008f);
    box({length, 0.06f, 0.022f}, {0.5f * length, kRail - 0.06f, 0.011f}, 0.004f);
    const int panels = std::max(1, int(length / 0.55f));
    for (int i = 0; i <= panels; ++i)
        box({0.07f, kRail - 0.15f, 0.022f},
            {std::min(std::max(length * float(i) / float(panels), 0.035f), length - 0.035f), 0.5f * kRail + 0.02f, 0.011f}, 0.004f);
}

// Cloth that hangs in folds between two heights, gathered by its rail.
Primitive make_curtain(float width, float low, float high, float folds, float phase) {
    Primitive curtain;
    constexpr uint32_t kColumns = 72, kRows = 24;
    for (uint32_t row = 0; row <= kRows; ++row)
        for (uint32_t column = 0; column <= kColumns; ++column) {
            const float s = float(column) / kColumns, t = float(row) / kRows;
            const float wave = std::sin(6.2831853f * (folds * s + 0.12f * std::sin(3.0f * t + phase)) + phase);
            const float depth = (0.022f + 0.02f * t) * wave + 0.008f * std::sin(17.0f * s + 5.0f * t);
            curtain.positions.emplace_back(s * width * (0.9f + 0.1f * t) + 0.01f * std::sin(9.0f * t + phase), high + (low - high) * t,
                                           depth);
            curtain.uv0.emplace_back(1.5f * s * width, t * (high - low));
        }
    for (uint32_t row = 0; row < kRows; ++row)
        for (uint32_t column = 0; column < kColumns; ++column) {
            const uint32_t a = row * (kColumns + 1) + column, b = a + kColumns + 1;
            curtain.triangles.emplace_back(a, b, b + 1);
            curtain.triangles.emplace_back(a, b + 1, a + 1);
        }
    make_smooth_normals(curtain);
    return curtain;
}

void add_picture(SceneEdit& edit, const Palette& palette, glm::vec3 at, glm::vec2 size, float roll) {
    Model model(palette);
    Primitive canvas;
    add_textured_quad(canvas, {-0.5f * size.x, -0.5f * size.y, 0.02f}, {size.x, 0.0f, 0.0f}, {0.0f, size.y, 0.0f});
    canvas.tangents.clear();
    model.add(canvas, palette.painting);
    const float bar = 0.045f;
    for (const float side : {-1.0f, 1.0f}) {
        model.add(make_rounded_box({size.x + 2.0f * bar, bar, 0.045f}, 0.012f, 3), palette.brass,
                  placed({0.0f, side * 0.5f * (size.y + bar), 0.022f}));
        model.add(make_rounded_box({bar, size.y, 0.04f}, 0.012f, 3), palette.brass, placed({side * 0.5f * (size.x + bar), 0.0f, 0.022f}));
    }
    model.place(edit, "picture", {.translation = at, .rotation = glm::angleAxis(glm::radians(roll), glm::vec3(0.0f, 0.0f, 1.0f))});
}

void add_rug_model(SceneEdit& edit, const Palette& palette) {
    constexpr glm::vec2 kSize(2.1f, 1.4f);
    constexpr uint32_t kCells = 40;
    Primitive rug;
    for (uint32_t row = 0; row <= kCells; ++row)
        for (uint32_t column = 0; column <= kCells; ++column) {
            const glm::vec2 s(float(column) / kCells, float(row) / kCells);
            // A little uneven; the edges lie on the floor.
            const float lift = 0.009f + 0.003f * std::sin(11.0f * s.x + 4.0f * s.y) * std::sin(9.0f * s.y + 1.0f);
            const float rim = std::min(std::min(s.x, 1.0f - s.x) * kSize.x, std::min(s.y, 1.0f - s.y) * kSize.y);
            rug.positions.emplace_back((s.x - 0.5f) * kSize.x + 0.004f * std::sin(23.0f * s.y), lift * std::min(1.0f, rim / 0.01f) + 0.001f,
                                       (s.y - 0.5f) * kSize.y);
            rug.uv0.push_back(s);
        }
    for (uint32_t row = 0; row < kCells; ++row)
        for (uint32_t column = 0; column < kCells; ++column) {
            const uint32_t a = row * (kCells + 1) + column, b = a + kCells + 1;
            rug.triangles.emplace_back(a, b, b + 1);
            rug.triangles.emplace_back(a, b + 1, a + 1);
        }
    make_smooth_normals(rug);
    Model model(palette);
    model.add(rug, palette.rug);
    for (uint32_t i = 0; i < 70; ++i)
        for (const float side : {-1.0f, 1.0f}) {
            const float z = (float(i) / 69.0f - 0.5f) * (kSize.y - 0.02f), wobble = 0.012f * std::sin(float(i) * 2.3f + side);
            const glm::vec3 fringe[] = {{side * 0.5f * kSize.x, 0.005f, z},
                                        {side * (0.5f * kSize.x + 0.03f), 0.004f, z + 0.4f * wobble},
                                        {side * (0.5f * kSize.x + 0.055f), 0.003f, z + wobble}};
            const float radii[] = {0.0032f, 0.0028f, 0.002f};
            model.add(make_tube(fringe, radii, 4), palette.paper);
        }
    model.place(edit, "rug",
                {.translation = {-0.28f, 0.0f, 0.25f}, .rotation = glm::angleAxis(glm::radians(5.0f), glm::vec3(0.0f, 1.0f, 0.0f))});
}

}  // namespace

void add_room(SceneEdit& edit, const Palette& palette) {
    const glm::vec3 low = kNookMin, high = kNookMax;
    Model model(palette);
    add_wall(model, {low.x - kWall, -0.1f, low.z - kWall}, {high.x + kWall, 0.0f, high.z}, palette.floor);
    add_wall(model, {low.x - kWall, high.y, low.z - kWall}, {high.x + kWall, high.y + 0.1f, high.z}, palette.ceiling);
    add_wall(model, {low.x - kWall, 0.0f, low.z - kWall}, {high.x + kWall, high.y, low.z}, palette.plaster);  // back
    add_wall(model, {high.x, 0.0f, low.z}, {high.x + kWall, high.y, high.z}, palette.plaster);                // right
    // The left wall leaves the window out.
    add_wall(model, {low.x - kWall, 0.0f, low.z}, {low.x, high.y, kWindowBack}, palette.plaster);
    add_wall(model, {low.x - kWall, 0.0f, kWindowFront}, {low.x, high.y, high.z}, palette.plaster);
    add_wall(model, {low.x - kWall, 0.0f, kWindowBack}, {low.x, kWindowLow, kWindowFront}, palette.plaster);
    add_wall(model, {low.x - kWall, kWindowHigh, kWindowBack}, {low.x, high.y, kWindowFront}, palette.plaster);
    add_wainscot(model, palette, high.x - low.x, placed({low.x, 0.0f, low.z}));
    add_wainscot(model, palette, high.z - low.z, placed({low.x, 0.0f, high.z}, 90.0f));
    add_wainscot(model, palette, high.z - low.z, placed({high.x, 0.0f, low.z}, -90.0f));
    for (const float x : {-1.45f, -0.1f, 1.3f})
        model.add_box({0.13f, 0.15f, high.z - low.z}, {x, high.y - 0.06f, 0.5f * (low.z + high.z)}, palette.walnut, 0.012f);
    model.place(edit, "room");
    add_picture(edit, palette, {-0.42f, 1.62f, low.z + 0.001f}, {0.72f, 0.54f}, -0.8f);
    add_rug_model(edit, palette);
}

void add_window(SceneEdit& edit, const Palette& palette) {
    Model model(palette);
    const float x = kNookMin.x, middle_z = 0.5f * (kWindowBack + kWindowFront), width = kWindowFront - kWindowBack;
    const float middle_y = 0.5f * (kWindowLow + kWindowHigh), height = kWindowHigh - kWindowLow, inside = x - 0.09f;
    const auto bar = [&](glm::vec3 size, glm::vec3 at) { model.add_box(size, at, palette.paint, 0.008f); };
    for (const float side : {-1.0f, 1.0f}) {
        bar({0.07f, height, 0.06f}, {inside, middle_y, middle_z + side * 0.5f * (width - 0.06f)});
        bar({0.07f, 0.06f, width}, {inside, middle_y + side * 0.5f * (height - 0.06f), middle_z});
        bar({0.025f, height + 0.16f, 0.09f}, {x + 0.01f, middle_y, middle_z + side * 0.5f * (width + 0.09f)});
    }
    bar({0.06f, height, 0.055f}, {inside, middle_y, middle_z});
    bar({0.04f, 0.028f, width}, {inside, middle_y + 0.18f, middle_z});
    for (const float side : {-1.0f, 1.0f}) bar({0.04f, height, 0.024f}, {inside, middle_y, middle_z + side * 0.25f * width});
    bar({0.03f, 0.09f, width + 0.24f}, {x + 0.012f, kWindowHigh + 0.045f, middle_z});
    bar({0.27f, 0.035f, width + 0.24f}, {x + 0.03f, kWindowLow + 0.005f, middle_z});  // sill
    model.place(edit, "window");

    Model curtains(palette);
    const float rail = kWindowHigh + 0.17f, stand = x + 0.11f;
    const glm::vec3 rod[] = {{stand, rail, kWindowBack - 0.5f}, {stand, rail, kWindowFront + 0.5f}};
    const float radius[] = {0.011f};
    curtains.add(make_tube(rod, radius, 12), palette.brass);
    for (const glm::vec3& end : rod) curtains.add(make_sphere(0.025f, 10, true), palette.brass, placed(end));
    // From the middle outwards along -z and +z: the folds look into the room.
    Primitive back = make_curtain(0.40f, 0.06f, rail - 0.012f, 5.0f, 0.4f), front = make_curtain(0.46f, 0.07f, rail - 0.012f, 6.0f, 2.1f);
    curtains.add(back, palette.linen, placed({stand, 0.0f, kWindowBack + 0.03f}, 90.0f));
    curtains.add(front, palette.linen, placed({stand, 0.0f, kWindowFront + 0.46f}, 90.0f));
    for (uint32_t i = 0; i < 9; ++i)
        for (const float start : {kWindowBack - 0.33f, kWindowFront + 0.06f})
            curtains.add(make_torus(0.017f, 0.003f, 16, 6), palette.brass,
                         placed({stand, rail - 0.004f, start + 0.045f * float(i)}, 0.0f, 90.0f));
    curtains.place(edit, "curtains");
}

}  // namespace parhelion::builtin
