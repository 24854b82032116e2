// A scene that a person looks at, frame by frame, without a window.
#include "session/interactive.h"

#include <chrono>
#include <thread>

#include "base/error.h"
#include "gpu/internal.h"
#include "image/decode.h"
#include "image/film.h"
#include "image/tonemap.h"
#include "support/environment_variable.h"
#include "support/gpu_fixture.h"
#include "support/pack_writer.h"
#include "support/process.h"
#include "support/render_fixture.h"

namespace parhelion::testing::interactive_test {
namespace {

class InteractiveScene : public GpuTest {
protected:
    static RenderOptions cornell(uint64_t samples) {
        RenderOptions options;
        options.scene = "builtin:cornell";
        options.size = {24, 18};
        options.samples = {0, samples};
        options.exposure_ev = -1;
        options.trace = TraceChoice::Compute;
        return options;
    }
    // Frames until the picture rests; the last canvas.
    std::vector<uint8_t> draw(Interactive& session) {
        gpu::Buffer copy;
        const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(120);
        while (std::chrono::steady_clock::now() < end) {
            if (session.is_loading() || session.split) std::this_thread::sleep_for(std::chrono::milliseconds(1));
            const gpu::Image canvas = session.record();
            copy = session.frame().read_back(canvas);
            session.finish();
            EXPECT_TRUE(session.frame().complaints().empty()) << session.frame().complaints().front();
            if (session.is_finished()) break;
        }
        EXPECT_TRUE(session.is_finished());
        const auto bytes = copy.mapped_as<uint8_t>();
        return {bytes.begin(), bytes.end()};
    }
    static double mean(const std::vector<uint8_t>& picture) {
        double sum = 0;
        for (size_t i = 0; i < picture.size(); ++i) sum += i % 4 == 3 ? 0 : picture[i];
        return sum / (0.75 * double(picture.size()));
    }
};

TEST_F(InteractiveScene, every_renderer_comes_to_rest_with_a_picture_and_the_same_one_again) {
    Interactive session(initial_state(cornell(3)), device());
    const std::vector<uint8_t> reference = draw(session);
    EXPECT_EQ(session.samples(), 3u);
    EXPECT_GT(mean(reference), 20.0);
    session.set_renderer(RendererKind::Wavefront);
    EXPECT_EQ(session.samples(), 0u);
    EXPECT_NEAR(mean(draw(session)), mean(reference), 1.0);
    session.set_renderer(RendererKind::Reference);
    EXPECT_EQ(draw(session), reference);
    SteeredCamera camera = session.camera();
    camera.orbit(0.5f, 0);
    session.set_camera(camera);
    EXPECT_NE(draw(session), reference);
    session.choose_camera("");
    EXPECT_EQ(draw(session), reference);
    session.resize({30, 18});
    EXPECT_EQ(draw(session).size(), 30u * 18 * 4);
    session.resize({24, 18});
    EXPECT_EQ(draw(session), reference);
    session.reload();
    EXPECT_EQ(draw(session), reference);
}

// With a stand-in for the library (tests/stubs/oidn.cpp): half the red light, prefiltered guides as green and blue.
TEST_F(InteractiveScene, a_picture_comes_to_rest_denoised_and_a_moved_camera_never_shows_an_older_one) {
    const EnvironmentVariable library("PARHELION_OIDN", PARHELION_OIDN_STUB);
    RenderOptions options = cornell(5);
    options.output.exr_float = true;
    TemporaryFolder folder;
    const auto save = [&](Interactive& session, const char* name) {
        session.save_picture({folder.file(name)});
        draw(session);
        return image::read_linear(folder.file(name));
    };
    Interactive plain(initial_state(options), device());
    draw(plain);
    EXPECT_FALSE(plain.shows_denoised());
    const image::ImageF noisy = save(plain, "noisy.exr");
    options.denoise = DenoiseKind::Oidn;
    Interactive session(initial_state(options), device());
    const std::vector<uint8_t> canvas = draw(session);
    EXPECT_TRUE(session.shows_denoised());
    const image::ImageF clean = save(session, "clean.exr");
    EXPECT_EQ(clean.channels, noisy.channels);
    const auto half = clean.plane(clean.find_channel("R").value()), whole = noisy.plane(noisy.find_channel("R").value());
    for (size_t i = 0; i < half.size(); ++i) ASSERT_EQ(half[i], whole[i] / 2) << i;
    // What the window shows is that picture.
    const image::Picture8 shown = image::tonemap_to_srgb(clean, session.show.curve, image::exposure_scale_from_ev100(session.show.exposure_ev));
    for (size_t i = 0; i < clean.pixel_count(); ++i)
        for (size_t c = 0; c < 3; ++c) ASSERT_NEAR(canvas[4 * i + c], shown.rgb[3 * i + c], 1) << i;

    SteeredCamera camera = session.camera();
    camera.orbit(0.5f, 0);
    session.set_camera(camera);
    EXPECT_FALSE(session.shows_denoised());
    const std::vector<uint8_t> moved = draw(session);
    EXPECT_TRUE(session.shows_denoised());
    EXPECT_NE(moved, canvas);
    session.choose_camera("");
    EXPECT_EQ(draw(session), canvas);
    session.set_layer("albedo");
    draw(session);
    EXPECT_FALSE(session.shows_denoised());
    session.set_layer("");
    EXPECT_EQ(draw(session), canvas);
}

// The camera turns away from all that there is while a picture is being denoised: all pixels are alike from then on.
TEST_F(InteractiveScene, what_is_being_denoised_when_the_camera_moves_is_never_shown) {
    const EnvironmentVariable library("PARHELION_OIDN", PARHELION_OIDN_STUB), slow("STUB_SECONDS", "0.03");
    RenderOptions options = cornell(4);
    options.denoise = DenoiseKind::Oidn;
    Interactive session(initial_state(options), device());
    for (int frame = 0; frame < 2000 && session.samples() < 4; ++frame) {
        session.record();
        session.finish();
    }
    session.record();  // gives the film away, if nothing runs yet
    session.finish();
    ASSERT_FALSE(session.is_finished());
    SteeredCamera camera = session.camera();
    camera.look(3.14159f, 0);
    session.set_camera(camera);
    bool denoised = false;
    for (int frame = 0; frame < 2000 && !session.is_finished(); ++frame) {
        const gpu::Buffer copy = session.frame().read_back(session.record());
        session.finish();
        denoised = denoised || session.shows_denoised();
        const auto bytes = copy.mapped_as<uint8_t>();
        for (size_t i = 0; i < bytes.size(); i += 4) ASSERT_EQ(bytes[i], bytes[0]) << "frame " << frame;
    }
    EXPECT_TRUE(denoised);
}

TEST_F(InteractiveScene, where_denoising_fails_the_noisy_picture_stays_and_a_line_says_why) {
    const EnvironmentVariable library("PARHELION_OIDN", PARHELION_OIDN_STUB), fails("STUB_FAILS", "memory");
    RenderOptions options = cornell(2);
    Interactive plain(initial_state(options), device());
    options.denoise = DenoiseKind::Oidn;
    Interactive session(initial_state(options), device());
    EXPECT_EQ(draw(session), draw(plain));
    EXPECT_FALSE(session.shows_denoised());
    EXPECT_NE(session.note().find("not enough memory to denoise"), std::string::npos) << session.note();
}

// What is refused leaves no trace.
TEST_F(InteractiveScene, settings_that_do_not_fit_are_refused_and_change_nothing) {
    Interactive session(initial_state(cornell(2)), device());
    const std::vector<uint8_t> before = draw(session);
    RenderSettings settings = session.settings();
    settings.shade_in = ShadeIn::ClosestHit;  // needs --trace pipeline
    EXPECT_THROW(session.set_settings(settings), Error);
    EXPECT_EQ(session.settings().shade_in, ShadeIn::Raygen);
    EXPECT_EQ(draw(session), before);
    settings = session.settings();
    settings.sampler = SamplerKind::Pcg;
    session.set_settings(settings);
    EXPECT_NE(draw(session), before);
    settings.sampler = SamplerKind::Owen;
    settings.node_layout = NodeLayout::Binary;  // makes the scene on the device anew
    session.set_settings(settings);
    EXPECT_EQ(draw(session).size(), before.size());
}

// A layer is shown as it is: every white wall is as bright as its albedo says.
TEST_F(InteractiveScene, layers_are_shown_without_exposure) {
    Interactive session(initial_state(cornell(2)), device());
    session.set_layer("albedo");
    const std::vector<uint8_t> dark = draw(session);
    session.show.exposure_ev = 12;
    EXPECT_EQ(draw(session), dark);
    session.set_layer("");
    EXPECT_NE(draw(session), dark);
}

TEST_F(InteractiveScene, a_scene_that_cannot_be_read_again_stays_as_it_was) {
    TemporaryFolder folder;
    RenderOptions options = cornell(1);
    options.scene = folder.file("scene.glb");
    Interactive missing(initial_state(options), device());
    EXPECT_THROW(draw(missing), Error);

    ASSERT_EQ(run_parhelion({"export", "builtin:cornell", "--out", options.scene}).exit_code, 0);
    Interactive session(initial_state(options), device());
    const std::vector<uint8_t> before = draw(session);
    std::filesystem::resize_file(options.scene, 100);
    session.reload();
    EXPECT_EQ(draw(session), before);
    EXPECT_NE(session.note().find("scene.glb"), std::string::npos) << session.note();
}

// The reference on both sides: the same samples, so nothing is between them.
TEST_F(InteractiveScene, the_reference_beside_a_picture_is_that_picture_and_as_far_off_as_nothing) {
    RenderOptions options = cornell(4);
    Interactive plain(initial_state(options), device());
    const std::vector<uint8_t> picture = draw(plain);
    Interactive session(initial_state(options), device());
    session.split = 0.5f;
    const std::vector<uint8_t> both = draw(session);
    EXPECT_EQ(session.reference_samples(), 4u);
    constexpr size_t kWidth = 24, kLine = 12;
    for (size_t i = 0; i < picture.size(); ++i) ASSERT_EQ(both[i], i / 4 % kWidth == kLine ? 255 : picture[i]) << i;
    ASSERT_TRUE(session.difference());
    EXPECT_EQ(session.difference()->flip, 0.0);
    EXPECT_EQ(session.difference()->mean_ratio, 1.0);
    session.split.reset();
    EXPECT_EQ(draw(session), picture);
}

// Of a realtime picture it is the picture of `render --renderer reference --pixel-filter point`.
TEST_F(InteractiveScene, the_reference_beside_a_realtime_picture_looks_through_the_same_points) {
    RenderOptions options = cornell(3);
    options.point_filter = true;
    Interactive reference(initial_state(options), device());
    const std::vector<uint8_t> picture = draw(reference);
    options.renderer = RendererKind::Realtime;
    Interactive session(initial_state(options), device());
    session.split = 0.0f;
    const std::vector<uint8_t> right = draw(session);
    for (size_t i = 0; i < picture.size(); ++i) ASSERT_EQ(right[i], i / 4 % 24 == 0 ? 255 : picture[i]) << i;
    ASSERT_TRUE(session.difference());
    EXPECT_GT(session.difference()->flip, 0.0);
}

// A frame of the realtime renderer takes a CPU much longer than a slice of the reference: at rest most frames are the reference's, and while something
// moves each has a new picture.
TEST_F(InteractiveScene, at_rest_a_slow_picture_leaves_the_device_to_the_reference_beside_it) {
    if (device()->caps().type != gpu::DeviceType::Cpu) GTEST_SKIP() << "the device is not slow";
    RenderOptions options = cornell(1u << 20);
    options.size = {480, 360};
    options.renderer = RendererKind::Realtime;
    Interactive session(initial_state(options), device());
    session.split = 0.5f;
    const auto draw_frames = [&](int count) {
        const uint64_t before = session.samples();
        for (int i = 0; i < count; ++i) session.record(), session.finish();
        return session.samples() - before;
    };
    while (session.samples() < 3) draw_frames(1);
    std::this_thread::sleep_for(std::chrono::milliseconds(600));
    constexpr int kFrames = 24;
    draw_frames(kFrames);  // whole pictures again
    EXPECT_LT(draw_frames(kFrames), kFrames / 2u);
    EXPECT_GT(session.reference_samples(), 0u);
    for (int i = 0; i < 4; ++i) {
        session.set_camera(session.camera());  // the film begins anew
        session.record(), session.finish();
        EXPECT_EQ(session.samples(), 1u);
    }
}

// Every shader of the program, with other words that do the same: the generator's number in the module's header.
std::shared_ptr<const gpu::ShaderPack> same_shaders(uint32_t generator) {
    std::vector<gpu::ShaderCode> shaders(gpu::ShaderPack::builtin().all().begin(), gpu::ShaderPack::builtin().all().end());
    for (gpu::ShaderCode& code : shaders) code.words[2] = generator;
    return std::make_shared<gpu::ShaderPack>(PackWriter().write(shaders));
}

TEST_F(InteractiveScene, programs_of_shaders_that_were_replaced_are_freed) {
    Interactive session(initial_state(cornell(2)), device());
    const std::vector<uint8_t> picture = draw(session);
    session.use_shaders(same_shaders(1));
    EXPECT_EQ(draw(session), picture);
    const size_t programs = device()->impl().programs.size();
    for (uint32_t generator = 2; generator < 4; ++generator) {
        session.use_shaders(same_shaders(generator));
        EXPECT_EQ(draw(session), picture);
        EXPECT_EQ(device()->impl().programs.size(), programs);
    }
}

const std::string* row_of(const PixelReport& report, std::string_view section, std::string_view what) {
    for (const PixelReport::Section& s : report.sections)
        for (const auto& [name, value] : s.rows)
            if (s.title.starts_with(section) && name == what) return &value;
    return nullptr;
}

// The middle of the box's back wall, and what the first-hit layers of `render` say of the same pixel.
TEST_F(InteractiveScene, a_pixel_is_looked_into) {
    Interactive session(initial_state(cornell(2)), device());
    const std::vector<uint8_t> before = draw(session);
    session.pick({12, 4});
    EXPECT_EQ(draw(session), before);
    ASSERT_TRUE(session.picked());
    const PixelReport& report = *session.picked();
    EXPECT_EQ(report.pixel, glm::uvec2(12, 4));
    EXPECT_TRUE(report.meets_surface);
    const CameraView& view = session.camera().view();
    const auto seen = session.camera().project(report.position_ws, 24.0f / 18.0f);
    ASSERT_TRUE(seen);
    EXPECT_NEAR(seen->x, 2 * 12.5f / 24 - 1, 1e-3f);
    EXPECT_NEAR(seen->y, 1 - 2 * 4.5f / 18, 1e-3f);
    EXPECT_GT(glm::dot(report.position_ws - view.position, view.forward), 0.0f);
    ASSERT_GE(report.path_ws.size(), 2u);
    EXPECT_EQ(report.path_ws[0], view.position);
    EXPECT_LT(glm::distance(report.path_ws[1], report.position_ws), 1e-3f * glm::distance(view.position, report.position_ws));
    for (const char* what : {"instance", "material", "depth", "albedo"}) EXPECT_NE(row_of(report, "surface", what), nullptr) << what;
    EXPECT_NE(row_of(report, "light", "indirect_diffuse"), nullptr) << report.text();
    EXPECT_EQ(row_of(report, "realtime", "rays"), nullptr);

    session.set_renderer(RendererKind::Realtime);
    RenderSettings settings = session.settings();
    settings.realtime_reuse = RealtimeReuse::Full;
    session.set_settings(settings);
    draw(session);
    session.pick({12, 4});
    draw(session);
    ASSERT_TRUE(session.picked());
    for (const auto& [section, what] : {std::pair{"realtime", "rays"}, {"realtime", "light asked for"}, {"reservoir", "sample"}})
        EXPECT_NE(row_of(*session.picked(), section, what), nullptr) << session.picked()->text();
    const std::string* light = row_of(*session.picked(), "realtime", "light asked for");
    EXPECT_NE(light->find("mesh"), std::string::npos) << *light;
    session.pick({1000, 1000});  // past the edge: the last one
    draw(session);
    EXPECT_EQ(session.picked()->pixel, glm::uvec2(23, 17));
}

TEST_F(InteractiveScene, images_of_passes_are_shown_in_the_pictures_place) {
    RenderOptions options = cornell(2);
    options.renderer = RendererKind::Realtime;
    Interactive session(initial_state(options), device());
    const std::vector<uint8_t> picture = draw(session);
    const std::vector<std::string> images = session.images();
    for (const char* name : {"gbuffer/identity", "gbuffer/depth", "post/resolve.hdr"}) EXPECT_NE(std::ranges::find(images, name), images.end()) << name;
    std::vector<uint8_t> seen;
    for (const std::string& image : images) {
        session.shown_image = image;
        session.begin_anew();
        seen = draw(session);
        EXPECT_EQ(seen.size(), picture.size());
        EXPECT_NE(seen, picture) << image;
    }
    session.shown_image.clear();
    session.begin_anew();
    EXPECT_EQ(draw(session), picture);
}

TEST_F(InteractiveScene, another_scene_and_environment_come_while_it_runs_and_broken_ones_do_not) {
    TemporaryFolder folder;
    Interactive session(initial_state(cornell(1)), device());
    const std::vector<uint8_t> box = draw(session);
    session.open_scene(folder.file("missing.glb"));
    EXPECT_EQ(draw(session), box);
    EXPECT_NE(session.note().find("missing.glb"), std::string::npos) << session.note();
    EXPECT_EQ(session.options().scene, "builtin:cornell");
    session.open_environment(folder.file("missing.hdr"));
    EXPECT_EQ(draw(session), box);
    EXPECT_NE(session.note().find("missing.hdr"), std::string::npos) << session.note();

    session.open_scene("builtin:furnace");
    const std::vector<uint8_t> furnace = draw(session);
    EXPECT_EQ(session.options().scene, "builtin:furnace");
    RenderOptions options = cornell(1);
    options.scene = "builtin:furnace";
    options.exposure_ev.reset();
    Interactive fresh(initial_state(options), device());
    EXPECT_EQ(draw(fresh), furnace);
    session.open_scene("builtin:cornell");
    session.show.exposure_ev = -1;
    draw(session);
    session.show.exposure_ev = -1;  // the scene's own was metered
    EXPECT_EQ(draw(session), box);
}

// The box with a scripted edit, and its picture at another moment, of a session that began there.
struct Clock {
    static constexpr double kLater = 1.5;  // seconds
    RenderOptions options;
    std::vector<uint8_t> then;
};

class InteractiveClock : public InteractiveScene {
protected:
    Clock clock_of(const char* animate) {
        Clock clock{.options = cornell(1)};
        clock.options.load.animate = animate;
        RenderOptions later = clock.options;
        later.load.time = Clock::kLater;
        Interactive session(initial_state(later), device());
        clock.then = draw(session);
        return clock;
    }
    std::vector<uint8_t> turn(Interactive& session) {
        SteeredCamera camera = session.camera();
        camera.look(0.1f, 0);
        session.set_camera(camera);
        return draw(session);
    }
};

// The camera is animated, too: until somebody moves it, it goes where the scene takes it.
TEST_F(InteractiveClock, a_camera_that_nobody_has_moved_follows_it) {
    const Clock clock = clock_of("cut");
    Interactive session(initial_state(clock.options), device());
    const std::vector<uint8_t> start = draw(session);
    EXPECT_NE(start, clock.then);
    session.set_time(Clock::kLater);
    EXPECT_EQ(draw(session), clock.then);
    session.set_time(0);
    EXPECT_EQ(draw(session), start);
    const std::vector<uint8_t> turned = turn(session);
    session.set_time(Clock::kLater);
    EXPECT_EQ(draw(session), turned);
    session.choose_camera("");
    EXPECT_EQ(draw(session), clock.then);
}

TEST_F(InteractiveClock, can_be_set_and_a_session_goes_on_with_the_state_of_another) {
    const Clock clock = clock_of("spin");
    Interactive session(initial_state(clock.options), device());
    EXPECT_NE(draw(session), clock.then);
    session.set_time(Clock::kLater);
    EXPECT_EQ(draw(session), clock.then);
    const std::vector<uint8_t> turned = turn(session);
    Interactive next(session.state(), device());
    EXPECT_EQ(draw(next), turned);
}

}  // namespace
}  // namespace parhelion::testing::interactive_test
