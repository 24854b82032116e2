// Every complete model of the folder that PARHELION_ASSETS names is loaded and drawn small: no validation message, no NaN, no
// picture that is one colour. Leaves contact sheets and an index (file, outcome, warnings, what is not drawn) in the build folder, under
// assets/: look at them.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/file.h"
#include "base/log.h"
#include "image/encode.h"
#include "scene/info.h"
#include "session/job.h"
#include "support/gpu_fixture.h"

namespace parhelion::testing::assets_test {
namespace {

namespace fs = std::filesystem;

constexpr uint32_t kTile = 128, kColumns = 10, kRows = 8;
constexpr uint64_t kMaxBytes = 1ull << 30;

// What is refused, and rightly: a required extension that nobody knows or that is not read, a version to come, a node with two parents.
const std::map<std::string, std::string> kRefused = {
    {"drc_dev/CubeScaledInstances/glTF/cube_att.gltf", "is a child of node 1 already"},
    {"gag_dev/Compatibility/Compatibility_04.gltf", "asks for glTF 2.1"},
    {"gltfpipeline_dev/box-shared-image-references/box-shared-image-references.gltf", "needs the extension KHR_techniques_webgl"},
    {"gltftransform_dev/cli/test/in/ACMEBox.gltf", "needs the extension ACME_gizmo"},
    {"stained_glass_lamp_ktx/StainedGlassLamp.gltf", "Basis Universal"},
};

struct Viewpoint {
    std::array<double, 3> from{}, at{};
    double fov = 45;
};

std::vector<std::string> split(const std::string& text, char separator) {
    std::vector<std::string> parts;
    std::istringstream stream(text);
    for (std::string part; std::getline(stream, part, separator);) parts.push_back(part);
    return parts;
}

// CAMERAS.tsv: name, "px,py,pz,tx,ty,tz,vfov", remark.
std::map<std::string, Viewpoint> read_cameras(const fs::path& root) {
    std::map<std::string, Viewpoint> out;
    std::ifstream file(root / "CAMERAS.tsv");
    for (std::string line; std::getline(file, line);) {
        const std::vector<std::string> cells = split(line, '\t');
        if (line.starts_with('#') || cells.size() < 2) continue;
        const std::vector<std::string> numbers = split(cells[1], ',');
        if (numbers.size() != 7) continue;
        Viewpoint& v = out[cells[0]];
        for (size_t i = 0; i < 3; ++i) v.from[i] = std::stod(numbers[i]), v.at[i] = std::stod(numbers[3 + i]);
        v.fov = std::stod(numbers[6]);
    }
    return out;
}

// The camera that a Manifest.json beside the model gives it: it looks at the origin.
std::optional<Viewpoint> manifest_camera(const fs::path& model) {
    const fs::path path = model.parent_path() / "Manifest.json";
    if (!fs::exists(path)) return std::nullopt;
    const auto manifest = nlohmann::json::parse(read_text_file(path, kMaxBytes));
    if (!manifest.is_object()) return std::nullopt;
    for (const auto& row : manifest.at("models")) {
        if (row.at("fileName") != model.filename().string() || !row.contains("camera")) continue;
        Viewpoint v;
        for (size_t i = 0; i < 3; ++i) v.from[i] = row.at("camera").at("translation").at(i).get<double>();
        return v;
    }
    return std::nullopt;
}

struct Model {
    fs::path path;
    std::optional<Viewpoint> viewpoint;
};

std::vector<Model> complete_models(const fs::path& root) {
    const auto cameras = read_cameras(root);
    std::vector<Model> models;
    std::ifstream index(root / "INDEX.tsv");
    for (std::string line; std::getline(index, line);) {
        const std::vector<std::string> cells = split(line, '\t');
        if (cells.size() < 3 || cells[2] == "malformed" || !fs::is_directory(root / cells[0])) continue;
        const auto camera = cameras.find(cells[0]);
        for (const auto& entry : fs::recursive_directory_iterator(root / cells[0])) {
            if (entry.path().extension() != ".gltf" && entry.path().extension() != ".glb") continue;
            std::optional<Viewpoint> viewpoint = manifest_camera(entry.path());
            if (camera != cameras.end()) viewpoint = camera->second;
            models.push_back({entry.path(), viewpoint});
        }
    }
    std::sort(models.begin(), models.end(), [](const Model& a, const Model& b) { return a.path < b.path; });
    return models;
}

std::string join(const std::vector<std::string>& texts) {
    std::string out;
    for (const std::string& text : texts) out += (out.empty() ? "" : "; ") + escape_name(text, 300);
    return out;
}

class Assets : public GpuTest {
protected:
    // Models that only glow a little are shown under the sky, as those without any light are.
    static RenderOptions options_for(const Model& model, const SceneInfo& info, const fs::path& picture, const fs::path& light) {
        RenderOptions options;
        options.scene = model.path.string();
        options.size = {kTile, kTile};
        options.samples = {0, 16};
        options.trace = TraceChoice::Compute;
        options.output.files = {picture, light};
        if (info.emitters != 0 && info.lights.empty()) options.environment = "sky";
        if (model.viewpoint) {
            options.look_from = model.viewpoint->from;
            options.look_at = model.viewpoint->at;
            options.fov_degrees = model.viewpoint->fov;
        }
        return options;
    }
    static bool one_color(const image::Texture8& picture) {
        for (size_t i = 4; i < picture.rgba.size(); ++i)
            if (picture.rgba[i] != picture.rgba[i % 4]) return false;
        return true;
    }
    static void put(image::Picture8& sheet, const image::Texture8& tile, size_t place) {
        const size_t x0 = place % kColumns * kTile, y0 = place / kColumns * kTile;
        for (size_t y = 0; y < kTile; ++y)
            for (size_t x = 0; x < kTile; ++x)
                for (size_t c = 0; c < 3; ++c) sheet.rgb[((y0 + y) * sheet.width + x0 + x) * 3 + c] = tile.rgba[(y * kTile + x) * 4 + c];
    }
};

TEST_F(Assets, every_complete_model_is_drawn) {
    const char* folder = std::getenv("PARHELION_ASSETS");
    if (folder == nullptr) GTEST_SKIP() << "PARHELION_ASSETS is not set";
    const std::vector<Model> models = complete_models(folder);
    ASSERT_FALSE(models.empty()) << folder;
    const fs::path out = fs::path(PARHELION_BINARY_DIR) / "assets";
    fs::create_directories(out);
    std::ofstream index(out / "index.tsv");
    index << "sheet\ttile\tfile\toutcome\tseconds\twarnings\tnot drawn\n";
    size_t count = 0, refused = 0, warned = 0;
    image::Picture8 sheet;
    const auto write_sheet = [&] { image::write_png(out / fmt::format("sheet{}.png", (count - 1) / (kColumns * kRows)), sheet); };
    for (const Model& model : models) {
        const std::string name = fs::relative(model.path, folder).string();
        const size_t place = count % (kColumns * kRows);
        if (place == 0) sheet = {kColumns * kTile, kRows * kTile, std::vector<uint8_t>(size_t(kColumns) * kRows * kTile * kTile * 3, 96)};
        std::string outcome = "drawn", warnings, not_drawn;
        double seconds = 0;
        try {
            const SceneInfo info = describe(load_scene(model.path.string()));
            warnings = join(info.warnings);
            not_drawn = join(info.extensions_not_drawn);
            const fs::path picture_path = out / "tile.png", light_path = out / "tile.exr";
            const RenderReport report = run_render_job(options_for(model, info, picture_path, light_path), device());
            seconds = report.load_seconds + report.setup_seconds + report.render_seconds;
            const image::Texture8 picture = image::decode_png(read_file(picture_path, kMaxBytes));
            put(sheet, picture, place);
            for (const float v : image::decode_exr(read_file(light_path, kMaxBytes)).data) ASSERT_TRUE(std::isfinite(v) && v >= 0.0f) << name;
            if (one_color(picture)) outcome = "drawn, one colour";
            warned += warnings.empty() ? 0 : 1;
        } catch (const Error& error) {
            outcome = error.line;
            ++refused;
            const auto expected = kRefused.find(name);
            EXPECT_TRUE(expected != kRefused.end() && error.line.find(expected->second) != std::string::npos) << error.line;
        }
        index << count / (kColumns * kRows) << '\t' << place / kColumns << ',' << place % kColumns << '\t' << name << '\t' << outcome << '\t'
              << fmt::format("{:.2f}", seconds) << '\t' << warnings << '\t' << not_drawn << std::endl;
        ++count;
        if (place + 1 == kColumns * kRows) write_sheet();
    }
    if (count % (kColumns * kRows) != 0) write_sheet();
    fs::remove(out / "tile.png");
    fs::remove(out / "tile.exr");
    std::printf("%zu models: %zu drawn, %zu of them with warnings, %zu refused; see %s\n", count, count - refused, warned, refused, out.c_str());
}

}  // namespace
}  // namespace parhelion::testing::assets_test
