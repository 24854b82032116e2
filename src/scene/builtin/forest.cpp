// A forest of any size: every tree has geometry of its own, so that it is as large in memory as it claims.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/parallel.h"
#include "scene/builtin/random.h"
#include "scene/builtin/scenes.h"
#include "scene/builtin/textures.h"
#include "scene/median_order.h"
#include "scene/shapes.h"

namespace parhelion::builtin {

namespace {

constexpr uint32_t kSeed = 1887u;
constexpr float kGoldenAngle = 2.39996323f;
constexpr float kSpacing = 2.7f;  // metres between trees, about
constexpr uint64_t kDefaultTriangles = 200'000;

struct Plan {
    uint32_t ground_cells = 1;  // along each side
    uint64_t tree_triangles = 0;
    uint32_t trees = 0;
    float radius = 0.0f;  // metres, of the wood
};

// A fiftieth is ground; trees grow finer with the square root of the number, until 20,000 triangles are enough for one.
Plan plan_forest(uint64_t triangles) {
    Plan plan;
    plan.ground_cells = uint32_t(std::clamp(std::sqrt(0.01 * double(triangles)), 1.0, 2048.0));
    const uint64_t ground = 2ull * plan.ground_cells * plan.ground_cells;
    plan.tree_triangles = triangles > ground ? triangles - ground : 0;
    const double each = std::clamp(8.0 * std::sqrt(double(triangles)), 500.0, 20'000.0);
    plan.trees = uint32_t(std::max(1.0, std::round(double(plan.tree_triangles) / each)));
    plan.radius = kSpacing * std::sqrt(float(plan.trees) + 3.0f);
    return plan;
}

float ground_height(glm::vec2 p) { return 3.0f * (fractal_noise(p / 30.0f + 512.0f, {1024, 1024}, 4, 3u) - 0.5f); }

Primitive make_ground(const Plan& plan) {
    const uint32_t n = plan.ground_cells;
    const float half = plan.radius + 30.0f;
    Primitive ground;
    const size_t vertices = size_t(n + 1) * (n + 1);
    ground.positions.resize(vertices);
    ground.normals.resize(vertices);
    ground.uv0.resize(vertices);
    parallel_for(n + 1, 16, [&](size_t begin, size_t end) {
        for (size_t row = begin; row < end; ++row)
            for (uint32_t column = 0; column <= n; ++column) {
                const size_t i = row * (n + 1) + column;
                const glm::vec2 p(half * (2.0f * float(column) / float(n) - 1.0f), half * (1.0f - 2.0f * float(row) / float(n)));
                constexpr float kStep = 0.25f;
                const float dx = ground_height(p + glm::vec2(kStep, 0.0f)) - ground_height(p - glm::vec2(kStep, 0.0f));
                const float dz = ground_height(p + glm::vec2(0.0f, kStep)) - ground_height(p - glm::vec2(0.0f, kStep));
                ground.positions[i] = {p.x, ground_height(p), p.y};
                ground.normals[i] = glm::normalize(glm::vec3(-dx, 2.0f * kStep, -dz));
                ground.uv0[i] = 0.25f * p;
            }
    });
    for (uint32_t row = 0; row < n; ++row)
        for (uint32_t column = 0; column < n; ++column) {
            const uint32_t a = row * (n + 1) + column, b = a + n + 1;
            ground.triangles.emplace_back(a, a + 1, b + 1);
            ground.triangles.emplace_back(a, b + 1, b);
        }
    return ground;
}

struct Materials {
    Handle<Material> ground, bark, broad_leaf, needle;
};

Materials add_materials(SceneEdit& edit) {
    Materials out;
    Material ground = glossy("forest floor", glm::vec3(1.0f), 0.0f, 0.95f);
    ground.base_color_texture = add_texture(
        edit,
        make_image("forest floor", 512, 512,
                   [](float u, float v) {
                       const float moss = fractal_noise({u * 5.0f, v * 5.0f}, {5, 5}, 5, 201u),
                                   litter = fractal_noise({u * 90.0f, v * 90.0f}, {90, 90}, 3, 202u);
                       const glm::vec3 brown = glm::mix(glm::vec3(0.24f, 0.17f, 0.10f), glm::vec3(0.55f, 0.42f, 0.26f), litter);
                       return glm::vec4(
                           glm::mix(brown, glm::vec3(0.25f, 0.34f, 0.12f) * (0.6f + 0.8f * litter), glm::smoothstep(0.42f, 0.6f, moss)),
                           1.0f);
                   }),
        ColorSpace::Srgb);
    out.ground = edit.add(std::move(ground));
    Material bark = glossy("bark", glm::vec3(1.0f), 0.0f, 0.9f);
    bark.base_color_texture = add_bark(edit);
    out.bark = edit.add(std::move(bark));
    Material leaf = glossy("leaves", glm::vec3(1.0f), 0.0f, 0.65f);
    leaf.base_color_texture = add_twig(edit);
    leaf.alpha_mode = AlphaMode::Mask;
    leaf.double_sided = true;
    out.broad_leaf = edit.add(leaf);
    leaf.name = "needles";
    leaf.base_color = {0.42f, 0.62f, 0.55f, 1.0f};
    out.needle = edit.add(std::move(leaf));
    return out;
}

// A tree as it grows: wood that counts its triangles, and limbs that leaves may sit on.
struct Tree {
    Random random;
    bool conifer = false;
    float height = 8.0f;
    Primitive wood, leaves;
    std::vector<std::vector<glm::vec3>> limbs;
};

std::vector<glm::vec3> limb_curve(Random& random, glm::vec3 base, glm::vec3 direction, float length, float lift, uint32_t points) {
    std::vector<glm::vec3> curve{base};
    for (uint32_t i = 1; i < points; ++i) {
        direction = glm::normalize(direction + glm::vec3(random.range(-0.2f, 0.2f), lift, random.range(-0.2f, 0.2f)));
        curve.push_back(curve.back() + direction * (length / float(points - 1)));
    }
    return curve;
}

void add_limb(Tree& tree, std::vector<glm::vec3> curve, float radius, uint32_t sides) {
    std::vector<float> radii;
    for (size_t i = 0; i < curve.size(); ++i) radii.push_back(radius * (1.0f - float(i) / float(curve.size() - 1)));
    append(tree.wood, make_tube(curve, radii, sides));
    tree.limbs.push_back(std::move(curve));
}

// Branches wind about the trunk by the golden angle; below the crown there are none. Stops at a third of the budget.
void grow_wood(Tree& tree, uint64_t budget) {
    Random& random = tree.random;
    const uint32_t sides = budget < 1000 ? 4u : budget < 6000 ? 7u : 10u, rows = budget < 1000 ? 4u : 8u;
    const float radius = tree.height * random.range(0.016f, 0.024f);
    add_limb(tree,
             limb_curve(random, {0.0f, -0.4f, 0.0f}, {random.range(-0.08f, 0.08f), 1.0f, random.range(-0.08f, 0.08f)}, tree.height + 0.4f,
                        0.6f, rows),
             radius, sides);
    const std::vector<glm::vec3> trunk = tree.limbs[0];
    tree.limbs.clear();
    const float crown = tree.conifer ? 0.14f : 0.32f, spread = tree.height * (tree.conifer ? 0.24f : 0.34f),
                turn = random.range(0.0f, float(kTurn));
    const uint32_t branches = uint32_t(std::clamp<uint64_t>(budget / 120, 5, 60));
    for (uint32_t i = 0; i < branches && 3 * tree.wood.triangles.size() < budget; ++i) {
        const float t = (float(i) + 0.5f) / float(branches), up = crown + (0.96f - crown) * t;
        const float at = up * float(trunk.size() - 1), angle = turn + kGoldenAngle * float(i);
        const size_t knot = std::min(size_t(at), trunk.size() - 2);
        const glm::vec3 base = glm::mix(trunk[knot], trunk[knot + 1], at - float(knot));
        const float reach = tree.conifer ? 1.02f - t : std::sqrt(std::max(0.05f, 1.0f - (1.7f * t - 0.7f) * (1.7f * t - 0.7f)));
        const float length = spread * reach * random.range(0.8f, 1.15f),
                    rise = tree.conifer ? random.range(-0.25f, 0.1f) : random.range(0.3f, 0.8f);
        const glm::vec3 direction = glm::normalize(glm::vec3(std::cos(angle), rise + (tree.conifer ? 0.0f : 0.9f * t), std::sin(angle)));
        const std::vector<glm::vec3> branch = limb_curve(random, base, direction, length, tree.conifer ? -0.08f : 0.12f, 5);
        add_limb(tree, branch, 0.35f * radius * std::sqrt(reach), 4);
        // Smaller ones at its joints, to both sides.
        for (uint32_t joint = 1; joint < 4 && budget > 1500; ++joint) {
            const glm::vec3 along = glm::normalize(branch[joint + 1] - branch[joint]);
            const glm::vec3 aside = glm::normalize(glm::cross(along, {0.0f, 1.0f, 0.0f}) + 1e-3f) * (joint % 2 == 0 ? 1.0f : -1.0f);
            add_limb(tree, limb_curve(random, branch[joint], glm::normalize(along + 1.1f * aside), 0.45f * length, 0.1f, 3), 0.15f * radius,
                     3);
        }
    }
}

// Cards on the outer part of the limbs, smaller where there are more of them, so that a fine tree is not a denser one.
void grow_leaves(Tree& tree, uint64_t cards) {
    Random& random = tree.random;
    const float area = (tree.conifer ? 2.2f : 3.6f) * tree.height * tree.height;
    const float size = std::clamp(std::sqrt(area / float(std::max<uint64_t>(cards, 1))), 0.05f, 1.5f);
    tree.leaves.positions.reserve(4 * cards);
    tree.leaves.uv0.reserve(4 * cards);
    tree.leaves.triangles.reserve(2 * cards);
    for (uint64_t i = 0; i < cards; ++i) {
        const std::vector<glm::vec3>& limb = tree.limbs[random.below(uint32_t(tree.limbs.size()))];
        const float at = (1.0f - 0.9f * random.unit() * random.unit()) * float(limb.size() - 1);
        const size_t knot = std::min(size_t(at), limb.size() - 2);
        const glm::vec3 along = glm::normalize(limb[knot + 1] - limb[knot]);
        const glm::vec3 drift(random.range(-1.0f, 1.0f), random.range(-1.0f, 1.0f), random.range(-1.0f, 1.0f));
        const glm::vec3 base = glm::mix(limb[knot], limb[knot + 1], at - float(knot)) + 0.25f * size * drift;
        const glm::vec3 tip = glm::normalize(
            along + 0.9f * glm::vec3(random.range(-1.0f, 1.0f), random.range(-1.0f, 0.6f), random.range(-1.0f, 1.0f)) + 1e-3f);
        const glm::vec3 across =
            glm::normalize(glm::cross(tip, glm::vec3(random.range(-0.5f, 0.5f), 1.0f, random.range(-0.5f, 0.5f))) + 1e-4f);
        const float length = size * random.range(0.8f, 1.25f);
        const glm::vec3 half = 0.45f * length * across;
        const uint32_t first = uint32_t(tree.leaves.positions.size());
        tree.leaves.positions.insert(tree.leaves.positions.end(),
                                     {base - half, base + half, base + length * tip + half, base + length * tip - half});
        tree.leaves.uv0.insert(tree.leaves.uv0.end(), {{0.0f, 1.0f}, {1.0f, 1.0f}, {1.0f, 0.0f}, {0.0f, 0.0f}});
        tree.leaves.triangles.emplace_back(first, first + 1, first + 2);
        tree.leaves.triangles.emplace_back(first, first + 2, first + 3);
    }
}

// Depends on its number and budget alone.
Mesh make_tree(uint32_t number, uint64_t budget, const Materials& materials) {
    Tree tree{.random = Random(kSeed, number)};
    tree.conifer = tree.random.unit() < 0.3f;
    tree.height = tree.conifer ? tree.random.range(7.0f, 13.0f) : tree.random.range(5.5f, 10.0f);
    Mesh mesh{.name = fmt::format("tree {}", number)};
    grow_wood(tree, budget);
    const uint64_t wood = tree.wood.triangles.size();
    if (budget > wood) grow_leaves(tree, (budget - wood) / 2);
    tree.wood.material = materials.bark;
    tree.leaves.material = tree.conifer ? materials.needle : materials.broad_leaf;
    for (Primitive* part : {&tree.wood, &tree.leaves})
        if (!part->triangles.empty()) {
            order_triangles_by_median(*part);
            mesh.primitives.push_back(std::move(*part));
        }
    return mesh;
}

// Pale at the horizon, blue above, green-brown below; the sun is a light of its own.
Environment forest_sky() {
    Environment sky{.name = "forest sky", .width = 16, .height = 64, .scale = glm::vec3(1.0f)};
    for (uint32_t row = 0; row < sky.height; ++row) {
        const float up = std::cos(float(std::numbers::pi) * (float(row) + 0.5f) / float(sky.height));
        const glm::vec3 nits = up < 0.0f
                                   ? glm::vec3(500.0f, 480.0f, 350.0f)
                                   : glm::mix(glm::vec3(5200.0f, 6200.0f, 7000.0f), glm::vec3(1300.0f, 2600.0f, 5400.0f), std::sqrt(up));
        sky.radiance.insert(sky.radiance.end(), sky.width, nits);
    }
    return sky;
}

// Rises in the east, stands 55 degrees high after 10 seconds, sets after 20. At rest the time is 6.
Light sun_at(double seconds, glm::quat& rotation) {
    const double day = seconds / 20.0 - std::floor(seconds / 20.0), height = glm::radians(3.0 + 52.0 * std::sin(0.5 * kTurn * day)),
                 way = kTurn * (0.05 + 0.4 * day);
    const glm::vec3 from(std::cos(height) * std::cos(way), std::sin(height), std::cos(height) * std::sin(way));
    rotation = glm::quatLookAt(-from, glm::vec3(0.0f, 1.0f, 0.0f));
    const float high = float(std::sin(height));
    return {.name = "sun",
            .kind = LightKind::Directional,
            .color = glm::mix(glm::vec3(1.0f, 0.45f, 0.18f), glm::vec3(1.0f, 0.93f, 0.82f), std::sqrt(high)),
            .intensity = 95'000.0f * std::min(1.0f, 2.0f * high),
            .angular_radius = 0.00465f};
}

struct Place {
    Handle<Node> node;
    glm::vec3 at;
    float turn;
};

}  // namespace

LoadedScene make_forest(const BuiltinOptions& options) {
    const Plan plan = plan_forest(options.triangles == 0 ? kDefaultTriangles : options.triangles);
    SceneEdit edit;
    const Materials materials = add_materials(edit);
    place_object(edit, "ground", make_ground(plan), materials.ground);

    std::vector<Mesh> meshes(plan.trees);
    const auto share = [&](uint64_t i) { return uint64_t(double(plan.tree_triangles) / plan.trees * double(i)); };
    parallel_for(plan.trees, 1, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) meshes[i] = make_tree(uint32_t(i), share(i + 1) - share(i), materials);
    });
    // The pattern of a sunflower, disturbed; its middle stays open.
    std::vector<Place> places;
    for (uint32_t i = 0; i < plan.trees; ++i) {
        Random random(kSeed + 1u, i);
        const float r = kSpacing * std::sqrt(float(i) + 3.0f) + random.range(-0.9f, 0.9f),
                    angle = kGoldenAngle * float(i) + random.range(-1.0f, 1.0f) / r;
        const glm::vec2 p(r * std::cos(angle), r * std::sin(angle));
        const Place place{{}, {p.x, ground_height(p), p.y}, random.range(0.0f, float(kTurn))};
        const Transform local{.translation = place.at, .rotation = glm::angleAxis(place.turn, glm::vec3(0.0f, 1.0f, 0.0f))};
        places.push_back({edit.add(Node{.name = meshes[i].name, .local = local}), place.at, place.turn});
        edit.add(Instance{.mesh = edit.add(std::move(meshes[i])), .place = {.node = places.back().node}});
    }
    glm::quat sun_rotation;
    Light sun = sun_at(6.0, sun_rotation);
    const Handle<Node> sun_node = edit.add(Node{.name = "sun", .local = {.rotation = sun_rotation}});
    sun.place.node = sun_node;
    const Handle<Light> sun_light = edit.add(std::move(sun));
    edit.set_environment(forest_sky());
    const float eye = ground_height({0.0f, 0.0f}) + 1.6f;
    add_camera(edit, "clearing", {0.0f, eye, 0.0f}, {6.0f, eye + 0.9f, -6.0f}, glm::radians(60.0f));
    add_camera(edit, "above", {0.7f * plan.radius, 16.0f + 0.45f * plan.radius, 0.9f * plan.radius}, {0.0f, 2.0f, 0.0f},
               glm::radians(45.0f));
    add_camera(edit, "crowns", {1.0f, eye - 0.8f, 1.0f}, {3.0f, eye + 5.0f, -2.0f}, glm::radians(75.0f));

    LoadedScene out;
    const ChangeSet changes = out.scene.apply(std::move(edit));
    for (Place& place : places) place.node = changes.resolve(place.node);
    out.scripted_edits.push_back(
        {"wind", "the trees sway", [places = std::move(places)](const Scene&, double seconds) {
             SceneEdit step;
             for (const Place& place : places) {
                 const double phase = 0.11 * double(place.at.x) + 0.07 * double(place.at.z);
                 const double lean = 0.02 * std::sin(kTurn * (seconds / 3.1) - phase) +
                                     0.012 * std::sin(kTurn * (seconds / 1.3) - 2.0 * phase + double(place.turn));
                 const glm::quat sway = glm::angleAxis(float(lean), glm::normalize(glm::vec3(0.55f, 0.0f, -0.83f)));
                 step.set_transform(place.node,
                                    {.translation = place.at, .rotation = sway * glm::angleAxis(place.turn, glm::vec3(0.0f, 1.0f, 0.0f))});
             }
             return step;
         }});
    out.scripted_edits.push_back({"sun", "the sun rises and sets within 20 seconds",
                                  [node = changes.resolve(sun_node), light = changes.resolve(sun_light)](const Scene&, double seconds) {
                                      Transform local;
                                      SceneEdit step;
                                      step.set_light(light, sun_at(seconds, local.rotation));
                                      step.set_transform(node, local);
                                      return step;
                                  }});
    return out;
}

}  // namespace parhelion::builtin
