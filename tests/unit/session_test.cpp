// Pieces of a render job that need no device: light and camera of a scene, metering, hashes, resolving, parts and settings.
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include <gtest/gtest.h>

#include "base/error.h"
#include "base/file.h"
#include "scene/load.h"
#include "session/effective_settings.h"
#include "session/film_state.h"
#include "session/frame_hash.h"
#include "session/merge.h"
#include "session/metering.h"
#include "session/pictures.h"
#include "session/results.h"
#include "session/scene_setup.h"
#include "support/process.h"

#include <nlohmann/json.hpp>

namespace parhelion::session_test {
namespace {

using testing::TemporaryFolder;

std::string error_line(const std::function<void()>& body) {
    try {
        body();
    } catch (const Error& error) {
        return error.line;
    }
    return "(no error)";
}

// A film with its own value in every pixel and channel, for `samples`.
image::FilmSums small_film(IndexRange samples, float value = 1.0f) {
    image::FilmSums film = image::make_film(3, 2, {"R", "G", "B"}, samples.begin, samples.end);
    film.attributes = film_attributes(0xABCD, 4.25);
    for (size_t channel = 0; channel < 3; ++channel)
        for (size_t pixel = 0; pixel < 6; ++pixel)
            film.add_block(channel, pixel, value * float(1 + channel + 10 * pixel) * float(samples.end - samples.begin));
    return film;
}

}  // namespace

TEST(SceneSetup, a_scene_without_light_gets_a_sky_unless_it_is_refused) {
    Scene scene;
    EXPECT_FALSE(has_light(scene));
    RenderOptions options;
    options.default_light = false;
    add_light(scene, options, {});
    EXPECT_TRUE(scene.environment().black());
    options.default_light = true;
    options.env_intensity = 0.5;
    options.env_rotation_degrees = 90;
    add_light(scene, options, {});
    EXPECT_FALSE(scene.environment().black());
    EXPECT_FLOAT_EQ(scene.environment().scale.x, 0.5f);
    EXPECT_FLOAT_EQ(scene.environment().rotation, std::numbers::pi_v<float> / 2);
    ASSERT_EQ(scene.lights().size(), 1u);  // the sun turns with it: from 45 degrees between +Z and +X to -Z
    const Light& sun = (*scene.lights().begin()).value;
    EXPECT_GT(sun.place.world_from_object[2].x, 0.3f);
    EXPECT_LT(sun.place.world_from_object[2].z, -0.3f);
}

TEST(SceneSetup, a_scene_that_is_unlit_throughout_needs_no_sky) {
    Scene scene;
    SceneEdit edit;
    edit.add(Material{.name = "shown as it is", .unlit = true});
    scene.apply(std::move(edit));
    EXPECT_TRUE(has_light(scene));
    SceneEdit more;
    more.add(Material{.name = "lit"});
    scene.apply(std::move(more));
    EXPECT_FALSE(has_light(scene));
}

TEST(SceneSetup, the_clear_sky_can_be_asked_for) {
    LoadedScene loaded = load_scene("builtin:cornell");
    RenderOptions options;
    options.environment = "sky";
    add_light(loaded.scene, options, {});
    EXPECT_EQ(loaded.scene.environment().name, "clear sky");
    EXPECT_EQ(loaded.scene.lights().size(), 1u);
}

TEST(SceneSetup, a_scene_with_light_keeps_it) {
    LoadedScene loaded = load_scene("builtin:cornell");
    ASSERT_TRUE(has_light(loaded.scene));
    add_light(loaded.scene, RenderOptions{}, {});
    EXPECT_TRUE(loaded.scene.environment().black());
}

TEST(SceneSetup, the_camera_is_the_options_then_the_scenes_then_one_that_frames) {
    const LoadedScene loaded = load_scene("builtin:cornell");
    std::string description;
    RenderOptions options;
    choose_camera(loaded.scene, options, description);
    EXPECT_EQ(description, "front");
    options.fov_degrees = 90;
    EXPECT_FLOAT_EQ(choose_camera(loaded.scene, options, description).yfov, std::numbers::pi_v<float> / 2);
    options.look_from = {1, 2, 3};
    const CameraView own = choose_camera(loaded.scene, options, description);
    EXPECT_EQ(own.position, glm::vec3(1, 2, 3));
    EXPECT_GT(glm::dot(own.forward, loaded.scene.bounds().center() - own.position), 0.0f);
    options.look_from.reset();
    options.camera = "no such";
    EXPECT_NE(error_line([&] { choose_camera(loaded.scene, options, description); }).find("front"), std::string::npos)
        << "the error lists the cameras";
    choose_camera(Scene{}, RenderOptions{}, description);
    EXPECT_EQ(description, "(frames the scene)");
}

TEST(SceneSetup, the_camera_of_shaders_spans_the_image) {
    const CameraView view = look_at({0, 0, 5}, {0, 0, 0}, std::numbers::pi_v<float> / 2);
    const shared::Camera camera = shader_camera(view, 2.0f);
    EXPECT_NEAR(glm::length(camera.up_ws), 1.0f, 1e-6f);
    EXPECT_NEAR(glm::length(camera.right_ws), 2.0f, 1e-6f);
    EXPECT_NEAR(camera.right_ws.x, 2.0f, 1e-6f);
}

TEST(SceneSetup, auto_never_chooses_a_way_that_the_device_lacks) {
    for (const bool query : {false, true})
        for (const auto type : {gpu::DeviceType::Cpu, gpu::DeviceType::Discrete, gpu::DeviceType::Integrated}) {
            gpu::DeviceCaps caps;
            caps.type = type;
            caps.ray_query = query;
            EXPECT_TRUE(caps.supports(choose_trace_way(caps, TraceChoice::Auto)));
        }
    gpu::DeviceCaps bare;
    bare.name = "bare";
    EXPECT_EQ(choose_trace_way(bare, TraceChoice::Compute), gpu::TraceWay::Compute);
    EXPECT_EQ(error_line([&] { choose_trace_way(bare, TraceChoice::Query); }),
              "--trace: bare cannot trace by query (use --trace compute: it needs no ray tracing extension)");
}

TEST(SceneHash, equal_scenes_have_equal_hashes_and_any_change_shows) {
    const auto hash = [](const std::function<void(Scene&)>& change) {
        LoadedScene loaded = load_scene("builtin:cornell");
        change(loaded.scene);
        return hash_scene(loaded.scene);
    };
    const auto edit = [&](const std::function<void(const Scene&, SceneEdit&)>& fill) {
        return hash([&](Scene& scene) {
            SceneEdit change;
            fill(scene, change);
            scene.apply(std::move(change));
        });
    };
    std::set<uint64_t> hashes{hash([](Scene&) {})};
    EXPECT_EQ(*hashes.begin(), hash([](Scene&) {}));
    hashes.insert(edit([](const Scene&, SceneEdit& change) {
        Environment sky;
        sky.scale = glm::vec3(1);
        change.set_environment(sky);
    }));
    hashes.insert(edit([](const Scene& scene, SceneEdit& change) {
        const auto item = *scene.materials().begin();
        Material material = item.value;
        material.roughness *= 0.5f;
        change.set_material(item.handle, material);
    }));
    hashes.insert(edit([](const Scene& scene, SceneEdit& change) {
        const auto item = *scene.nodes().begin();
        Transform local = item.value.local;
        local.translation.x += 1e-3f;
        change.set_transform(item.handle, local);
    }));
    // What a file's animation and its targets would do later.
    for (const float reach : {0.0f, 0.5f})
        hashes.insert(edit([&](const Scene& scene, SceneEdit& change) {
            Primitive triangle{.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, .triangles = {{0, 1, 2}}, .material = (*scene.materials().begin()).handle};
            triangle.targets.resize(1);
            triangle.targets[0].positions = {{0, 0, 0}, {0, 0, 0}, {0, 0, reach}};
            change.add(Mesh{.primitives = {triangle}});
        }));
    EXPECT_EQ(hashes.size(), 6u);
}

TEST(SceneHash, the_hash_of_a_sequence_covers_what_its_frames_depend_on_later) {
    std::set<uint64_t> hashes;
    const auto add = [&](const std::function<void(RenderOptions&)>& change, float key = 1, std::string_view denoiser = "") {
        LoadedScene loaded = load_scene("builtin:furnace");
        SceneEdit edit;
        const Handle<Node> node = edit.add(Node{});
        edit.add(Animation{.channels = {{.node = node, .times = {0, 1}, .values = {0, 0, 0, key, 0, 0}}}});
        loaded.scene.apply(std::move(edit));
        RenderOptions options;
        options.play = FramePlay{.frames = {0, 3}, .fps = 24};
        options.output.files = {"a.#.exr"};
        change(options);
        hashes.insert(hash_sequence(options, loaded.scene, 7, denoiser));
    };
    const TemporaryFolder folder;
    const auto follow = [&](const char* path) {
        write_text_file(folder.file("path.json"), path);
        add([&](RenderOptions& o) { o.camera_path = folder.file("path.json"); });
    };
    add([](RenderOptions&) {});
    // What frames do not depend on.
    add([](RenderOptions& o) { o.play->frames = {2, 9}; });
    add([](RenderOptions& o) { o.output.files = {"b.##.png"}; });
    add([](RenderOptions& o) { o.time_budget_seconds = 3; });
    add([](RenderOptions& o) { o.resume = true; });
    EXPECT_EQ(hashes.size(), 1u);
    add([](RenderOptions&) {}, 2);
    add([](RenderOptions&) {}, 1, "2.3");
    add([](RenderOptions& o) { o.renderer = RendererKind::Wavefront; });
    add([](RenderOptions& o) { o.denoise = DenoiseKind::Oidn; });
    add([](RenderOptions& o) { o.samples.end = 65; });
    add([](RenderOptions& o) { o.play->fps = 25; });
    add([](RenderOptions& o) { o.load.time = 1; });
    add([](RenderOptions& o) { o.load.animate = "swing"; });
    add([](RenderOptions& o) { o.load.animation = "1"; });
    add([](RenderOptions& o) { o.shutter_seconds = 0.5; });
    add([](RenderOptions& o) { o.camera = "1"; });
    add([](RenderOptions& o) { o.fov_degrees = 30; });
    add([](RenderOptions& o) { o.exposure_ev = 0; });
    add([](RenderOptions& o) { o.exposure_ev = 1; });
    add([](RenderOptions& o) { o.output.exr_float = true; });
    add([](RenderOptions& o) { o.output.tonemap = image::ToneCurve::Aces; });
    add([](RenderOptions& o) { o.aovs = {"depth"}; });
    add([](RenderOptions& o) { o.keep_noisy = true; });
    add([](RenderOptions& o) { o.reconstruction_layers = true; });
    follow("a");
    follow("b");
    EXPECT_EQ(hashes.size(), 22u);
    EXPECT_EQ(std::set({frame_hash(7, 1, {}), frame_hash(7, 2, {}), frame_hash(8, 1, {}), frame_hash(7, 1, 0), frame_hash(7, 1, 2)}).size(), 5u);
}

TEST(SceneHash, the_render_hash_covers_the_view_and_the_settings) {
    const LoadedScene loaded = load_scene("builtin:furnace");
    std::set<uint64_t> hashes;
    const auto add = [&](const std::function<void(ViewDesc&, RenderSettings&)>& change) {
        ViewDesc view;
        RenderSettings settings;
        change(view, settings);
        hashes.insert(hash_render(loaded.scene, view, settings));
    };
    add([](ViewDesc&, RenderSettings&) {});
    add([](ViewDesc& view, RenderSettings&) { view.seed = 1; });
    add([](ViewDesc& view, RenderSettings&) { view.width = 64; });
    add([](ViewDesc& view, RenderSettings&) { view.max_bounces = 3; });
    add([](ViewDesc& view, RenderSettings&) { view.filter = PixelFilter::Point; });
    add([](ViewDesc& view, RenderSettings&) { view.camera.position_ws.x += 0.5f; });
    add([](ViewDesc& view, RenderSettings&) { view.camera.orthographic = 1; });
    add([](ViewDesc& view, RenderSettings&) { view.camera.lens_radius = 0.5f; });
    add([](ViewDesc& view, RenderSettings&) { view.camera.focus_distance = 0.5f; });
    add([](ViewDesc& view, RenderSettings&) { view.camera_at_close = shared::Camera{.position_ws = glm::vec3(1.0f)}; });
    add([](ViewDesc&, RenderSettings& settings) { settings.sampler = SamplerKind::Pcg; });
    add([](ViewDesc&, RenderSettings& settings) { settings.infinite_share = 0.25f; });
    EXPECT_EQ(hashes.size(), 12u);
}

// A share of 0 or 1 would leave lights without extent unsampled: they would be missing from the picture.
TEST(RenderSettings, no_share_takes_all_samples_from_a_kind_of_light) {
    RenderSettings settings;
    for (const char* share : {"0", "1"}) {
        const std::string line = error_line([&] { apply_assignment(settings, fmt::format("light.infinite_share={}", share)); });
        EXPECT_NE(line.find("is out of range"), std::string::npos) << line;
    }
    apply_assignment(settings, "light.infinite_share=0.01");
    apply_assignment(settings, "light.infinite_share=0.99");
}

TEST(Metering, a_grey_card_gives_its_textbook_exposure) {
    // EV100 = log2(L * 100 / 12.5): 4096 nits are EV 15, the sunny 16 rule.
    EXPECT_EQ(metered_ev(std::vector<float>(100, 4096.0f)), 15.0);
    EXPECT_EQ(metered_ev(std::vector<float>(100, 1.0f)), 3.0);
    EXPECT_EQ(metered_ev(std::vector<float>(100, 0.0f)), 0.0);
    EXPECT_EQ(metered_ev({}), 0.0);
}

TEST(Metering, lamps_holes_and_broken_pixels_do_not_decide) {
    for (const float outlier : {1e6f, 1e-6f}) {
        std::vector<float> image(1000, 8.0f);
        for (size_t i = 0; i < 20; ++i) image[i] = outlier;
        for (size_t i = 80; i < 500; ++i) image[i] = 0.0f;
        image[600] = std::numeric_limits<float>::quiet_NaN();
        image[601] = std::numeric_limits<float>::infinity();
        EXPECT_EQ(metered_ev(image), 6.0) << outlier;
    }
    const double ev = metered_ev(std::vector<float>(10, 3.3333f));
    EXPECT_DOUBLE_EQ(ev, std::round(ev * 100) / 100) << "what is printed with two digits is what is used";
}

TEST(Pictures, rows_with_more_samples_have_the_same_mean) {
    image::FilmSums film = small_film({0, 64});
    for (size_t channel = 0; channel < 3; ++channel)  // the upper row has had another 32 samples of the same value
        for (size_t pixel = 0; pixel < 3; ++pixel) film.add_block(channel, pixel, float(1 + channel + 10 * pixel) * 32);
    const image::ImageF picture = resolve_rows(film, std::vector<uint64_t>{96, 64});
    for (size_t channel = 0; channel < 3; ++channel)
        for (size_t pixel = 0; pixel < 6; ++pixel) EXPECT_FLOAT_EQ(picture.plane(channel)[pixel], float(1 + channel + 10 * pixel));
    EXPECT_EQ(picture.attributes.at(kSamplesAttribute), "64");
    EXPECT_EQ(*recorded_exposure(picture.attributes), 4.25);
}

TEST(Pictures, equal_rows_resolve_as_the_film_does) {
    const image::FilmSums film = small_film({0, 100}, 0.3f);
    EXPECT_EQ(resolve_rows(film, std::vector<uint64_t>(2, 100)).data, image::resolve_film(film).data);
}

TEST(Merge, parts_in_any_order_give_the_whole_and_wrong_ones_are_named) {
    const TemporaryFolder folder;
    const auto write = [&](const std::string& name, const image::FilmSums& film) {
        image::write_film_exr(folder.file(name), film);
        return std::filesystem::path(folder.file(name));
    };
    const auto a = write("a.exr", small_film({0, 64})), b = write("b.exr", small_film({64, 128})),
               c = write("c.exr", small_film({128, 256}));
    const std::vector<std::filesystem::path> mixed{c, a, b};
    const image::FilmSums merged = merge_parts(mixed);
    EXPECT_EQ(merged.sample_end, 256u);
    EXPECT_EQ(merged.limbs, small_film({0, 256}).limbs);

    const auto line = [](const std::vector<std::filesystem::path>& parts) { return error_line([&] { merge_parts(parts); }); };
    EXPECT_NE(line({b, c}).find("b.exr: the samples 0-64 are missing before it"), std::string::npos);
    EXPECT_NE(line({a, c}).find("the samples 64-128 are missing"), std::string::npos);
    EXPECT_NE(line({a, b, b}).find("overlap"), std::string::npos);
    image::FilmSums other = small_film({64, 128});
    other.attributes = film_attributes(0xABCE, 4.25);
    EXPECT_NE(line({a, write("d.exr", other)}).find("d.exr: settings_hash"), std::string::npos);
}

TEST(Checkpoint, only_the_same_render_with_no_more_samples_is_resumed) {
    const TemporaryFolder folder;
    const image::FilmSums saved = small_film({0, 128});
    image::write_film_exr(folder.file("c"), saved);
    image::FilmSums expected = saved;
    EXPECT_EQ(read_checkpoint(folder.file("c"), expected, {0, 128}).limbs, saved.limbs);
    EXPECT_NE(error_line([&] {
                  read_checkpoint(folder.file("c"), expected, {0, 64});
              }).find("it already holds 128 samples"),
              std::string::npos);
    EXPECT_NE(error_line([&] { read_checkpoint(folder.file("c"), expected, {64, 256}); }).find("another render"), std::string::npos);
    expected.attributes = film_attributes(1, 4.25);
    EXPECT_NE(error_line([&] { read_checkpoint(folder.file("c"), expected, {0, 128}); }).find("another render"), std::string::npos);
}

TEST(EffectiveSettings, they_hold_types_defaults_and_settings) {
    const std::vector<std::string> words{"--exposure", "2.5", "--set", "reference.roulette_start=7", "--no-default-light"};
    const auto json = effective_settings(parse_options(Command::Render, words, [](const char*) -> const char* { return nullptr; }));
    EXPECT_EQ(json["schema"], 1);
    EXPECT_EQ(json["spp"], 64);
    EXPECT_EQ(json["size"], "1280x720");
    EXPECT_EQ(json["exposure"], 2.5);
    EXPECT_EQ(json["no-default-light"], true);
    EXPECT_EQ(json["set"]["reference.roulette_start"], 7);
    EXPECT_EQ(json["set"]["sampler.kind"], "owen");
    EXPECT_FALSE(json.contains("camera"));
    EXPECT_FALSE(json.contains("out"));
}

TEST(RenderSettings, every_setting_is_read_back_and_bounded) {
    for (const SettingRow& row : list_settings(RenderSettings{})) {
        RenderSettings settings;
        EXPECT_NO_THROW(apply_setting(settings, row.key, row.value)) << row.key;
        EXPECT_NE(error_line([&] { apply_setting(settings, row.key, "-7777"); }), "(no error)") << row.key;
        EXPECT_FALSE(row.help.empty());
    }
}

TEST(Results, an_error_as_json_has_its_four_parts) {
    const auto json = error_json(Error(ErrorCode::MissingFeature, "what", "where", "hint"));
    EXPECT_EQ(json.dump(), R"({"schema":1,"error":{"code":"missing_feature","what":"what","where":"where","hint":"hint"}})");
}

// The table names the film's AOVs; they may not drift apart.
TEST(RenderOptions, the_aovs_of_the_table_are_those_of_the_film) {
    const OptionSpec& option = *find_option(Command::Render, "--aov");
    const auto absent = split_choices(option.absent_choices);
    std::set<std::string_view> named, film;
    for (const std::string_view choice : split_choices(option.choices))
        if (std::find(absent.begin(), absent.end(), choice) == absent.end()) named.insert(choice);
    for (const std::string_view name : aov_names()) film.insert(name);
    film.insert("noisy");           // the picture before it was denoised
    film.insert("reconstruction");  // what it was made of
    EXPECT_EQ(named, film);
}

}  // namespace parhelion::session_test
