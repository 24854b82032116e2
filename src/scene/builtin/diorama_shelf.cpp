// The shelf of the diorama with all that stands on it, and the stack of books on the floor.
#include <cmath>

#include "scene/builtin/diorama.h"
#include "scene/builtin/random.h"

namespace parhelion::builtin {

namespace {

constexpr float kWidth = 1.0f, kDepth = 0.32f, kHeight = 1.98f, kBoard = 0.022f, kCupboard = 0.66f;
constexpr float kBoards[] = {kCupboard, 1.0f, 1.33f, 1.66f};

void add_carcass(Model& model, const Palette& palette) {
    const float middle = 0.5f * kDepth;
    for (const float x : {0.5f * kBoard, kWidth - 0.5f * kBoard})
        model.add_box({kBoard, kHeight, kDepth}, {x, 0.5f * kHeight, middle}, palette.oak, 0.003f);
    for (const float y : {0.07f, kBoards[0], kBoards[1], kBoards[2], kBoards[3], kHeight - 0.5f * kBoard})
        model.add_box({kWidth - 2.0f * kBoard, kBoard, kDepth - 0.01f}, {0.5f * kWidth, y, middle - 0.004f}, palette.oak, 0.003f);
    model.add_box({kWidth - 0.01f, kHeight - 0.02f, 0.008f}, {0.5f * kWidth, 0.5f * kHeight, 0.005f}, palette.walnut, 0.001f);
    model.add_box({kWidth - 2.0f * kBoard, 0.06f, 0.02f}, {0.5f * kWidth, 0.03f, kDepth - 0.05f}, palette.oak, 0.002f);
    model.add_box({kWidth + 0.05f, 0.03f, kDepth + 0.03f}, {0.5f * kWidth, kHeight + 0.012f, middle + 0.005f}, palette.oak, 0.010f);
}

// A framed door of this size with its hinge at the origin, reaching to x = width or, for a hinge on the right, to -width.
Model make_door(const Palette& palette, float width, float height, float side) {
    Model door(palette);
    const float bar = 0.055f, x = side * 0.5f * width;
    for (const float end : {-1.0f, 1.0f}) {
        door.add_box({bar, height, 0.02f}, {x + end * 0.5f * (width - bar), 0.5f * height, 0.0f}, palette.oak, 0.004f);
        door.add_box({width - 2.0f * bar, bar, 0.02f}, {x, 0.5f * height + end * 0.5f * (height - bar), 0.0f}, palette.oak, 0.004f);
    }
    door.add_box({width - 2.0f * bar + 0.01f, height - 2.0f * bar + 0.01f, 0.008f}, {x, 0.5f * height, -0.003f}, palette.walnut, 0.001f);
    door.add(make_sphere(0.014f, 12, true), palette.brass, placed({side * (width - 0.028f), 0.62f * height, 0.028f}));
    door.add(make_cylinder(0.005f, 0.02f, 0.001f, 10), palette.brass,
             placed({side * (width - 0.028f), 0.62f * height, 0.008f}, 0.0f, 90.0f));
    return door;
}

void add_clock(Model& model, const Palette& palette, const glm::mat4& place) {
    const glm::mat4 upright = place * placed({0.0f, 0.085f, 0.0f}, 0.0f, 90.0f);
    const glm::vec2 rim[] = {{0.0f, -0.028f},  {0.070f, -0.028f}, {0.082f, -0.018f}, {0.083f, 0.014f},
                             {0.078f, 0.020f}, {0.072f, 0.018f},  {0.070f, 0.008f}};
    model.add(make_lathe(rim, 44), palette.brass, upright);
    const glm::vec2 face[] = {{0.071f, 0.008f}, {0.0f, 0.009f}};
    model.add(make_lathe(face, 40), palette.paper, upright);
    for (int hour = 0; hour < 12; ++hour)
        model.add(make_rounded_box({0.004f, 0.002f, hour % 3 == 0 ? 0.016f : 0.009f}, 0.0007f, 1), palette.cord,
                  upright * placed({0.0f, 0.0095f, 0.0f}, 30.0f * float(hour)) * placed({0.0f, 0.0f, 0.058f}));
    model.add(make_rounded_box({0.0045f, 0.002f, 0.040f}, 0.0008f, 1), palette.cord,
              upright * placed({0.0f, 0.011f, 0.0f}, 205.0f) * placed({0.0f, 0.0f, 0.018f}));
    model.add(make_rounded_box({0.003f, 0.002f, 0.058f}, 0.0008f, 1), palette.cord,
              upright * placed({0.0f, 0.0125f, 0.0f}, 60.0f) * placed({0.0f, 0.0f, 0.026f}));
    for (const float side : {-1.0f, 1.0f})
        model.add(make_sphere(0.012f, 10, true), palette.brass, place * placed({side * 0.045f, 0.012f, 0.0f}));
}

void add_jug(Model& model, Handle<Material> material, float size, const glm::mat4& place) {
    glm::vec2 profile[] = {{0.0f, 0.0f},   {0.30f, 0.0f},  {0.34f, 0.03f}, {0.46f, 0.25f},  {0.50f, 0.50f}, {0.42f, 0.78f}, {0.24f, 1.00f},
                           {0.20f, 1.12f}, {0.26f, 1.26f}, {0.27f, 1.28f}, {0.24f, 1.275f}, {0.17f, 1.12f}, {0.0f, 0.95f}};
    for (glm::vec2& p : profile) p *= size;
    model.add(make_lathe(profile, 40), material, place);
}

// Books laid on each other, the largest first.
void add_stack(Model& model, const Palette& palette, uint32_t seed, int count, const glm::mat4& place) {
    Random random(seed);
    float y = 0.0f;
    for (int i = 0; i < count; ++i) {
        const float thickness = random.range(0.022f, 0.04f), shrink = 1.0f - 0.05f * float(i);
        const Primitive book = make_book(thickness, 0.25f * shrink, 0.18f * shrink, random.below(15));
        // Lying on its side, the back to the front.
        model.add(
            book, palette.books,
            place * placed({random.range(-0.01f, 0.01f), y + 0.5f * thickness, random.range(-0.01f, 0.01f)}, random.range(-11.0f, 11.0f)) *
                placed({}, 0.0f, 0.0f, 90.0f));
        y += thickness + 0.0005f;
    }
}

void add_globe(Model& model, const Palette& palette, const glm::mat4& place) {
    model.add(make_cylinder(0.055f, 0.014f, 0.005f, 32), palette.walnut, place);
    model.add(make_cylinder(0.007f, 0.06f, 0.001f, 12), palette.brass, place);
    const glm::mat4 tilted = place * placed({0.0f, 0.14f, 0.0f}, 30.0f, 0.0f, 23.0f);
    model.add(make_sphere(0.075f, 24, true), palette.glaze, tilted);
    model.add(make_torus(0.083f, 0.003f, 40, 8), palette.brass, tilted * placed({}, 0.0f, 90.0f));
}

}  // namespace

void add_shelf(SceneEdit& edit, const Palette& palette, DioramaHandles& handles) {
    Model carcass(palette);
    add_carcass(carcass, palette);
    const Transform local{.translation = {kNookMax.x - kWidth - 0.03f, 0.0f, kNookMin.z + 0.03f}};
    const Handle<Node> node = carcass.place(edit, "shelf", local);

    const float wide = 0.5f * kWidth - 0.004f, high = kCupboard - 0.1f;
    handles.door =
        make_door(palette, wide, high, 1.0f).place(edit, "cupboard door", {.translation = {0.002f, 0.085f, kDepth + 0.008f}}, node);
    make_door(palette, wide, high, -1.0f)
        .place(edit, "right cupboard door", {.translation = {kWidth - 0.002f, 0.085f, kDepth + 0.008f}}, node);

    Model things(palette);
    const auto on = [](int board, float x, float z = 0.19f, float yaw = 0.0f) {
        return placed({x, kBoards[board] + 0.5f * kBoard, z}, yaw);
    };
    add_books(things, palette, 0.56f, 0.27f, 5u, on(0, 0.03f));
    add_jug(things, palette.terracotta, 0.15f, on(0, 0.80f, 0.17f));
    add_globe(things, palette, on(1, 0.16f, 0.19f, -20.0f));
    add_books(things, palette, 0.60f, 0.27f, 12u, on(1, 0.36f));
    add_books(things, palette, 0.45f, 0.27f, 23u, on(2, 0.03f));
    add_clock(things, palette, on(2, 0.62f, 0.2f, -14.0f));
    add_jug(things, palette.glaze, 0.12f, on(2, 0.84f, 0.15f));
    add_stack(things, palette, 31u, 4, on(3, 0.2f, 0.19f, 86.0f));
    add_books(things, palette, 0.38f, 0.25f, 44u, on(3, 0.58f));
    // Behind the door, for when it opens.
    add_books(things, palette, 0.42f, 0.30f, 57u, placed({0.04f, 0.081f, 0.17f}));
    add_jug(things, palette.copper, 0.14f, placed({0.72f, 0.081f, 0.17f}));
    things.place(edit, "things on the shelf", {}, node);

    Model stack(palette);
    add_stack(stack, palette, 63u, 5, glm::mat4(1.0f));
    stack.place(edit, "stack of books",
                {.translation = {0.62f, 0.0f, -0.72f}, .rotation = glm::angleAxis(glm::radians(70.0f), glm::vec3(0.0f, 1.0f, 0.0f))});
}

}  // namespace parhelion::builtin
