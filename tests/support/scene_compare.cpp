#include "support/scene_compare.h"

#include <algorithm>
#include <cstring>
#include <unordered_map>

namespace parhelion::testing {

namespace {

struct Differs {
    std::string text;
};
[[noreturn]] void differ(const std::string& where, const std::string& what) { throw Differs{where + ": " + what}; }

template <class T>
bool same_bits(const T& a, const T& b) {
    return std::memcmp(&a, &b, sizeof(T)) == 0;
}

template <class T>
void expect(const std::string& where, const T& a, const T& b) {
    if constexpr (std::is_trivially_copyable_v<T>) {
        if (!same_bits(a, b)) differ(where, "differs");
    } else {
        if (!(a == b)) differ(where, "differs");
    }
}
void expect(const std::string& where, const std::string& a, const std::string& b) {
    if (a != b) differ(where, fmt::format("'{}' and '{}'", a, b));
}
template <class T>
void expect_array(const std::string& where, const std::vector<T>& a, const std::vector<T>& b) {
    if (a.size() != b.size()) differ(where, fmt::format("{} and {} elements", a.size(), b.size()));
    for (size_t i = 0; i < a.size(); ++i)
        if (!same_bits(a[i], b[i])) differ(where, fmt::format("element {} differs", i));
}

// One to one.
template <class T>
class Pairs {
public:
    // True the first time.
    bool pair(const std::string& where, Handle<T> a, Handle<T> b) {
        if (bool(a) != bool(b)) differ(where, a ? "missing" : "there, but not expected");
        if (!a) return false;
        const auto [forward, new_a] = forward_.emplace(a, b);
        const auto [backward, new_b] = backward_.emplace(b, a);
        if (forward->second != b || backward->second != a) differ(where, "is another one");
        return new_a;
    }

private:
    std::unordered_map<Handle<T>, Handle<T>> forward_, backward_;
};

class Comparer {
public:
    Comparer(const Scene& a, const Scene& b) : a_(a), b_(b) {}

    void compare() {
        expect("copyright", a_.source().copyright, b_.source().copyright);
        expect("variants", a_.source().variants, b_.source().variants);
        const std::vector<Handle<Node>> roots_a = roots(a_), roots_b = roots(b_);
        expect_at_least("roots", roots_a.size(), roots_b.size());
        for (size_t i = 0; i < roots_a.size(); ++i) nodes(fmt::format("root {}", i), roots_a[i], roots_b[i]);
        size_t helper = roots_a.size();
        homeless<Instance>(roots_b, helper);
        homeless<Camera>(roots_b, helper);
        homeless<Light>(roots_b, helper);
        if (helper != roots_b.size()) differ("roots", fmt::format("{} too many", roots_b.size() - helper));
        for (const auto& [skin_a, skin_b] : skins_) skins(a_.get(skin_a), b_.get(skin_b));
        animations();
    }

private:
    static std::vector<Handle<Node>> roots(const Scene& scene) {
        std::vector<Handle<Node>> out;
        for (const auto& [handle, node] : scene.nodes())
            if (!node.parent) out.push_back(handle);
        return out;
    }
    static void expect_at_least(const std::string& where, size_t a, size_t b) {
        if (b < a) differ(where, fmt::format("{} and {}", a, b));
    }

    template <class T>
    static const std::vector<Handle<T>>& carried(const Node& node) {
        if constexpr (std::is_same_v<T, Instance>)
            return node.instances;
        else if constexpr (std::is_same_v<T, Camera>)
            return node.cameras;
        else
            return node.lights;
    }

    void nodes(const std::string& where, Handle<Node> handle_a, Handle<Node> handle_b) {
        node_pairs_.pair(where, handle_a, handle_b);
        const Node &a = a_.get(handle_a), &b = b_.get(handle_b);
        const std::string here = where + (a.name.empty() ? "" : " '" + a.name + "'");
        expect(here + " name", a.name, b.name);
        if (a.local.matrix.has_value() != b.local.matrix.has_value()) differ(here, "matrix in one only");
        if (a.local.matrix) {
            expect(here + " matrix", *a.local.matrix, *b.local.matrix);
        } else {
            expect(here + " translation", a.local.translation, b.local.translation);
            expect(here + " rotation", a.local.rotation, b.local.rotation);
            expect(here + " scale", a.local.scale, b.local.scale);
        }
        expect(here + " world", a.world_from_node, b.world_from_node);
        expect(here + " visible", a.visible, b.visible);
        expect_at_least(here + " children", a.children.size(), b.children.size());
        for (size_t i = 0; i < a.children.size(); ++i) nodes(fmt::format("{} > {}", here, i), a.children[i], b.children[i]);
        size_t helper = a.children.size();
        contents<Instance>(here, a, b, helper);
        contents<Camera>(here, a, b, helper);
        contents<Light>(here, a, b, helper);
        if (helper != b.children.size()) differ(here + " children", fmt::format("{} too many", b.children.size() - helper));
    }

    // The one thing on a nameless leaf.
    template <class T>
    Handle<T> on_helper(const std::string& where, const std::vector<Handle<Node>>& nodes, size_t index) {
        if (index >= nodes.size()) differ(where, "missing");
        const Node& node = b_.get(nodes[index]);
        const size_t all = node.instances.size() + node.cameras.size() + node.lights.size();
        if (!node.name.empty() || !node.children.empty() || all != 1 || carried<T>(node).empty()) differ(where, "is not on a node of its own");
        return carried<T>(node).front();
    }

    template <class T>
    void contents(const std::string& where, const Node& a, const Node& b, size_t& helper) {
        std::vector<Handle<T>> mine = carried<T>(a);
        const auto at_origin = std::ranges::find_if(mine, [&](Handle<T> h) { return same_bits(a_.get(h).place.node_from_object, glm::mat4(1.0f)); });
        size_t direct = 0;
        const std::vector<Handle<T>>& theirs = carried<T>(b);
        if (at_origin != mine.end() && theirs.size() != mine.size()) std::rotate(mine.begin(), at_origin, at_origin + 1), direct = 1;
        for (size_t i = 0; i < mine.size(); ++i) {
            const std::string here = fmt::format("{} {} {}", where, T::kTypeName, i);
            const bool same_node = theirs.size() == mine.size() || i < direct;
            if (same_node && i >= theirs.size()) differ(here, "missing");
            values(here, mine[i], same_node ? theirs[i] : on_helper<T>(here, b.children, helper++), a.name);
        }
        if (theirs.size() > std::max(direct, mine.size())) differ(where, fmt::format("has too many of {}", T::kTypeName));
    }

    template <class T>
    void homeless(const std::vector<Handle<Node>>& roots_b, size_t& helper) {
        std::vector<Handle<T>> theirs;
        for (const auto& [handle, value] : b_.all<T>())
            if (!value.place.node) theirs.push_back(handle);
        size_t i = 0;
        for (const auto& [handle, value] : a_.all<T>()) {
            if (value.place.node) continue;
            const std::string where = fmt::format("{} {} of no node", T::kTypeName, i);
            values(where, handle, i < theirs.size() ? theirs[i] : on_helper<T>(where, roots_b, helper++), "");
            ++i;
        }
    }

    // By value: where a node of its own has a product to make, zeros lose their sign.
    static void expect_place(const std::string& where, const Placement& a, const Placement& b) {
        if (a.world_from_object != b.world_from_object) differ(where + " place", "differs");
    }

    void values(const std::string& where, Handle<Instance> handle_a, Handle<Instance> handle_b, const std::string&) {
        const Instance &a = a_.get(handle_a), &b = b_.get(handle_b);
        expect_place(where, a.place, b.place);
        if (mesh_pairs_.pair(where + " mesh", a.mesh, b.mesh)) meshes(fmt::format("{} mesh '{}'", where, a_.get(a.mesh).name), a_.get(a.mesh), b_.get(b.mesh));
        if (skin_pairs_.pair(where + " skin", a.skin, b.skin)) skins_.emplace_back(a.skin, b.skin);
        expect_array(where + " weights", a.weights, b.weights);
    }

    void values(const std::string& where, Handle<Camera> handle_a, Handle<Camera> handle_b, const std::string& node_name) {
        const Camera &a = a_.get(handle_a), &b = b_.get(handle_b);
        expect(where + " name", a.name.empty() ? node_name : a.name, b.name);
        expect_place(where, a.place, b.place);
        expect(where + " kind", a.kind, b.kind);
        expect(where + " near", a.near_plane, b.near_plane);
        if (a.kind == CameraKind::Perspective) {
            expect(where + " yfov", a.yfov, b.yfov);
            expect(where + " far", a.far_plane.value_or(0.0f), b.far_plane.value_or(0.0f));
        } else {
            expect(where + " xmag", a.xmag, b.xmag);
            expect(where + " ymag", a.ymag, b.ymag);
            expect(where + " far", a.far_plane.value_or(kLargestCoordinate), b.far_plane.value_or(kLargestCoordinate));
        }
    }

    void values(const std::string& where, Handle<Light> handle_a, Handle<Light> handle_b, const std::string& node_name) {
        const Light &a = a_.get(handle_a), &b = b_.get(handle_b);
        expect(where + " name", a.name.empty() ? node_name : a.name, b.name);
        expect_place(where, a.place, b.place);
        expect(where + " kind", a.kind, b.kind);
        expect(where + " color", a.color, b.color);
        expect(where + " intensity", a.intensity, b.intensity);
        if (a.kind == LightKind::Directional)
            expect(where + " angular radius", a.angular_radius, b.angular_radius);
        else
            expect(where + " range", a.range, b.range);
        if (a.kind != LightKind::Spot) return;
        expect(where + " inner cone", a.inner_cone, b.inner_cone);
        expect(where + " outer cone", a.outer_cone, b.outer_cone);
    }

    void meshes(const std::string& where, const Mesh& a, const Mesh& b) {
        expect(where + " name", a.name, b.name);
        expect_array(where + " weights", a.weights, b.weights);
        expect(where + " target names", a.target_names, b.target_names);
        if (a.primitives.size() != b.primitives.size()) differ(where, fmt::format("{} and {} primitives", a.primitives.size(), b.primitives.size()));
        for (size_t i = 0; i < a.primitives.size(); ++i) primitives(fmt::format("{} primitive {}", where, i), a.primitives[i], b.primitives[i]);
    }

    void primitives(const std::string& where, const Primitive& a, const Primitive& b) {
        expect_array(where + " positions", a.positions, b.positions);
        expect_array(where + " normals", a.normals, b.normals);
        expect_array(where + " tangents", a.tangents, b.tangents);
        expect_array(where + " uv0", a.uv0, b.uv0);
        expect_array(where + " uv1", a.uv1, b.uv1);
        expect_array(where + " colors", a.colors, b.colors);
        expect_array(where + " triangles", a.triangles, b.triangles);
        expect(where + " influences", a.influence_count, b.influence_count);
        expect_array(where + " joints", a.joints, b.joints);
        expect_array(where + " joint weights", a.joint_weights, b.joint_weights);
        if (a.targets.size() != b.targets.size()) differ(where, fmt::format("{} and {} morph targets", a.targets.size(), b.targets.size()));
        for (size_t i = 0; i < a.targets.size(); ++i) {
            const std::string target = fmt::format("{} target {}", where, i);
            expect_array(target + " positions", a.targets[i].positions, b.targets[i].positions);
            expect_array(target + " normals", a.targets[i].normals, b.targets[i].normals);
            expect_array(target + " tangents", a.targets[i].tangents, b.targets[i].tangents);
        }
        materials(where + " material", a.material, b.material);
        if (a.variant_materials.size() != b.variant_materials.size()) differ(where, "variants differ in number");
        for (size_t i = 0; i < a.variant_materials.size(); ++i)
            materials(fmt::format("{} variant {}", where, i), a.variant_materials[i], b.variant_materials[i]);
    }

    void materials(const std::string& where, Handle<Material> handle_a, Handle<Material> handle_b) {
        if (!material_pairs_.pair(where, handle_a, handle_b)) return;
        const Material &a = a_.get(handle_a), &b = b_.get(handle_b);
        const std::string here = fmt::format("{} '{}'", where, a.name);
        expect(here + " name", a.name, b.name);
        const auto same = [&](const char* name, auto Material::*field) { expect(fmt::format("{} {}", here, name), a.*field, b.*field); };
        using M = Material;
        same("base color", &M::base_color), same("metallic", &M::metallic), same("roughness", &M::roughness), same("emission", &M::emission);
        same("alpha mode", &M::alpha_mode), same("double sided", &M::double_sided), same("nested priority", &M::nested_priority), same("unlit", &M::unlit), same("ior", &M::ior);
        same("specular", &M::specular), same("specular color", &M::specular_color), same("transmission", &M::transmission);
        same("thickness", &M::thickness), same("attenuation distance", &M::attenuation_distance), same("attenuation color", &M::attenuation_color);
        same("dispersion", &M::dispersion), same("clearcoat", &M::clearcoat), same("clearcoat roughness", &M::clearcoat_roughness);
        same("sheen color", &M::sheen_color), same("sheen roughness", &M::sheen_roughness), same("anisotropy", &M::anisotropy);
        same("anisotropy rotation", &M::anisotropy_rotation), same("iridescence", &M::iridescence), same("iridescence ior", &M::iridescence_ior);
        same("iridescence thickness", &M::iridescence_thickness_min), same("iridescence thickness", &M::iridescence_thickness_max);
        // Factors that do nothing without their texture, or in another mode, are in no file.
        if (a.alpha_mode == AlphaMode::Mask) same("alpha cutoff", &M::alpha_cutoff);
        if (a.normal_texture.texture) same("normal scale", &M::normal_scale);
        if (a.occlusion_texture.texture) same("occlusion strength", &M::occlusion_strength);
        if (a.clearcoat_normal_texture.texture) same("clearcoat normal scale", &M::clearcoat_normal_scale);
        size_t i = 0;
        for (const MaterialTexture& use : material_textures()) texture_refs(fmt::format("{} texture {}", here, i++), a.*use.ref, b.*use.ref);
    }

    void texture_refs(const std::string& where, const TextureRef& a, const TextureRef& b) {
        if (!a.texture && !b.texture) return;
        if (texture_pairs_.pair(where, a.texture, b.texture)) textures(where, a_.get(a.texture), b_.get(b.texture));
        expect(where + " uv set", a.uv_set, b.uv_set);
        expect(where + " offset", a.offset, b.offset);
        expect(where + " scale", a.scale, b.scale);
        expect(where + " rotation", a.rotation, b.rotation);
    }

    void textures(const std::string& where, const Texture& a, const Texture& b) {
        expect(where + " name", a.name, b.name);
        expect(where + " sampler", a.sampler == b.sampler, true);
        expect(where + " color space", a.color_space, b.color_space);
        if (!image_pairs_.pair(where + " image", a.image, b.image)) return;
        const Image &image_a = a_.get(a.image), &image_b = b_.get(b.image);
        if (!image_a.name.empty()) expect(where + " image name", image_a.name, image_b.name);
        expect(where + " width", image_a.width, image_b.width);
        expect(where + " height", image_a.height, image_b.height);
        expect(where + " format", image_a.format, image_b.format);
        expect_array(where + " texels", image_a.texels, image_b.texels);
    }

    void skins(const Skin& a, const Skin& b) {
        const std::string where = fmt::format("skin '{}'", a.name);
        expect(where + " name", a.name, b.name);
        expect_array(where + " inverse bind", a.inverse_bind, b.inverse_bind);
        if (a.joints.size() != b.joints.size()) differ(where, "joints differ in number");
        for (size_t i = 0; i < a.joints.size(); ++i) node_pairs_.pair(fmt::format("{} joint {}", where, i), a.joints[i], b.joints[i]);
    }

    void animations() {
        std::vector<const Animation*> mine, theirs;
        for (const auto& [handle, animation] : a_.animations()) mine.push_back(&animation);
        for (const auto& [handle, animation] : b_.animations()) theirs.push_back(&animation);
        if (mine.size() != theirs.size()) differ("animations", fmt::format("{} and {}", mine.size(), theirs.size()));
        for (size_t i = 0; i < mine.size(); ++i) {
            const std::string where = fmt::format("animation '{}'", mine[i]->name);
            expect(where, mine[i]->name, theirs[i]->name);
            if (mine[i]->channels.size() != theirs[i]->channels.size()) differ(where, "channels differ in number");
            for (size_t c = 0; c < mine[i]->channels.size(); ++c)
                channels(fmt::format("{} channel {}", where, c), mine[i]->channels[c], theirs[i]->channels[c]);
        }
    }

    void channels(const std::string& where, const AnimationChannel& a, const AnimationChannel& b) {
        expect(where + " path", a.path, b.path);
        switch (object_of(a.path)) {
            case AnimatedObject::Node:
                node_pairs_.pair(where + " node", a.node, b.node);
                break;
            case AnimatedObject::Light:
                expect(where + " light", a_.get(a.light).name, b_.get(b.light).name);
                break;
            case AnimatedObject::Camera:
                expect(where + " camera", a_.get(a.camera).name, b_.get(b.camera).name);
        }
        expect(where + " interpolation", a.interpolation, b.interpolation);
        expect(where + " width", a.width, b.width);
        expect_array(where + " times", a.times, b.times);
        expect_array(where + " values", a.values, b.values);
    }

    const Scene &a_, &b_;
    Pairs<Node> node_pairs_;
    Pairs<Mesh> mesh_pairs_;
    Pairs<Skin> skin_pairs_;
    Pairs<Material> material_pairs_;
    Pairs<Texture> texture_pairs_;
    Pairs<Image> image_pairs_;
    std::vector<std::pair<Handle<Skin>, Handle<Skin>>> skins_;
};

}  // namespace

std::string scene_difference(const Scene& a, const Scene& b) try {
    Comparer(a, b).compare();
    return {};
} catch (const Differs& difference) {
    return difference.text;
}

}  // namespace parhelion::testing
