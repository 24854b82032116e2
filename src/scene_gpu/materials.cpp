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

uint32_t mip_count(uint32_t width, uint32_t height) { return static_cast<uint32_t>(std::floor(std::log2(std::max(width, height)))) + 1; }


// One device image per (image, colour space).
uint64_t image_key(const Texture& texture) {
    const uint64_t handle = uint64_t(texture.image.generation) << 32 | texture.image.index;
    return handle << 1 | uint64_t(texture.color_space == ColorSpace::Srgb);
}

// The device's image for an image of the scene, still empty: all levels, those that are not stored included.
gpu::Image create_image(const gpu::DevicePtr& device, const Image& source, bool srgb) {
    PARHELION_CHECK(source.format == TexelFormat::Rgba8 && source.level_count == 1, "image {} is not stored as plain texels of one level", escape_name(source.name));
    return gpu::Image(device, "textures/image",
                      {.format = srgb ? gpu::Format::Rgba8Srgb : gpu::Format::Rgba8Unorm, .extent = {source.width, source.height}, .mip_count = mip_count(source.width, source.height)});
}

// Rows of texels as far as the slice goes, then the levels below. True: all is there.
bool upload_image(Frame& frame, Slice& slice, ImageOnDevice& on_device, const std::function<void(std::byte*, uint64_t first, uint64_t rows)>& write) {
    constexpr uint64_t kFixedCost = 1 << 16;  // bytes: the passes that make its levels
    if (!slice.has_bytes()) return false;
    const uint64_t rows = std::clamp<uint64_t>(slice.bytes() / on_device.row_bytes, 1, on_device.rows - on_device.done_rows);
    write(frame.upload_rows_in_place(on_device.image, 0, static_cast<uint32_t>(on_device.done_rows), static_cast<uint32_t>(rows)).data(), on_device.done_rows, rows);
    slice.take_bytes(rows * on_device.row_bytes);
    on_device.done_rows += rows;
    if (on_device.done_rows < on_device.rows) return false;
    frame.make_mips(on_device.image);
    slice.take_bytes(kFixedCost);
    return true;
}

}  // namespace

void SceneGpu::State::plan_images() {
    if (environment_stale) environment_image = {};
    environment_table_stale |= environment_stale;
    environment_stale = false;
    if (!textures_stale) return;
    for (auto& [key, image] : images) image.wanted = false;
    for (const auto& [handle, texture] : scene->textures()) {
        const Image& source = scene->get(texture.image);
        ImageOnDevice& image = images[image_key(texture)];
        image.wanted = true;
        image.rows = source.height;
        image.row_bytes = uint64_t(source.width) * 4;
    }
    // Said before anything is uploaded: the environment takes one slot more.
    const uint64_t needed = scene->textures().size() + 1, limit = device->caps().max_bindless_textures;
    if (needed > limit)
        throw Error(ErrorCode::Failed, fmt::format("the scene has {} textures, this device takes {}", needed, limit), device->caps().name, "another --device may take more");
}

void SceneGpu::State::upload_images(Frame& frame, Slice& slice) {
    for (const auto& [handle, texture] : scene->textures()) {
        ImageOnDevice& image = images[image_key(texture)];
        if (image.ready) continue;
        const Image& source = scene->get(texture.image);
        if (!image.image) image.image = create_image(device, source, texture.color_space == ColorSpace::Srgb);
        const uint64_t row_bytes = image.row_bytes;
        image.ready = upload_image(frame, slice, image, [&](std::byte* to, uint64_t first, uint64_t rows) { std::memcpy(to, source.texels.data() + first * row_bytes, rows * row_bytes); });
        if (!image.ready) return;
    }
    const Environment& e = scene->environment();
    if (e.radiance.empty() || environment_image.ready) return;
    if (!environment_image.image) {
        environment_image.image = gpu::Image(device, "textures/environment", {.format = gpu::Format::Rgba32Float, .extent = {e.width, e.height}});
        environment_image.rows = e.height;
        environment_image.row_bytes = uint64_t(e.width) * sizeof(glm::vec4);
    }
    environment_image.ready = upload_image(frame, slice, environment_image, [&](std::byte* to, uint64_t first, uint64_t rows) {
        for (uint64_t i = 0; i < rows * e.width; ++i) {
            const glm::vec4 texel(e.radiance[first * e.width + i], 1.0f);
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
        row.flags = (material.alpha_mode == AlphaMode::Mask ? shared::kAlphaMask : material.alpha_mode == AlphaMode::Blend ? shared::kAlphaBlend : shared::kAlphaOpaque) |
                    (material.double_sided ? shared::kMaterialDoubleSided : 0) | (material.unlit ? shared::kMaterialUnlit : 0);
        row.base_color_texture = to_shared(material.base_color_texture);
        row.metal_rough_texture = to_shared(material.metal_rough_texture);
        row.normal_texture = to_shared(material.normal_texture);
        row.emissive_texture = to_shared(material.emissive_texture);
    }
    material_table = make_table("materials", std::span<const shared::Material>(materials));
    stats.materials = static_cast<uint32_t>(scene->materials().size());
}

}  // namespace parhelion
