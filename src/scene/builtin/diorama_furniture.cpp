// Furniture of the diorama: armchair, table with what stands on it, floor lamp, shelf with books.
#include <cmath>

#include "scene/builtin/diorama.h"
#include "scene/builtin/random.h"
#include "scene/builtin/textures.h"

namespace parhelion::builtin {

namespace {

Transform on_floor(glm::vec3 at, float yaw) {
    return {.translation = at, .rotation = glm::angleAxis(glm::radians(yaw), glm::vec3(0.0f, 1.0f, 0.0f))};
}

void add_leg(Model& model, glm::vec3 top, glm::vec3 foot, float thick, float thin, Handle<Material> material) {
    const glm::vec3 points[] = {top, glm::mix(top, foot, 0.5f), foot};
    const float radii[] = {thick, 0.5f * (thick + thin), thin};
    model.add(make_tube(points, radii, 14), material);
}

// A pot for tea with a wire handle.
void add_kettle(Model& model, const Palette& palette, const glm::mat4& place) {
    const glm::vec2 body[] = {{0.0f, 0.0f},     {0.062f, 0.0f},   {0.070f, 0.004f}, {0.084f, 0.025f}, {0.090f, 0.050f}, {0.086f, 0.075f},
                              {0.073f, 0.098f}, {0.056f, 0.112f}, {0.046f, 0.116f}, {0.046f, 0.121f}, {0.0f, 0.121f}};
    model.add(make_lathe(body, 40), palette.copper, place);
    const glm::vec2 lid[] = {{0.0f, 0.119f},   {0.043f, 0.119f}, {0.0445f, 0.122f}, {0.036f, 0.130f}, {0.020f, 0.136f}, {0.006f, 0.138f},
                             {0.005f, 0.143f}, {0.011f, 0.148f}, {0.012f, 0.155f},  {0.007f, 0.161f}, {0.0f, 0.162f}};
    model.add(make_lathe(lid, 32), palette.copper, place);
    const glm::vec3 spout[] = {{0.070f, 0.040f, 0.0f}, {0.105f, 0.055f, 0.0f}, {0.122f, 0.085f, 0.0f}, {0.148f, 0.112f, 0.0f}};
    const std::vector<glm::vec3> curve = smooth_curve(spout, 6);
    std::vector<float> radii;
    for (size_t i = 0; i < curve.size(); ++i) radii.push_back(glm::mix(0.021f, 0.0085f, std::sqrt(float(i) / float(curve.size() - 1))));
    model.add(make_tube(curve, radii, 16), palette.copper, place);
    const glm::vec3 handle[] = {{-0.078f, 0.088f, 0.0f}, {-0.085f, 0.15f, 0.0f}, {-0.045f, 0.205f, 0.0f},
                                {0.03f, 0.21f, 0.0f},    {0.075f, 0.16f, 0.0f},  {0.074f, 0.088f, 0.0f}};
    const float wire[] = {0.0042f};
    model.add(make_tube(smooth_curve(handle, 8), wire, 10), palette.brass, place);
    const glm::vec3 grip[] = {{-0.052f, 0.2f, 0.0f}, {-0.02f, 0.2145f, 0.0f}, {0.02f, 0.2135f, 0.0f}, {0.045f, 0.203f, 0.0f}};
    const float wood[] = {0.0095f};
    model.add(make_tube(smooth_curve(grip, 5), wood, 12), palette.walnut, place);
}

void add_cup(Model& model, const Palette& palette, const glm::mat4& place) {
    const glm::vec2 saucer[] = {{0.0f, 0.0f},      {0.035f, 0.0f},   {0.040f, 0.003f}, {0.068f, 0.012f},
                                {0.070f, 0.0145f}, {0.067f, 0.015f}, {0.040f, 0.007f}, {0.0f, 0.006f}};
    model.add(make_lathe(saucer, 40), palette.ceramic, place);
    const glm::vec2 cup[] = {{0.0f, 0.007f},   {0.021f, 0.007f}, {0.023f, 0.011f}, {0.034f, 0.026f}, {0.040f, 0.045f}, {0.043f, 0.066f},
                             {0.042f, 0.068f}, {0.040f, 0.066f}, {0.037f, 0.046f}, {0.030f, 0.027f}, {0.018f, 0.014f}, {0.0f, 0.013f}};
    model.add(make_lathe(cup, 40), palette.ceramic, place);
    const glm::vec2 tea[] = {{0.0395f, 0.056f}, {0.0f, 0.0562f}};
    model.add(make_lathe(tea, 32), palette.walnut, place);
    const glm::vec3 ear[] = {
        {0.040f, 0.058f, 0.0f}, {0.058f, 0.056f, 0.0f}, {0.062f, 0.040f, 0.0f}, {0.048f, 0.026f, 0.0f}, {0.033f, 0.026f, 0.0f}};
    const float radius[] = {0.0038f};
    model.add(make_tube(smooth_curve(ear, 6), radius, 10), palette.ceramic, place);
}

// Two blocks of pages that bow towards the fold, face up.
Primitive make_open_pages() {
    Primitive pages;
    constexpr uint32_t kSteps = 24;
    const auto height = [](float x) { return 0.006f + 0.011f * std::pow(std::sin(3.14159f * std::pow(std::abs(x), 0.6f)), 0.8f); };
    for (const float z : {-0.1f, 0.1f})
        for (uint32_t i = 0; i <= kSteps; ++i) {
            const float x = 2.0f * float(i) / kSteps - 1.0f;
            pages.positions.emplace_back(0.14f * x, height(x), z);
            pages.positions.emplace_back(0.14f * x, 0.0f, z);
            pages.uv0.insert(pages.uv0.end(), 2, glm::vec2(0.14f * x, z));
        }
    const uint32_t far_row = 2 * (kSteps + 1);
    for (uint32_t i = 0; i < kSteps; ++i) {
        const uint32_t a = 2 * i, b = far_row + 2 * i;
        pages.triangles.insert(
            pages.triangles.end(),
            {{a, b, b + 2}, {a, b + 2, a + 2}, {b, b + 1, b + 3}, {b, b + 3, b + 2}, {a + 1, a, a + 2}, {a + 1, a + 2, a + 3}});
    }
    make_smooth_normals(pages);
    return pages;
}

void add_flowers(Model& model, const Palette& palette, const glm::mat4& place) {
    const glm::vec2 vase[] = {{0.0f, 0.0f},     {0.036f, 0.0f},   {0.040f, 0.005f}, {0.048f, 0.035f}, {0.050f, 0.065f}, {0.040f, 0.105f},
                              {0.024f, 0.140f}, {0.022f, 0.160f}, {0.030f, 0.180f}, {0.031f, 0.182f}, {0.028f, 0.181f}, {0.019f, 0.160f},
                              {0.021f, 0.140f}, {0.037f, 0.104f}, {0.046f, 0.065f}, {0.0f, 0.012f}};
    model.add(make_lathe(vase, 40), palette.glass, place);
    const glm::vec2 bud[] = {{0.0f, 0.0f},     {0.012f, 0.004f}, {0.019f, 0.018f}, {0.0195f, 0.032f},
                             {0.015f, 0.047f}, {0.008f, 0.056f}, {0.006f, 0.050f}, {0.0f, 0.03f}};
    Random random(77u);
    for (int i = 0; i < 7; ++i) {
        const float angle = 0.9f * float(i), lean = random.range(0.05f, 0.13f), tall = random.range(0.27f, 0.38f);
        const glm::vec3 out(std::cos(angle), 0.0f, std::sin(angle));
        const glm::vec3 knots[] = {{0.0f, 0.03f, 0.0f},
                                   0.012f * out + glm::vec3(0.0f, 0.165f, 0.0f),
                                   0.6f * lean * out + glm::vec3(0.0f, 0.8f * tall, 0.0f),
                                   lean * out + glm::vec3(0.0f, tall, 0.0f)};
        const std::vector<glm::vec3> curve = smooth_curve(knots, 6);
        const float radius[] = {0.0026f};
        model.add(make_tube(curve, radius, 8), palette.stem, place);
        const glm::vec3 up = glm::normalize(curve.back() - curve[curve.size() - 3]);
        const Transform head{.translation = curve.back(),
                             .rotation = glm::quat(glm::vec3(0.0f, 1.0f, 0.0f), up),
                             .scale = glm::vec3(random.range(0.85f, 1.15f))};
        model.add(make_lathe(bud, 18), i % 3 == 1 ? palette.petal_pale : palette.petal, place * matrix_of(head));
        Primitive leaf;
        const glm::vec3 aside(-out.z, 0.0f, out.x);
        add_leaf_card(leaf, 0.02f * out + glm::vec3(0.0f, 0.17f, 0.0f), 0.09f * out + 0.03f * aside + glm::vec3(0.0f, 0.13f, 0.0f),
                      0.05f * aside, 0.04f, 5);
        model.add(leaf, palette.fern, place);
    }
}

}  // namespace

void add_armchair(SceneEdit& edit, const Palette& palette) {
    Model model(palette);
    const auto cloth = [&](const Primitive& part, const glm::mat4& place) { model.add(part, palette.chair, place); };
    cloth(make_rounded_box({0.66f, 0.15f, 0.66f}, 0.05f, 4), placed({0.0f, 0.29f, 0.0f}));
    cloth(make_cushion({0.57f, 0.14f, 0.62f}, 0.055f, 0.035f), placed({0.0f, 0.42f, 0.04f}, 1.0f));
    cloth(make_cushion({0.60f, 0.62f, 0.17f}, 0.075f, 0.04f), placed({0.0f, 0.70f, -0.27f}, 0.0f, -13.0f));
    cloth(make_rounded_box({0.70f, 0.56f, 0.10f}, 0.048f, 5), placed({0.0f, 0.60f, -0.35f}, 0.0f, -13.0f));
    for (const float side : {-1.0f, 1.0f}) {
        cloth(make_cushion({0.14f, 0.32f, 0.70f}, 0.065f, 0.012f), placed({side * 0.365f, 0.44f, -0.02f}, 0.0f, -3.0f));
        for (const float front : {-1.0f, 1.0f})
            add_leg(model, {side * 0.27f, 0.25f, front * 0.26f}, {side * 0.33f, 0.0f, front * 0.32f}, 0.022f, 0.012f, palette.walnut);
    }
    model.add(make_cushion({0.40f, 0.40f, 0.10f}, 0.045f, 0.06f), palette.pillow, placed({0.07f, 0.66f, -0.10f}, -8.0f, -22.0f, 11.0f));
    model.place(edit, "armchair", on_floor({0.02f, 0.0f, -0.92f}, -14.0f));
}

void add_table(SceneEdit& edit, const Palette& palette) {
    Model table(palette);
    const glm::vec2 top[] = {{0.0f, 0.452f},   {0.285f, 0.452f}, {0.30f, 0.460f}, {0.305f, 0.470f},
                             {0.302f, 0.478f}, {0.295f, 0.481f}, {0.0f, 0.481f}};
    Primitive disc = make_lathe(top, 64);
    for (size_t i = 0; i < disc.uv0.size(); ++i) disc.uv0[i] = {disc.positions[i].x, disc.positions[i].z};
    table.add(disc, palette.walnut);
    for (int i = 0; i < 3; ++i) {
        const float angle = 0.5f + 2.0943951f * float(i);
        const glm::vec3 out(std::cos(angle), 0.0f, std::sin(angle));
        add_leg(table, 0.16f * out + glm::vec3(0.0f, 0.46f, 0.0f), 0.27f * out, 0.020f, 0.011f, palette.walnut);
    }
    const Handle<Node> node = table.place(edit, "table", on_floor({-0.98f, 0.0f, -0.38f}, 20.0f));

    const float on_top = 0.4812f;
    Model kettle(palette), cup(palette), flowers(palette), book(palette);
    const glm::vec2 trivet[] = {{0.0f, 0.0f}, {0.083f, 0.0f}, {0.086f, 0.003f}, {0.083f, 0.008f}, {0.0f, 0.008f}};
    kettle.add(make_lathe(trivet, 36), palette.cord);
    add_kettle(kettle, palette, placed({0.0f, 0.0082f, 0.0f}));
    kettle.place(edit, "kettle", on_floor({-0.06f, on_top, 0.11f}, -38.0f), node);
    add_cup(cup, palette, glm::mat4(1.0f));
    cup.place(edit, "cup", on_floor({0.155f, on_top, 0.12f}, -60.0f), node);
    add_flowers(flowers, palette, glm::mat4(1.0f));
    flowers.place(edit, "flowers", on_floor({-0.06f, on_top, -0.14f}, 40.0f), node);
    book.add_box({0.285f, 0.006f, 0.205f}, {0.0f, 0.003f, 0.0f}, palette.petal, 0.0025f);
    book.add(make_open_pages(), palette.paper, placed({0.0f, 0.006f, 0.0f}));
    book.place(edit, "open book",
               {.translation = {0.155f, 0.512f, 0.05f}, .rotation = glm::angleAxis(glm::radians(-27.0f), glm::vec3(0.0f, 1.0f, 0.0f))},
               edit.add(Node{.name = "seat", .local = on_floor({-0.10f, 0.0f, -0.84f}, -14.0f)}));
}

void add_floor_lamp(SceneEdit& edit, const Palette& palette) {
    Model model(palette);
    const glm::vec2 foot[] = {{0.0f, 0.0f},    {0.145f, 0.0f},   {0.150f, 0.006f}, {0.146f, 0.016f},
                              {0.06f, 0.026f}, {0.022f, 0.036f}, {0.013f, 0.06f},  {0.012f, 0.08f}};
    model.add(make_lathe(foot, 48), palette.brass);
    const glm::vec3 pole[] = {{0.0f, 0.05f, 0.0f}, {0.0f, 0.8f, 0.0f}, {0.0f, 1.40f, 0.0f}};
    const float radius[] = {0.011f};
    model.add(make_tube(pole, radius, 16), palette.brass);
    model.add(make_sphere(0.019f, 12, true), palette.brass, placed({0.0f, 1.02f, 0.0f}));
    model.add(make_cylinder(0.02f, 0.06f, 0.004f, 20), palette.brass, placed({0.0f, 1.385f, 0.0f}));
    for (int i = 0; i < 3; ++i) {
        const float angle = 2.0943951f * float(i);
        const glm::vec3 arm[] = {{0.0f, 1.405f, 0.0f}, {0.19f * std::cos(angle), 1.375f, 0.19f * std::sin(angle)}};
        const float wire[] = {0.002f};
        model.add(make_tube(arm, wire, 6), palette.brass);
    }
    const glm::vec2 shade[] = {{0.225f, 1.36f}, {0.150f, 1.67f}};
    Primitive cone = make_lathe(shade, 56);
    for (glm::vec2& uv : cone.uv0) uv.y += 0.33f;
    model.add(cone, palette.shade);
    model.add(make_torus(0.225f, 0.004f, 56, 8), palette.brass, placed({0.0f, 1.36f, 0.0f}));
    model.add(make_torus(0.150f, 0.004f, 48, 8), palette.brass, placed({0.0f, 1.67f, 0.0f}));
    const Transform place = on_floor({0.72f, 0.0f, -1.36f}, 10.0f);
    const Handle<Node> node = model.place(edit, "floor lamp", place);
    Material bulb = glossy("lamp bulb", {0.9f, 0.9f, 0.85f}, 0.0f, 0.5f);
    bulb.emission = glm::vec3(54000.0f, 35500.0f, 18500.0f);
    place_object(edit, "lamp bulb", make_sphere(0.042f, 14, true), edit.add(std::move(bulb)), {.translation = {0.0f, 1.49f, 0.0f}}, node);
}

Primitive make_book(float thickness, float height, float depth, uint32_t cover) {
    // The back with its print, the boards in the cover's plain colour.
    Primitive book = make_rounded_box({thickness, height, depth}, std::min(0.004f, 0.3f * thickness));
    const float cell = 1.0f / kSpines, left = float(cover % (kSpines - 1)) * cell;
    for (size_t i = 0; i < book.positions.size(); ++i) {
        const glm::vec3 p = book.positions[i];
        const float across = glm::clamp(p.x / thickness + 0.5f, 0.02f, 0.98f), down = glm::clamp(0.5f - p.y / height, 0.01f, 0.99f);
        book.uv0[i] = book.normals[i].z > 0.5f ? glm::vec2(left + cell * across, down) : glm::vec2(left + cell * 0.12f, down);
    }
    Primitive pages = make_rounded_box({thickness - 0.006f, height, depth - 0.006f}, 0.001f, 1);
    for (size_t i = 0; i < pages.uv0.size(); ++i)
        pages.uv0[i] = {1.0f - cell + cell * glm::clamp(0.5f + 0.9f * pages.positions[i].x / thickness, 0.05f, 0.95f),
                        glm::clamp(0.5f + pages.positions[i].z / depth, 0.05f, 0.95f)};
    // The pages show at the top, at the bottom and behind, a little within the boards.
    append(book, pages, placed({0.0f, 0.0008f, -0.0035f}));
    return book;
}

void add_books(Model& model, const Palette& palette, float width, float height, uint32_t seed, const glm::mat4& place) {
    Random random(seed);
    float x = 0.0f;
    while (true) {
        const float thickness = random.range(0.016f, 0.046f), tall = height * random.range(0.68f, 0.95f),
                    depth = random.range(0.14f, 0.19f);
        const float lean = random.unit() < 0.14f ? random.range(3.0f, 9.0f) : random.range(-0.5f, 0.5f);
        const float room = thickness + tall * std::sin(glm::radians(std::max(lean, 0.0f))) + 0.0012f;
        if (x + room > width) return;
        const glm::mat4 at =
            placed({x + 0.5f * room, 0.5f * tall * std::cos(glm::radians(lean)) + 0.5f * thickness * std::abs(std::sin(glm::radians(lean))),
                    random.range(-0.016f, 0.012f)},
                   random.range(-1.2f, 1.2f), 0.0f, lean);
        model.add(make_book(thickness, tall, depth, random.below(kSpines - 1)), palette.books, place * at);
        x += room;
    }
}

}  // namespace parhelion::builtin
