// Textures in blocks and with stored levels: the picture is that of the same texels, plain.
#include <random>

#include "gpu/internal.h"
#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "support/render_fixture.h"

namespace parhelion::testing::block_texture_test {
namespace {

constexpr TexelFormat kFormats[] = {TexelFormat::Bc1Rgb, TexelFormat::Bc1, TexelFormat::Bc3, TexelFormat::Bc4, TexelFormat::Bc5, TexelFormat::Bc7};

// Stripes of the ground, each glowing with a texture of its own; `plain`: as Rgba8.
Scene stripes(bool plain) {
    SceneEdit edit;
    std::mt19937 rng(3);
    for (size_t i = 0; i < std::size(kFormats); ++i) {
        Image image{.name = "blocks", .width = 8, .height = 12, .format = kFormats[i], .level_count = 2};
        image.texels.resize(image::image_bytes(image.format, image.width, image.height, image.level_count));
        for (uint8_t& byte : image.texels) byte = static_cast<uint8_t>(rng());
        if (plain) {
            image.texels = rgba8_texels(image);
            image.format = TexelFormat::Rgba8;
        }
        Texture texture{.image = edit.add(std::move(image)), .sampler = {.mag = Filter::Nearest, .min = Filter::Nearest}};
        Material material{.name = "glow", .base_color = {0, 0, 0, 1}, .emission = glm::vec3(1.0f)};
        material.emissive_texture.texture = edit.add(std::move(texture));
        Primitive stripe;
        const float width = 2.0f / float(std::size(kFormats));
        add_quad(stripe, {-1.0f + width * float(i), 0.0f, 1.0f}, {width, 0.0f, 0.0f}, {0.0f, 0.0f, -2.0f});
        stripe.uv0 = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
        builtin::add_object(edit, "stripe", std::move(stripe), edit.add(std::move(material)));
    }
    return make_scene(std::move(edit));
}

class BlockTextures : public GpuTest {
protected:
    static Shot shot() { return {.view = {.width = 48, .height = 24, .max_bounces = 1, .filter = PixelFilter::Point}, .camera = camera_from_above(5.0f, 1.0f), .sample_count = 1}; }
    // The shared device, as if it read no blocks.
    gpu::DevicePtr without_blocks() const {
        const gpu::Device::Impl& impl = device()->impl();
        return gpu::Device::borrow({.instance = impl.instance->handle,
                                    .physical_device = impl.physical.handle,
                                    .device = impl.device,
                                    .queue = impl.queue,
                                    .queue_family = impl.physical.queue_family,
                                    .get_instance_proc_addr = reinterpret_cast<void* (*)(VkInstance, const char*)>(impl.instance->vk.vkGetInstanceProcAddr)});
    }
};

TEST_F(BlockTextures, glow_as_the_same_texels_do_when_plain) {
    Stage blocks(stripes(false)), plain(stripes(true));
    const image::ImageF found = blocks.picture(shot()), expected = plain.picture(shot());
    double brightest = 0;
    for (size_t c = 0; c < 3; ++c)
        for (size_t i = 0; i < found.pixel_count(); ++i) {
            // As many steps of 255 as BC1 to BC5 may be off by (device/block_texture_test.cpp), through the sRGB curve, which rises by at
            // most 2.3.
            const double steps = device()->caps().type == gpu::DeviceType::Cpu ? 2.0 : 8.65;
            ASSERT_NEAR(found.plane(c)[i], expected.plane(c)[i], 2.4 * steps / 255) << c << ' ' << i;
            brightest = std::max(brightest, double(expected.plane(c)[i]));
        }
    EXPECT_GT(brightest, 0.8);
}

TEST_F(BlockTextures, come_in_slices_to_the_same_bits) {
    constexpr SceneGpuOptions kCrumbs{.slice_bytes = 32, .slice_triangles = 1, .geometry_buffer_bytes = 4096};
    Stage whole(stripes(false)), crumbs(stripes(false), kCrumbs);
    EXPECT_EQ(crumbs.render(shot()).limbs, whole.render(shot()).limbs);
}

TEST_F(BlockTextures, are_unpacked_in_slices_for_a_device_without_blocks) {
    const gpu::DevicePtr plain_device = without_blocks();
    ASSERT_FALSE(plain_device->caps().block_compression);
    Stage unpacked(stripes(false), {.hardware = false, .slice_bytes = 256, .slice_triangles = 1}, {}, plain_device);
    SceneProgress progress = unpacked.scene_gpu.update(unpacked.frame);
    for (double before = 0; !progress.complete; progress = unpacked.scene_gpu.update(unpacked.frame)) {
        EXPECT_GE(progress.done, before);
        EXPECT_LE(progress.done, progress.total);
        before = progress.done;
        unpacked.frame.run();
    }
    Stage plain(stripes(true));
    EXPECT_EQ(unpacked.render(shot()).limbs, plain.render(shot()).limbs);
}

}  // namespace
}  // namespace parhelion::testing::block_texture_test
