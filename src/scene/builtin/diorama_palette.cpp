// Materials of the diorama.
#include "scene/builtin/diorama.h"

#include <algorithm>
#include <cmath>

#include "scene/builtin/textures.h"
#include "scene/median_order.h"
#include "scene/tangents.h"

namespace parhelion::builtin {

namespace {

// UVs in metres, one image on so many of them.
TextureRef tiled(TextureRef ref, float metres) {
    ref.scale = glm::vec2(1.0f / metres);
    return ref;
}

class PaletteMaker {
public:
    explicit PaletteMaker(SceneEdit& edit) : edit_(edit) {}
    Handle<Material> plain(std::string name, glm::vec3 color, float roughness, float metallic = 0.0f) {
        return edit_.add(glossy(std::move(name), color, metallic, roughness));
    }
    Handle<Material> mapped(std::string name, const SurfaceMaps& maps, float metres, float roughness, float normal_scale = 1.0f,
                            bool double_sided = false) {
        Material m =
            glossy(std::move(name), glm::vec3(1.0f), maps.metal_rough.texture ? 1.0f : 0.0f, maps.metal_rough.texture ? 1.0f : roughness);
        m.base_color_texture = tiled(maps.color, metres);
        if (maps.normal.texture) m.normal_texture = tiled(maps.normal, metres);
        if (maps.metal_rough.texture) m.metal_rough_texture = tiled(maps.metal_rough, metres);
        m.normal_scale = normal_scale;
        m.double_sided = double_sided;
        const Handle<Material> handle = edit_.add(std::move(m));
        if (maps.normal.texture) palette.normal_mapped.push_back(handle);
        return handle;
    }
    Handle<Material> leaf(std::string name, glm::vec3 color) {
        Material m = glossy(name, glm::vec3(1.0f), 0.0f, 0.45f);
        m.base_color_texture = add_broad_leaf(edit_, color, name);
        m.alpha_mode = AlphaMode::Mask;
        m.double_sided = true;
        return edit_.add(std::move(m));
    }
    Handle<Material> metal(std::string name, glm::vec3 color, float roughness, TextureRef smudges) {
        Material m = glossy(std::move(name), color, 1.0f, roughness);
        m.metal_rough_texture = tiled(smudges, 0.4f);
        return edit_.add(std::move(m));
    }
    Handle<Material> picture(std::string name, TextureRef image, float roughness) {
        Material m = glossy(std::move(name), glm::vec3(1.0f), 0.0f, roughness);
        m.base_color_texture = image;
        return edit_.add(std::move(m));
    }
    Handle<Material> glowing(std::string name, glm::vec3 color, glm::vec3 nits) {
        Material m = glossy(std::move(name), color, 0.0f, 0.6f);
        m.emission = nits;
        return edit_.add(std::move(m));
    }

    Palette palette;

private:
    SceneEdit& edit_;
};

// Tall enough for light to fade towards the rims, as on a shade whose bulb is in the middle.
TextureRef add_shade_glow(SceneEdit& edit) {
    return add_texture(edit,
                       make_image("shade glow", 32, 64,
                                  [](float, float v) {
                                      const float glow = 0.45f + 0.55f * std::exp(-12.0f * (v - 0.55f) * (v - 0.55f));
                                      return glm::vec4(glow * glm::vec3(1.0f, 0.97f, 0.93f), 1.0f);
                                  }),
                       ColorSpace::Srgb, {.wrap_v = Wrap::ClampToEdge});
}

TextureRef add_stripes(SceneEdit& edit) {
    return add_texture(edit,
                       make_image("ball stripes", 128, 64,
                                  [](float u, float v) {
                                      const glm::vec3 colors[3] = {{0.85f, 0.20f, 0.14f}, {0.95f, 0.88f, 0.70f}, {0.13f, 0.38f, 0.55f}};
                                      if (v < 0.07f || v > 0.93f) return glm::vec4(colors[1], 1.0f);
                                      return glm::vec4(colors[int(u * 6.0f) % 3], 1.0f);
                                  }),
                       ColorSpace::Srgb);
}

void add_lights(PaletteMaker& make, SceneEdit& edit) {
    make.palette.bulb = make.glowing("fairy bulb", glm::vec3(0.9f, 0.8f, 0.6f), glm::vec3(7500.0f, 4700.0f, 2100.0f));
    make.palette.toy_eye = make.glowing("robot eye", glm::vec3(0.2f, 0.5f, 0.6f), glm::vec3(200.0f, 900.0f, 1100.0f));
    Material shade = glossy("lamp shade", {0.85f, 0.78f, 0.65f}, 0.0f, 0.9f);
    shade.emission = glm::vec3(1300.0f, 850.0f, 440.0f);
    shade.emissive_texture = add_shade_glow(edit);
    shade.emissive_texture.scale = {1.0f, 1.0f / 0.33f};
    shade.double_sided = true;
    make.palette.shade = edit.add(std::move(shade));
}

Handle<Material> add_glass(SceneEdit& edit) {
    Material glass = glossy("blue glass", glm::vec3(1.0f), 0.0f, 0.0f);
    glass.transmission = 1.0f;
    glass.ior = 1.5f;
    glass.thickness = 0.004f;
    glass.attenuation_distance = 0.02f;
    glass.attenuation_color = {0.45f, 0.75f, 0.8f};
    return edit.add(std::move(glass));
}

}  // namespace

Palette add_palette(SceneEdit& edit) {
    PaletteMaker make(edit);
    Palette& p = make.palette;
    p.floor = make.mapped("oak floor", add_plank_floor(edit), 2.4f, 0.4f);
    p.plaster = make.mapped("plaster", add_plaster(edit, {0.575f, 0.64f, 0.595f}), 1.2f, 0.9f, 0.7f);
    p.paint = make.plain("white paint", {0.76f, 0.73f, 0.66f}, 0.5f);
    p.ceiling = make.plain("ceiling", {0.78f, 0.76f, 0.71f}, 0.9f);
    p.walnut = make.mapped("walnut", add_wood(edit, {0.47f, 0.30f, 0.19f}, {0.22f, 0.12f, 0.07f}, "walnut grain"), 0.6f, 0.5f);
    p.oak = make.mapped("oak", add_wood(edit, {0.74f, 0.55f, 0.35f}, {0.50f, 0.33f, 0.19f}, "oak grain"), 0.6f, 0.5f);
    p.rug = make.picture("kilim", add_rug(edit), 0.95f);
    p.chair = make.mapped("mustard cloth", add_weave(edit, {0.86f, 0.60f, 0.20f}, "mustard weave"), 0.16f, 0.85f);
    p.pillow = make.mapped("blue cloth", add_weave(edit, {0.20f, 0.36f, 0.44f}, "blue weave"), 0.16f, 0.85f);
    p.linen = make.mapped("linen", add_weave(edit, {0.97f, 0.93f, 0.84f}, "linen weave"), 0.16f, 0.9f, 0.6f, true);
    p.paper = make.plain("paper", {0.80f, 0.76f, 0.66f}, 0.9f);
    const TextureRef smudges = add_smudges(edit);
    p.brass = make.metal("brass", {0.88f, 0.66f, 0.34f}, 0.38f, smudges);
    p.copper = make.metal("copper", {0.93f, 0.56f, 0.40f}, 0.34f, smudges);
    p.steel = make.metal("steel", {0.62f, 0.61f, 0.59f}, 0.4f, smudges);
    p.ceramic = make.plain("white ceramic", {0.80f, 0.77f, 0.70f}, 0.15f);
    p.glaze = make.plain("blue glaze", {0.06f, 0.16f, 0.28f}, 0.18f);
    p.glass = add_glass(edit);
    p.terracotta = make.plain("terracotta", {0.56f, 0.25f, 0.14f}, 0.8f);
    p.soil = make.plain("soil", {0.055f, 0.037f, 0.025f}, 1.0f);
    p.cord = make.plain("cord", {0.03f, 0.03f, 0.028f}, 0.6f);
    p.leaf = make.leaf("broad leaf", {0.16f, 0.36f, 0.15f});
    p.fern = make.leaf("fern leaf", {0.36f, 0.52f, 0.20f});
    p.stem = make.plain("stem", {0.13f, 0.22f, 0.06f}, 0.6f);
    p.petal = make.plain("red petal", {0.72f, 0.10f, 0.08f}, 0.5f);
    p.petal_pale = make.plain("pale petal", {0.85f, 0.55f, 0.32f}, 0.5f);
    p.painting = make.picture("painting", add_painting(edit), 0.55f);
    p.books = make.picture("books", add_book_spines(edit), 0.6f);
    p.toy_body = make.plain("robot paint", {0.10f, 0.36f, 0.38f}, 0.32f);
    p.toy_trim = make.plain("robot trim", {0.80f, 0.28f, 0.06f}, 0.35f);
    p.ball = make.picture("ball", add_stripes(edit), 0.35f);
    add_lights(make, edit);
    return p;
}

glm::mat4 placed(glm::vec3 at, float yaw, float pitch, float roll) {
    const auto about = [](float degrees, glm::vec3 axis) { return glm::angleAxis(glm::radians(degrees), axis); };
    Transform t{.translation = at,
                .rotation = about(yaw, {0.0f, 1.0f, 0.0f}) * about(pitch, {1.0f, 0.0f, 0.0f}) * about(roll, {0.0f, 0.0f, 1.0f})};
    return matrix_of(t);
}

void Model::add(const Primitive& part, Handle<Material> material, const glm::mat4& place) {
    auto found = std::find_if(primitives_.begin(), primitives_.end(), [&](const Primitive& p) { return p.material == material; });
    if (found == primitives_.end()) {
        primitives_.emplace_back().material = material;
        found = primitives_.end() - 1;
    }
    Primitive bare = part;
    bare.tangents.clear();
    append(*found, bare, place);
}

void Model::add_box(glm::vec3 size, glm::vec3 middle, Handle<Material> material, float radius, float yaw) {
    Primitive box = make_rounded_box(size, radius);
    // Wood is not cut from the same spot twice, and its grain runs along the longest edge.
    const bool upright = size.y > size.x && size.y > size.z, deep = !upright && size.z > size.x;
    for (size_t i = 0; i < box.uv0.size(); ++i) {
        const bool lying = std::abs(box.normals[i].y) > 0.7f;
        if ((upright && !lying) || (deep && lying)) std::swap(box.uv0[i].x, box.uv0[i].y);
        box.uv0[i] += glm::vec2(1.7f * middle.x + 0.9f * middle.z, 2.3f * middle.y + 1.1f * middle.x);
    }
    add(box, material, placed(middle, yaw));
}

Handle<Node> Model::place(SceneEdit& edit, const std::string& name, const Transform& local, Handle<Node> parent) {
    const Handle<Node> node = edit.add(Node{.name = name, .parent = parent, .local = local});
    Mesh mesh{.name = name};
    for (Primitive& primitive : primitives_) {
        const auto& mapped = palette_.normal_mapped;
        if (std::find(mapped.begin(), mapped.end(), primitive.material) != mapped.end()) generate_tangents(primitive, 0);
        order_triangles_by_median(primitive);
        mesh.primitives.push_back(std::move(primitive));
    }
    edit.add(Instance{.mesh = edit.add(std::move(mesh)), .place = {.node = node}});
    return node;
}

}  // namespace parhelion::builtin
