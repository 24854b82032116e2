// Images, textures and materials on the device.
#include <cmath>
#include <unordered_set>

#include "base/error.h"
#include "scene_gpu/state.h"

namespace parhelion {

namespace {

gpu::Wrap to_gpu(Wrap wrap) {
    return wrap == Wrap::Repeat ? gpu::Wrap::Repeat : wrap == Wrap::MirroredRepeat ? gpu::Wrap::Mirror : gpu::Wrap::Clamp;
}
gpu::Filter to_gpu(Filter filter) { return filter == Filter::Nearest ? gpu::Filter::Nearest : gpu::Filter::Linear; }

shared::TextureRef to_shared(const TextureRef& ref, const std::unordered_map<Handle<Texture>, uint32_t>& slots) {
    shared::TextureRef out{.texture = shared::kNone, .uv_set = ref.uv_set};
    if (ref.texture) out.texture = slots.at(ref.texture);
    const glm::mat3 m = uv_transform(ref);
    out.row0 = {m[0][0], m[1][0], m[2][0]};
    out.row1 = {m[0][1], m[1][1], m[2][1]};
    return out;
}

// The textures that shaders read. The others (occlusion, layers that are not drawn) stay on the host.
constexpr TextureRef Material::*kDrawnTextures[] = {&Material::base_color_texture, &Material::metal_rough_texture, &Material::normal_texture,
                                                    &Material::emissive_texture,   &Material::specular_texture,    &Material::specular_color_texture};

std::unordered_set<Handle<Texture>> drawn_textures(const Scene& scene) {
    std::unordered_set<Handle<Texture>> out;
    for (const auto& [handle, material] : scene.materials())
        for (const auto ref : kDrawnTextures) out.insert((material.*ref).texture);
    return out;
}

uint32_t mip_count(uint32_t width, uint32_t height) { return static_cast<uint32_t>(std::floor(std::log2(std::max(width, height)))) + 1; }

}  // namespace

void SceneGpu::State::upload_materials(Frame& frame) {
    textures.clear();
    images.clear();
    // One device image per (image, colour space); one slot per texture.
    std::unordered_map<uint64_t, gpu::Image> made;
    std::unordered_map<Handle<Texture>, uint32_t> slots;
    const std::unordered_set<Handle<Texture>> drawn = drawn_textures(*scene);
    for (const auto& [handle, texture] : scene->textures()) {
        if (!drawn.contains(handle)) continue;
        const bool srgb = texture.color_space == ColorSpace::Srgb;
        gpu::Image& image = made[uint64_t(texture.image.index) << 1 | uint64_t(srgb)];
        if (!image) {
            const Image& source = scene->get(texture.image);
            image = gpu::Image(device, "textures/image",
                               {.format = srgb ? gpu::Format::Rgba8Srgb : gpu::Format::Rgba8Unorm,
                                .extent = {source.width, source.height},
                                .mip_count = mip_count(source.width, source.height)});
            frame.upload_image(image, std::as_bytes(std::span(source.texels)));
            frame.make_mips(image);
            images.push_back(image);
        }
        const gpu::Sampler sampler(device, {.wrap_u = to_gpu(texture.sampler.wrap_u),
                                            .wrap_v = to_gpu(texture.sampler.wrap_v),
                                            .mag = to_gpu(texture.sampler.mag),
                                            .min = to_gpu(texture.sampler.min),
                                            .mip = to_gpu(texture.sampler.mip.value_or(Filter::Nearest))});
        slots[handle] = static_cast<uint32_t>(textures.size());
        textures.emplace_back(image, sampler);
    }

    material_rows.clear();
    materials.clear();
    for (const auto& [handle, material] : scene->materials()) {
        shared::Material row{};
        row.base_color = material.base_color;
        row.emission = material.emission;
        row.metallic = material.metallic;
        row.roughness = material.roughness;
        row.normal_scale = material.normal_scale;
        row.alpha_cutoff = material.alpha_cutoff;
        row.ior = material.ior;
        row.transmission = material.transmission;
        row.specular = material.specular;
        row.specular_color = material.specular_color;
        row.flags = (material.alpha_mode == AlphaMode::Mask ? shared::kAlphaMask : material.alpha_mode == AlphaMode::Blend ? shared::kAlphaBlend : shared::kAlphaOpaque) |
                    (material.double_sided ? shared::kMaterialDoubleSided : 0) | (material.unlit ? shared::kMaterialUnlit : 0);
        row.base_color_texture = to_shared(material.base_color_texture, slots);
        row.metal_rough_texture = to_shared(material.metal_rough_texture, slots);
        row.normal_texture = to_shared(material.normal_texture, slots);
        row.emissive_texture = to_shared(material.emissive_texture, slots);
        row.specular_texture = to_shared(material.specular_texture, slots);
        row.specular_color_texture = to_shared(material.specular_color_texture, slots);
        material_rows[handle] = static_cast<uint32_t>(materials.size());
        materials.push_back(row);
    }
    material_table = make_buffer(frame, "materials", materials);
    stats.materials = static_cast<uint32_t>(materials.size());
    stats.textures = static_cast<uint32_t>(textures.size());
}

}  // namespace parhelion
