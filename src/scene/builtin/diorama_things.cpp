// Plants, fairy lights and toys of the diorama.
#include <cmath>

#include "scene/builtin/diorama.h"
#include "scene/builtin/random.h"

namespace parhelion::builtin {

namespace {


void add_pot(Model& model, const Palette& palette, float radius, float height, Handle<Material> material) {
    const float r = radius, h = height;
    const glm::vec2 pot[] = {{0.0f, 0.0f},          {0.72f * r, 0.0f},      {0.75f * r, 0.02f * h}, {0.94f * r, 0.80f * h},
                             {1.0f * r, 0.82f * h}, {1.03f * r, 0.85f * h}, {1.03f * r, 0.97f * h}, {1.0f * r, h},
                             {0.93f * r, h},        {0.90f * r, 0.86f * h}};
    model.add(make_lathe(pot, 48), material);
    Primitive soil;
    const glm::vec2 earth[] = {{0.91f * r, 0.87f * h}, {0.5f * r, 0.90f * h}, {0.0f, 0.92f * h}};
    soil = make_lathe(earth, 32);
    model.add(soil, palette.soil);
}

// Leaves on stems that rise from the pot and lean outwards.
void add_leaves(Model& model, const Palette& palette, Random& random, int count, float base, float reach, float leaf,
                Handle<Material> material) {
    for (int i = 0; i < count; ++i) {
        const float angle = 2.39996f * float(i) + random.range(-0.3f, 0.3f), t = float(i) / float(count);
        const glm::vec3 out(std::cos(angle), 0.0f, std::sin(angle)), aside(-out.z, 0.0f, out.x);
        const float wide = reach * random.range(0.25f, 0.5f) * (1.1f - 0.6f * t),
                    tall = reach * (0.45f + 0.65f * t) * random.range(0.85f, 1.1f);
        const glm::vec3 knots[] = {0.03f * out + glm::vec3(0.0f, base, 0.0f),
                                   0.25f * wide * out + glm::vec3(0.0f, base + 0.6f * tall, 0.0f),
                                   wide * out + glm::vec3(0.0f, base + tall, 0.0f)};
        const std::vector<glm::vec3> stem = smooth_curve(knots, 6);
        const float radius[] = {0.0045f};
        model.add(make_tube(stem, radius, 6), palette.stem);
        const float size = leaf * random.range(0.75f, 1.2f);
        const glm::vec3 along =
            size * glm::normalize(out + glm::vec3(0.0f, random.range(-0.25f, 0.45f), 0.0f) + 0.3f * random.range(-1.0f, 1.0f) * aside);
        const glm::vec3 across =
            0.72f * size * glm::normalize(glm::cross(glm::vec3(0.0f, 1.0f, 0.0f) + 0.3f * random.range(-1.0f, 1.0f) * aside, along));
        Primitive card;
        add_leaf_card(card, stem.back(), along, across, 0.35f * size, 6);
        model.add(card, material);
    }
}

Primitive make_capsule(float radius, float height) {
    // From the joint at the origin down.
    const glm::vec2 profile[] = {{0.0f, -height - radius}, {0.6f * radius, -height - 0.8f * radius}, {radius, -height},
                                 {radius, 0.0f},           {0.6f * radius, 0.8f * radius},           {0.0f, radius}};
    return make_lathe(profile, 20);
}

void add_robot(SceneEdit& edit, const Palette& palette, DioramaHandles& handles) {
    Model body(palette);
    body.add(make_rounded_box({0.11f, 0.105f, 0.075f}, 0.014f, 3), palette.toy_body, placed({0.0f, 0.140f, 0.0f}));
    body.add(make_rounded_box({0.066f, 0.05f, 0.01f}, 0.004f), palette.toy_trim, placed({0.0f, 0.148f, 0.037f}));
    for (const float x : {-0.018f, 0.0f, 0.018f}) body.add(make_sphere(0.006f, 8, true), palette.brass, placed({x, 0.158f, 0.043f}));
    body.add(make_cylinder(0.02f, 0.016f, 0.003f, 20), palette.steel, placed({0.0f, 0.190f, 0.0f}));
    body.add(make_rounded_box({0.088f, 0.066f, 0.07f}, 0.014f, 3), palette.toy_body, placed({0.0f, 0.236f, 0.0f}, 9.0f, -3.0f));
    for (const float side : {-1.0f, 1.0f}) {
        const glm::vec3 eye(side * 0.021f + 0.005f, 0.243f, 0.034f);
        body.add(make_torus(0.0135f, 0.003f, 24, 8), palette.steel, placed(eye, 9.0f, 87.0f));
        body.add(make_sphere(0.0125f, 12, true), palette.toy_eye, placed(eye - glm::vec3(0.0f, 0.0f, 0.002f)));
        body.add(make_cylinder(0.012f, 0.012f, 0.003f, 18), palette.toy_trim,
                 placed({side * 0.042f, 0.236f, side * -0.006f}, 9.0f, 0.0f, side * -90.0f));
    }
    const glm::vec3 antenna[] = {{0.0f, 0.265f, 0.0f}, {0.004f, 0.300f, 0.0f}};
    const float radius[] = {0.002f};
    body.add(make_tube(antenna, radius, 8), palette.steel);
    body.add(make_sphere(0.008f, 10, true), palette.toy_trim, placed({0.004f, 0.304f, 0.0f}));
    // A key to wind it up.
    body.add(make_torus(0.014f, 0.004f, 20, 8), palette.brass, placed({0.0f, 0.145f, -0.065f}, 90.0f, 90.0f));
    body.add(make_cylinder(0.004f, 0.03f, 0.001f, 10), palette.brass, placed({0.0f, 0.145f, -0.03f}, 0.0f, -90.0f));
    handles.robot = body.place(edit, "robot", robot_at(0.0));
    for (const int side : {0, 1}) {
        Model arm(palette), leg(palette);
        arm.add(make_sphere(0.015f, 12, true), palette.steel);
        arm.add(make_capsule(0.010f, 0.06f), palette.toy_body, placed({side == 0 ? -0.006f : 0.006f, -0.006f, 0.0f}));
        arm.add(make_torus(0.011f, 0.0045f, 20, 8), palette.toy_trim,
                placed({side == 0 ? -0.006f : 0.006f, -0.088f, 0.0f}, 0.0f, 0.0f, 90.0f));
        handles.arms[side] = arm.place(edit, side == 0 ? "left arm" : "right arm", robot_limb_at(0.0, false, side), handles.robot);
        leg.add(make_capsule(0.013f, 0.045f), palette.steel);
        leg.add(make_rounded_box({0.042f, 0.024f, 0.066f}, 0.009f, 3), palette.toy_trim, placed({0.0f, -kRobotHip.y + 0.012f, 0.010f}));
        handles.legs[side] = leg.place(edit, side == 0 ? "left leg" : "right leg", robot_limb_at(0.0, true, side), handles.robot);
    }
}

}  // namespace

void add_plants(SceneEdit& edit, const Palette& palette) {
    Random random(9u);
    Model tall(palette), sill(palette), shelf(palette);
    add_pot(tall, palette, 0.17f, 0.30f, palette.ceramic);
    add_leaves(tall, palette, random, 26, 0.26f, 0.95f, 0.26f, palette.leaf);
    tall.place(edit, "tall plant", {.translation = {-1.66f, 0.0f, -1.42f}});
    add_pot(sill, palette, 0.075f, 0.12f, palette.terracotta);
    add_leaves(sill, palette, random, 22, 0.10f, 0.19f, 0.10f, palette.fern);
    sill.place(edit, "plant on the sill", {.translation = {kNookMin.x + 0.065f, kWindowLow + 0.023f, -0.78f}});
    add_pot(shelf, palette, 0.085f, 0.14f, palette.glaze);
    add_leaves(shelf, palette, random, 30, 0.11f, 0.24f, 0.12f, palette.fern);
    shelf.place(edit, "plant on the shelf", {.translation = {kNookMax.x - 0.28f, 2.006f, kNookMin.z + 0.19f}});
}

// A cord along the back wall that sags between hooks, with a bulb every 15 cm.
void add_fairy_lights(SceneEdit& edit, const Palette& palette, DioramaHandles& handles) {
    const glm::vec3 hooks[] = {{-2.03f, 2.34f, -1.765f}, {-1.15f, 2.38f, -1.765f}, {-0.3f, 2.33f, -1.765f},
                               {0.55f, 2.38f, -1.765f},  {1.2f, 2.34f, -1.765f},   {2.04f, 2.36f, -1.755f}};
    Model cord(palette);
    const Primitive bulb = make_sphere(0.0125f, 8, true);
    for (size_t i = 0; i + 1 < std::size(hooks); ++i) {
        std::vector<glm::vec3> points;
        constexpr int kSteps = 24;
        for (int s = 0; s <= kSteps; ++s) {
            const float t = float(s) / kSteps;
            points.push_back(glm::mix(hooks[i], hooks[i + 1], t) -
                             glm::vec3(0.0f, 0.17f * 4.0f * t * (1.0f - t), -0.01f * std::sin(7.0f * t)));
        }
        const float radius[] = {0.0022f};
        cord.add(make_tube(points, radius, 6), palette.cord);
        cord.add(make_sphere(0.008f, 8, true), palette.brass, placed(hooks[i]));
        for (int s = 2; s < kSteps; s += 4) {
            const glm::vec3 at = points[size_t(s)] - glm::vec3(0.0f, 0.024f, 0.0f);
            cord.add(make_cylinder(0.006f, 0.018f, 0.0015f, 10), palette.cord, placed(at + glm::vec3(0.0f, 0.008f, 0.0f)));
            const std::string name = fmt::format("bulb {}", handles.bulbs.size());
            handles.bulbs.push_back(place_object(edit, name, bulb, palette.bulb, {.translation = at}));
            handles.bulb_places.push_back(at);
        }
    }
    cord.place(edit, "fairy lights");
}

void add_toys(SceneEdit& edit, const Palette& palette, DioramaHandles& handles) {
    add_robot(edit, palette, handles);
    Model ball(palette);
    ball.add(make_sphere(0.105f, 28, true), palette.ball);
    handles.ball = ball.place(edit, "ball", ball_at(0.0));
}

// There and back across the floor, once in 8 seconds, slow at the ends.
Transform ball_at(double seconds) {
    const double way = 0.75 * (1.0 - std::cos(kTurn * seconds / 8.0)), radius = 0.105;
    const glm::dvec2 direction(-0.85, 0.53);
    const glm::dvec2 at = glm::dvec2(0.80, -0.12) + way * direction;
    const glm::quat rest = glm::angleAxis(0.9f, glm::normalize(glm::vec3(1.0f, 0.3f, 0.6f)));
    const glm::quat roll = glm::angleAxis(float(way / radius), glm::normalize(glm::vec3(direction.y, 0.0f, -direction.x)));
    return {.translation = {float(at.x), float(radius) + 0.012f, float(at.y)}, .rotation = roll * rest};
}

// Walks in a circle on the rug, once round in 12 seconds.
Transform robot_at(double seconds) {
    const double angle = 2.2 - kTurn * seconds / 12.0;
    const glm::dvec3 middle(-0.22, 0.0125, 0.16);
    Transform t;
    t.translation = glm::vec3(middle + 0.34 * glm::dvec3(std::sin(angle), 0.0, std::cos(angle)));
    t.translation.y += float(0.004 * std::abs(std::sin(kTurn * seconds * 1.5)));
    t.rotation = glm::angleAxis(float(angle - 0.25 * kTurn), glm::vec3(0.0f, 1.0f, 0.0f)) *
                 glm::angleAxis(float(0.04 * std::sin(kTurn * seconds * 1.5)), glm::vec3(0.0f, 0.0f, 1.0f));
    return t;
}

Transform robot_limb_at(double seconds, bool leg, int side) {
    const float sign = side == 0 ? -1.0f : 1.0f;
    const double swing = std::sin(kTurn * seconds * 1.5) * (leg ? 0.45 : -0.6) + (leg ? 0.0 : -0.15);
    Transform t;
    t.translation = (leg ? kRobotHip : kRobotShoulder) * glm::vec3(sign, 1.0f, 1.0f);
    t.rotation = glm::angleAxis(float(double(sign) * swing), glm::vec3(1.0f, 0.0f, 0.0f));
    return t;
}

}  // namespace parhelion::builtin
