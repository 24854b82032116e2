// Images, textures and materials on the device.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/error.h"
#include "scene_gpu/state.h"

namespace parhelion {

namespace {

gpu::Wrap to_gpu(Wrap wrap) {
    return wrap == Wrap::Repeat ? gpu::Wrap::Repeat : wrap == Wrap::MirroredRepeat ? gpu::Wrap::Mirror : gpu::Wrap::Clamp;
}
gpu::Filter to_gpu(Filter filter) { return filter == Filter::Nearest ? gpu::Filter::Nearest : gpu::Filter::Linear; }

shared::TextureRef to_shared(const TextureRef& ref) {
    shared::TextureRef out{.texture = ref.texture ? ref.texture.index : shared::kNone, .uv_set = ref.uv_set};
    const glm::mat3 m = uv_transform(ref);
    out.row0 = {m[0][0], m[1][0], m[2][0]};
    out.row1 = {m[0][1], m[1][1], m[2][1]};
    return out;
}

// The textures that shaders read. The others (occlusion, layers that are not drawn) stay on the host.
constexpr TextureRef Material::*kDrawnTextures[] = {&Material::base_color_texture, &Material::metal_rough_texture, &Material::normal_texture,
                                                    &Material::emissive_texture,   &Material::specular_texture,    &Material::specular_color_texture,
                                                    &Material::transmission_texture, &Material::clearcoat_texture, &Material::clearcoat_roughness_texture,
                                                    &Material::clearcoat_normal_texture, &Material::sheen_color_texture, &Material::sheen_roughness_texture};

std::unordered_set<Handle<Texture>> find_drawn_textures(const Scene& scene) {
    std::unordered_set<Handle<Texture>> out;
    for (const auto& [handle, material] : scene.materials())
        for (const auto ref : kDrawnTextures)
            if ((material.*ref).texture) out.insert((material.*ref).texture);
    return out;
}

uint32_t mip_count(uint32_t width, uint32_t height) { return static_cast<uint32_t>(std::floor(std::log2(std::max(width, height)))) + 1; }

gpu::Format device_format(TexelFormat format, bool srgb) {
    using gpu::Format;
    switch (format) {
        case TexelFormat::Bc1Rgb: return srgb ? Format::Bc1RgbSrgb : Format::Bc1RgbUnorm;
        case TexelFormat::Bc1: return srgb ? Format::Bc1Srgb : Format::Bc1Unorm;
        case TexelFormat::Bc3: return srgb ? Format::Bc3Srgb : Format::Bc3Unorm;
        case TexelFormat::Bc4: return Format::Bc4Unorm;
        case TexelFormat::Bc5: return Format::Bc5Unorm;
        case TexelFormat::Bc7: return srgb ? Format::Bc7Srgb : Format::Bc7Unorm;
        case TexelFormat::Rgba8: break;
    }
    return srgb ? Format::Rgba8Srgb : Format::Rgba8Unorm;
}

// Blocks stay blocks where the device reads them: not those of colours in BC4 or BC5, which have no sRGB form. Channels that a
// format lacks are (0, 0, 1) either way.
bool must_unpack(const gpu::DeviceCaps& caps, const Image& source, bool srgb) {
    const bool plain = source.format == TexelFormat::Rgba8, two_channels = source.format == TexelFormat::Bc4 || source.format == TexelFormat::Bc5;
    return !plain && ((srgb && two_channels) || !caps.block_compression);
}

// One device image per (image, colour space).
uint64_t image_key(const Texture& texture) {
    const uint64_t handle = uint64_t(texture.image.generation) << 32 | texture.image.index;
    return handle << 1 | uint64_t(texture.color_space == ColorSpace::Srgb);
}

// The device's image for an image of the scene, still empty. A plain one with one level has room for the others, which are made.
void create_image(const gpu::DevicePtr& device, const Image& source, bool srgb, ImageOnDevice& out) {
    const bool unpack = must_unpack(device->caps(), source, srgb), make_levels = source.format == TexelFormat::Rgba8 && source.level_count == 1;
    if (unpack) out.unpacked = rgba8_texels(source);
    out.bytes = unpack ? out.unpacked.size() : source.texels.size();
    out.image = gpu::Image(device, "textures/image",
                           {.format = device_format(unpack ? TexelFormat::Rgba8 : source.format, srgb),
                            .extent = {source.width, source.height},
                            .mip_count = make_levels ? mip_count(source.width, source.height) : source.level_count});
}

// Stored levels as far as the slice goes, whole rows of blocks at a time, then those that are made from them. True: all is there.
// `write` gives the bytes [first, first + count) of all stored levels one after the other.
bool upload_image(Frame& frame, Slice& slice, ImageOnDevice& to, const std::function<void(std::byte*, uint64_t first, uint64_t count)>& write) {
    constexpr uint64_t kFixedCost = 1 << 16;  // bytes: the passes that make its levels
    const gpu::Format format = to.image.desc().format;
    const uint32_t block = gpu::format_block(format);
    while (to.level < to.stored_levels) {
        if (!slice.has_bytes()) return false;
        const uint32_t width = std::max(to.image.extent().width >> to.level, 1u), height = std::max(to.image.extent().height >> to.level, 1u);
        const uint64_t row_bytes = gpu::format_bytes(format, width, block);
        const uint64_t block_rows = std::clamp<uint64_t>(slice.bytes() / row_bytes, 1, (height - to.row + block - 1) / block);
        const uint32_t rows = std::min(static_cast<uint32_t>(block_rows) * block, height - to.row);
        write(frame.upload_rows_in_place(to.image, to.level, to.row, rows).data(), to.done_bytes, block_rows * row_bytes);
        slice.take_bytes(block_rows * row_bytes);
        to.done_bytes += block_rows * row_bytes;
        to.row += rows;
        if (to.row == height) ++to.level, to.row = 0;
    }
    if (to.stored_levels < to.image.desc().mip_count) frame.make_mips(to.image);
    slice.take_bytes(kFixedCost);
    return true;
}

// What lies between the walls of a transmitting material (KHR_materials_volume): Beer and Lambert's coefficient, 1/m.
glm::vec3 absorption(const Material& material) {
    if (!std::isfinite(material.attenuation_distance)) return glm::vec3(0.0f);
    constexpr float kDarkest = 1e-6f;  // a channel that lets nothing through has no logarithm
    return -glm::log(glm::max(material.attenuation_color, kDarkest)) / material.attenuation_distance;
}

uint32_t material_flags(const Material& material) {
    if (material.unlit) return shared::kMaterialUnlit | shared::kMaterialOnlyEmits;
    uint32_t flags = 0;
    if (material.transmission > 0.0f) flags |= shared::kMaterialTransmits | (material.thickness > 0.0f ? 0u : shared::kMaterialThin);
    if (material.clearcoat > 0.0f) flags |= shared::kMaterialCoated;
    if (material.sheen_color != glm::vec3(0.0f)) flags |= shared::kMaterialSheen;
    if (flags == 0 && material.metallic >= 1.0f && material.roughness < shared::kDeltaRoughness) flags |= shared::kMaterialMirror;
    const bool dark = glm::vec3(material.base_color) == glm::vec3(0.0f) && material.specular == 0.0f && material.metallic == 0.0f;
    return flags == 0 && dark ? shared::kMaterialOnlyEmits : flags;
}

}  // namespace

void SceneGpu::State::plan_images() {
    if (environment_stale) environment_image = {};
    environment_table_stale |= environment_stale;
    environment_stale = false;
    if (!textures_stale) return;
    drawn_textures = find_drawn_textures(*scene);
    for (auto& [key, image] : images) image.wanted = false;
    for (const auto& [handle, texture] : scene->textures()) {
        if (!drawn_textures.contains(handle)) continue;
        const Image& source = scene->get(texture.image);
        const auto [at, is_new] = images.try_emplace(image_key(texture));
        at->second.wanted = true;
        if (!is_new) continue;
        at->second.stored_levels = source.level_count;
        at->second.bytes = source.texels.size();
    }
    // Said before anything is uploaded: the environment takes one slot more.
    const uint64_t needed = drawn_textures.size() + 1, limit = device->caps().max_bindless_textures;
    if (needed > limit)
        throw Error(ErrorCode::Failed, fmt::format("the scene has {} textures, this device takes {}", needed, limit), device->caps().name, "another --device may take more");
}

void SceneGpu::State::upload_images(Frame& frame, Slice& slice) {
    for (const auto& [handle, texture] : scene->textures()) {
        if (!drawn_textures.contains(handle)) continue;
        ImageOnDevice& image = images[image_key(texture)];
        if (image.ready) continue;
        const Image& source = scene->get(texture.image);
        if (!image.image) create_image(device, source, texture.color_space == ColorSpace::Srgb, image);
        const uint8_t* texels = image.unpacked.empty() ? source.texels.data() : image.unpacked.data();
        image.ready = upload_image(frame, slice, image, [&](std::byte* to, uint64_t first, uint64_t count) { std::memcpy(to, texels + first, count); });
        if (!image.ready) return;
        image.unpacked = {};
    }
    const Environment& e = scene->environment();
    if (e.radiance.empty() || environment_image.ready) return;
    if (!environment_image.image) {
        environment_image.image = gpu::Image(device, "textures/environment", {.format = gpu::Format::Rgba32Float, .extent = {e.width, e.height}});
        environment_image.bytes = e.radiance.size() * sizeof(glm::vec4);
    }
    environment_image.ready = upload_image(frame, slice, environment_image, [&](std::byte* to, uint64_t first, uint64_t count) {
        for (uint64_t i = 0; i < count / sizeof(glm::vec4); ++i) {
            const glm::vec4 texel(e.radiance[first / sizeof(glm::vec4) + i], 1.0f);
            std::memcpy(to + i * sizeof(texel), &texel, sizeof(texel));
        }
    });
}

// A texture's row says where it lies; materials name the row, so that it may lie elsewhere without their being touched.
void SceneGpu::State::make_textures() {
    if (!textures_stale && !environment_table_stale) return;
    slots.clear();
    texture_rows.assign(scene->textures().slot_count(), {.slot = shared::kNone});
    for (const auto& [handle, texture] : scene->textures()) {
        if (!drawn_textures.contains(handle)) continue;
        const Sampler& s = texture.sampler;
        const gpu::Image& image = images.at(image_key(texture)).image;
        texture_rows[handle.index] = {.slot = static_cast<uint32_t>(slots.size()), .width = image.extent().width, .height = image.extent().height,
                                      .level_count = s.mip ? image.desc().mip_count : 1};
        slots.emplace_back(image, gpu::Sampler(device, {.wrap_u = to_gpu(s.wrap_u), .wrap_v = to_gpu(s.wrap_v), .mag = to_gpu(s.mag), .min = to_gpu(s.min),
                                                        .mip = to_gpu(s.mip.value_or(Filter::Nearest))}));
    }
    texture_table = make_table("textures", std::span<const shared::TextureEntry>(texture_rows));
    stats.textures = static_cast<uint32_t>(slots.size());
    if (!environment_image.image) return;
    environment.texture = static_cast<uint32_t>(slots.size());
    slots.emplace_back(environment_image.image, gpu::Sampler(device, {.wrap_u = gpu::Wrap::Repeat, .wrap_v = gpu::Wrap::Clamp}));
}

void SceneGpu::State::make_materials() {
    if (!materials_stale) return;
    materials.assign(scene->materials().slot_count(), {});
    features = 0;
    for (const auto& [handle, material] : scene->materials()) {
        shared::Material& row = materials[handle.index];
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
                    (material.double_sided ? shared::kMaterialDoubleSided : 0) | material_flags(material);
        if ((row.flags & shared::kMaterialTransmits) != 0) features |= shared::kSceneLayers | shared::kSceneTransmits;
        else if ((row.flags & (shared::kMaterialCoated | shared::kMaterialSheen)) != 0) features |= shared::kSceneLayers | shared::kSceneCoats;
        if ((row.flags & shared::kMaterialOnlyEmits) != 0) features |= shared::kSceneEmitters;
        if ((row.flags & shared::kMaterialThin) != 0) features |= shared::kScenePanes;
        if ((row.flags & shared::kMaterialMirror) != 0) features |= shared::kSceneMirrors;
        row.absorption = absorption(material);
        row.priority = material.nested_priority;
        row.coat = material.clearcoat;
        row.coat_roughness = material.clearcoat_roughness;
        row.coat_normal_scale = material.clearcoat_normal_scale;
        row.sheen_color = material.sheen_color;
        row.sheen_roughness = material.sheen_roughness;
        row.base_color_texture = to_shared(material.base_color_texture);
        row.metal_rough_texture = to_shared(material.metal_rough_texture);
        row.normal_texture = to_shared(material.normal_texture);
        row.emissive_texture = to_shared(material.emissive_texture);
        row.specular_texture = to_shared(material.specular_texture);
        row.specular_color_texture = to_shared(material.specular_color_texture);
        row.transmission_texture = to_shared(material.transmission_texture);
        row.coat_texture = to_shared(material.clearcoat_texture);
        row.coat_roughness_texture = to_shared(material.clearcoat_roughness_texture);
        row.coat_normal_texture = to_shared(material.clearcoat_normal_texture);
        row.sheen_color_texture = to_shared(material.sheen_color_texture);
        row.sheen_roughness_texture = to_shared(material.sheen_roughness_texture);
    }
    material_table = make_table("materials", std::span<const shared::Material>(materials));
    stats.materials = static_cast<uint32_t>(scene->materials().size());
}

}  // namespace parhelion
