// What reconstruction gets, as layers of an EXR (--aov reconstruction) and in the folders of --dataset: what the layers say is held against the
// picture, against each other over two frames, and against other runs. No test here depends on chance.
#include <cmath>
#include <csignal>

#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/file.h"
#include "image/decode.h"
#include "session/job.h"
#include "support/gpu_fixture.h"
#include "support/process.h"

namespace parhelion::testing::dataset_test {
namespace {

using Json = nlohmann::json;
using Words = std::vector<std::string>;

// A file with its layers and its words.
struct Input {
    image::ImageF image;
    Json words;

    explicit Input(const std::filesystem::path& file) : image(image::read_linear(file)), words(Json::parse(image.attributes["reconstruction"], nullptr, false)) {}
    float at(std::string_view layer, size_t pixel) const { return image.plane(image.find_channel("reconstruction." + std::string(layer)).value())[pixel]; }
    glm::dvec3 rgb(const std::string& layer, size_t pixel) const { return {at(layer + ".R", pixel), at(layer + ".G", pixel), at(layer + ".B", pixel)}; }
    glm::dvec2 size() const { return {words["size"][0], words["size"][1]}; }
    // Where on the film a pixel looks.
    glm::dvec2 film(size_t pixel) const { return glm::dvec2(double(pixel % image.width) + 0.5, double(pixel / image.width) + 0.5) + glm::dvec2(words["jitter_px"][0], words["jitter_px"][1]); }
    glm::dvec2 motion(size_t pixel) const { return {at("motion.X", pixel), at("motion.Y", pixel)}; }
};

glm::dvec3 vector_of(const Json& v) { return {v[0], v[1], v[2]}; }

// By the camera's words: the point at a depth, and by its matrix: back to the film.
glm::dvec3 place(const Json& camera, glm::dvec2 film, glm::dvec2 size, double depth) {
    return vector_of(camera["position"]) +
           depth * (vector_of(camera["forward"]) + (2 * film.x / size.x - 1) * vector_of(camera["right"]) + (1 - 2 * film.y / size.y) * vector_of(camera["up"]));
}
glm::dvec2 project(const Json& camera, glm::dvec3 point, glm::dvec2 size) {
    const auto row = [&](int i) { return glm::dot(glm::dvec4(point, 1.0), glm::dvec4(camera["clip_from_world"][i][0], camera["clip_from_world"][i][1], camera["clip_from_world"][i][2], camera["clip_from_world"][i][3])); };
    return {(1 + row(0) / row(3)) * size.x / 2, (1 + row(1) / row(3)) * size.y / 2};
}

class Dataset : public GpuTest {
protected:
    TemporaryFolder folder;

    RenderOptions options(const std::string& scene, IndexRange frames) const {
        RenderOptions out;
        out.scene = scene;
        out.renderer = RendererKind::Realtime;
        out.size = {24, 16};
        out.max_bounces = 3;
        out.exposure_ev = 3.0;
        out.output.exr_float = true;
        out.output.files = {folder.file("a.####.exr")};
        out.trace = TraceChoice::Compute;
        out.play = {.frames = frames, .fps = 4};
        out.reference_samples = 3;
        return out;
    }
    // Both move: what turns, and the camera.
    RenderOptions moving(IndexRange frames) const {
        write_text_file(folder.file("path.json"), R"({"keys": [{"time": 0, "look_from": [0, 1, 3.8], "look_at": [0, 1, 0]}, {"time": 1, "look_from": [0.5, 1.2, 3.5], "look_at": [0, 1, 0]}]})");
        RenderOptions out = options("builtin:cornell", frames);
        out.load.animate = "spin";
        out.camera_path = folder.file("path.json");
        out.denoise = DenoiseKind::Builtin;
        return out;
    }
    RenderReport run(const RenderOptions& what) const { return run_render_job(what, device()); }
    Input input(const std::string& name) const { return Input(folder.file(name)); }
    std::string bytes(const std::string& name) const { return read_bytes(folder.file(name)); }
    Json index(const char* name) const { return Json::parse(bytes(std::string(name) + "/dataset.json"), nullptr, false); }
    std::string error_of(const RenderOptions& what) const {
        try {
            run(what);
            return "no error";
        } catch (const Error& error) {
            return error.line;
        }
    }
};

}  // namespace

TEST_F(Dataset, the_noisy_frame_is_the_sum_of_its_layers) {
    for (const char* scene : {"builtin:cornell", "builtin:reflections", "builtin:spheres"}) {
        for (const bool exr_float : {true, false}) {
            RenderOptions job = options(scene, {1, 2});
            job.reconstruction_layers = true;
            job.output.exr_float = exr_float;
            run(job);
            const Input frame = input("a.0001.exr");
            const double exposure = frame.words["exposure"], slack = exr_float ? 1e-5 : 3.0 / 2048;
            EXPECT_NE(exposure, 1.0);
            double diffuse = 0, specular = 0;
            for (size_t p = 0; p < frame.image.pixel_count(); ++p)
                for (int c = 0; c < 3; ++c) {
                    const double d = frame.rgb("diffuse", p)[c] * frame.rgb("albedo", p)[c], s = frame.rgb("specular", p)[c] * frame.rgb("specular_albedo", p)[c];
                    const double sum = (d + s + frame.rgb("emission", p)[c]) / exposure, shown = frame.image.plane(frame.image.find_channel(std::string(1, "RGB"[c])).value())[p];
                    ASSERT_NEAR(shown, std::min(sum, exr_float ? sum : 65504.0), slack * shown + 1e-6) << scene << " pixel " << p;
                    diffuse += d, specular += s;
                }
            EXPECT_GT(diffuse, 0) << scene;
            EXPECT_TRUE(specular > 0 || scene == std::string_view("builtin:cornell")) << scene;
        }
    }
}

TEST_F(Dataset, layers_hold_what_was_there_before_reconstruction) {
    RenderOptions job = options("builtin:reflections", {0, 3});
    job.reconstruction_layers = true;
    run(job);
    job.denoise = DenoiseKind::Builtin;
    job.assignments = {"reconstruction.antialias=off", "reconstruction.follow=off"};  // no jitter: the same rays
    job.output.files = {folder.file("b.####.exr")};
    run(job);
    job.assignments.clear();
    job.output.files = {folder.file("c.####.exr")};
    run(job);
    for (const char* number : {"0000", "0001", "0002"}) {
        const Input raw = input(fmt::format("a.{}.exr", number)), still = input(fmt::format("b.{}.exr", number)), jittered = input(fmt::format("c.{}.exr", number));
        EXPECT_EQ(raw.words, still.words);
        EXPECT_EQ(raw.words["cut"], number == std::string_view("0000"));
        EXPECT_EQ(raw.words["jitter_px"], (Json{0.0, 0.0}));
        EXPECT_NE(raw.words["jitter_px"], jittered.words["jitter_px"]);
        for (size_t c = 0; c < raw.image.channels.size(); ++c) {
            const std::string& channel = raw.image.channels[c];
            if (!channel.starts_with("reconstruction.")) continue;
            EXPECT_TRUE(std::ranges::equal(raw.image.plane(c), still.image.plane(still.image.find_channel(channel).value()))) << number << ' ' << channel;
        }
        EXPECT_FALSE(std::ranges::equal(raw.image.plane(0), still.image.plane(0))) << "the picture is reconstructed";
    }
}

TEST_F(Dataset, matrices_project_and_motion_points_to_where_the_surface_was) {
    RenderOptions job = moving({2, 4});
    job.size = {48, 32};
    job.reconstruction_layers = true;
    run(job);
    const Input before = input("a.0002.exr"), now = input("a.0003.exr");
    EXPECT_EQ(now.words["camera_before"], before.words["camera"]);
    EXPECT_NE(now.words["camera"], before.words["camera"]);
    const glm::dvec2 size = now.size();
    size_t still = 0, moved = 0, followed = 0, looked = 0, floor = 0;
    for (size_t p = 0; p < now.image.pixel_count(); ++p) {
        if (std::isinf(now.at("depth", p))) continue;
        const glm::dvec2 film = now.film(p), was = film + now.motion(p);
        const glm::dvec3 point = place(now.words["camera"], film, size, now.at("depth", p));
        ASSERT_LT(glm::length(project(now.words["camera"], point, size) - film), 1e-3) << p;
        if (now.at("normal_geometric.Y", p) > 0.999 && point.y < 0.3) {
            EXPECT_NEAR(point.y, 0.0, 1e-3) << "the floor is flat, where the jitter is that of the rays";
            ++floor;
        }
        (glm::length(project(now.words["camera_before"], point, size) - was) < 0.02 ? still : moved) += 1;
        // What the pixel there showed a frame ago: the same thing, but at outlines.
        const glm::ivec2 at(glm::floor(was - glm::dvec2(before.words["jitter_px"][0], before.words["jitter_px"][1])));
        if (at.x < 0 || at.y < 0 || at.x >= int(size.x) || at.y >= int(size.y)) continue;
        ++looked;
        followed += now.at("ids.instance", p) == before.at("ids.instance", size_t(at.y) * now.image.width + size_t(at.x));
    }
    EXPECT_GT(floor, 50u);
    EXPECT_GT(still, 2 * moved) << "walls";
    EXPECT_GT(moved, 30u) << "what turns";
    EXPECT_GT(double(followed), 0.9 * double(looked));
}

TEST_F(Dataset, frames_are_those_of_a_run_without_one) {
    RenderOptions job = moving({1, 4});
    job.aovs = {"depth"};
    run(job);
    RenderOptions with = job;
    with.output.files = {folder.file("b.####.exr")};
    with.dataset = folder.file("set");
    run(with);
    RenderOptions layers = job;
    layers.output.files = {folder.file("c.####.exr")};
    layers.reconstruction_layers = true;
    run(layers);
    for (const char* number : {"0001", "0002", "0003"}) {
        EXPECT_EQ(bytes(fmt::format("a.{}.exr", number)), bytes(fmt::format("b.{}.exr", number)));
        const Input kept = input(fmt::format("set/frame.{}.exr", number)), shown = input(fmt::format("c.{}.exr", number));
        EXPECT_EQ(kept.words, shown.words);
        EXPECT_EQ(kept.image.channels.size(), 31u);
        for (size_t c = 0; c < kept.image.channels.size(); ++c)
            EXPECT_TRUE(std::ranges::equal(kept.image.plane(c), shown.image.plane(shown.image.find_channel(kept.image.channels[c]).value()))) << number << ' ' << kept.image.channels[c];
    }
    const Json list = index("set");
    ASSERT_EQ(list["frames"].size(), 3u);
    EXPECT_EQ(list["frames"][0]["frame"], 1);
    EXPECT_EQ(list["frames"][2]["time"], 0.75);
    EXPECT_EQ(list["frames"][2]["camera"], input("set/frame.0003.exr").words["camera"]);
}

TEST_F(Dataset, references_are_the_frames_of_the_reference_renderer) {
    RenderOptions job = moving({1, 3});
    job.dataset = folder.file("set");
    job.output.files.clear();
    const RenderReport report = run(job);
    EXPECT_EQ(report.written, (std::vector<std::filesystem::path>{folder.file("set")}));
    EXPECT_EQ(report.sample_count(), 2u);
    RenderOptions reference = job;
    reference.dataset.clear();
    reference.renderer = RendererKind::Reference;
    reference.denoise = DenoiseKind::None;
    reference.samples = {0, 3};
    reference.aovs = {"variance"};
    reference.output.files = {folder.file("r.####.exr")};
    run(reference);
    for (const char* number : {"0001", "0002"}) EXPECT_EQ(bytes(fmt::format("set/reference.{}.exr", number)), bytes(fmt::format("r.{}.exr", number))) << number;
}

TEST_F(Dataset, a_folder_is_gone_on_with_by_the_same_command_alone) {
    RenderOptions job = moving({0, 2});
    job.dataset = folder.file("set");
    job.output.files.clear();
    run(job);
    const auto written = [&](const char* name) { return std::filesystem::last_write_time(folder.path() / "set" / name); };
    const auto first = written("frame.0000.exr");
    const std::string second = bytes("set/reference.0001.exr");
    std::filesystem::remove(folder.file("set/reference.0001.exr"));
    job.play->frames = {0, 3};
    EXPECT_EQ(run(job).sample_count(), 3u);
    EXPECT_EQ(written("frame.0000.exr"), first) << "is there and stays";
    EXPECT_EQ(bytes("set/reference.0001.exr"), second) << "was lost and is made again";
    EXPECT_EQ(index("set")["frames"].size(), 3u);
    const std::string whole = bytes("set/dataset.json");

    std::filesystem::create_directory(folder.file("set/reference.0003.exr"));  // cannot be written
    job.play->frames = {0, 4};
    EXPECT_NE(error_of(job).find("reference.0003.exr"), std::string::npos) << error_of(job);
    EXPECT_EQ(bytes("set/dataset.json"), whole) << "half a frame is none";

    RenderOptions other = job;
    other.reference_samples = 4;
    EXPECT_NE(error_of(other).find("set/dataset.json: it is another dataset: its 'reference' is not this one's (repeat the command that began it"), std::string::npos) << error_of(other);
    other = job;
    other.scene = "builtin:spheres", other.load.animate = "", other.camera_path.clear();
    EXPECT_NE(error_of(other).find("its 'scene' is not"), std::string::npos) << error_of(other);
    EXPECT_EQ(bytes("set/dataset.json"), whole);
    const auto expect_refused = [&](const std::string& name, const char* message) {
        other = job;
        other.dataset = folder.file(name);
        EXPECT_NE(error_of(other).find(message), std::string::npos) << error_of(other);
    };
    write_text_file(folder.file("set/dataset.json"), whole.substr(0, whole.size() / 2));
    expect_refused("set", "it is no list of a dataset's frames");
    std::filesystem::remove(folder.file("set/dataset.json"));
    expect_refused("set", "the folder is not empty and has no dataset.json (choose an empty folder");
    expect_refused("path.json", "is a file; a dataset needs a folder");
    expect_refused("none/set/", "does not exist (create it first)");
}

TEST_F(Dataset, an_interrupted_one_has_whole_frames_and_is_gone_on_with) {
    ProcessOptions interrupt{.signal = SIGINT};
    interrupt.signal_when = [&](const ProcessResult&) { return std::filesystem::exists(folder.file("set/frame.0001.exr")); };
    const ProcessResult result = run_parhelion({"render", "builtin:cornell", "--renderer", "realtime", "--size", "24x16", "--exposure", "3", "--max-bounces", "3", "--trace", "compute", "--animate", "spin", "--fps", "4",
                                                "--frames", "1000", "--dataset", folder.file("set"), "--reference-spp", "256", "--json", "-"},
                                               interrupt);
    EXPECT_EQ(result.exit_code, 130) << result.err;
    EXPECT_LT(result.seconds_after_signal, 5.0);
    const size_t frames = index("set")["frames"].size();
    ASSERT_GE(frames, 1u);
    EXPECT_EQ(result.json()["frames"], frames);
    for (size_t i = 0; i < frames; ++i) EXPECT_NE(input(fmt::format("set/frame.{:04}.exr", i)).words["size"], Json()) << i;

    RenderOptions job = options("builtin:cornell", {0, frames + 1});
    job.load.animate = "spin";
    job.output.files.clear();
    job.output.exr_float = false;
    job.reference_samples = 256;
    job.dataset = folder.file("set");
    run(job);
    job.dataset = folder.file("again");
    job.play->frames.begin = frames - 1;
    run(job);
    for (const size_t i : {frames - 1, frames})
        for (const char* kind : {"frame", "reference"}) {
            const std::string name = fmt::format("{}.{:04}.exr", kind, i);
            EXPECT_FALSE(bytes("set/" + name).empty());
            EXPECT_EQ(bytes("set/" + name), bytes("again/" + name)) << name;
        }
}

}  // namespace parhelion::testing::dataset_test
