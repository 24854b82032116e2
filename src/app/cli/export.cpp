// parhelion export: a scene to glTF.
#include <cstdlib>

#include <nlohmann/json.hpp>

#include "app/cli/commands.h"
#include "base/file.h"
#include "base/log.h"
#include "scene/gltf/write.h"
#include "scene/load.h"
#include "session/render_options.h"
#include "session/results.h"
#include "session/version.h"

namespace parhelion::cli {

namespace {

std::filesystem::path read_target(const OptionValues& values) {
    if (!values.given("--out")) throw Error(ErrorCode::Usage, "there is no output", "export", "add --out F.glb or --out F.gltf");
    const std::filesystem::path path = values.text("--out");
    if (!is_gltf_name(path))
        throw Error(ErrorCode::Usage, fmt::format("'{}' is neither .glb nor .gltf", escape_name(path.string())), "--out", "the extension chooses the form");
    check_writable(path);
    return path;
}

// The file's own order of triangles and its own images, nothing posed.
LoadOptions read_export_options(const OptionValues& values) {
    LoadOptions load = read_load_options(values);
    if (!is_builtin(values.positionals.front()) && values.given("--time"))
        throw Error(ErrorCode::Usage, "the animations of a file are exported as they are, the scene at rest", "--time", "leave it out");
    load.median_order = false;
    load.keep_encoded = true;
    load.at_rest = true;
    return load;
}

}  // namespace

int run_export(const OptionValues& values) {
    const LoadOptions load = read_export_options(values);
    const std::filesystem::path path = read_target(values);
    const std::string json = values.given("--json") ? values.text("--json") : "";
    check_json_target(json);
    const LoadedScene loaded = load_scene(values.positionals.front(), load);
    const GltfWritten written = write_gltf(loaded.scene, path, {.generator = fmt::format("Parhelion {}", version())});
    for (const std::string& warning : written.warnings) log(LogLevel::Warn, "{}: {}", escape_name(path.string()), warning);
    log(LogLevel::Info, "{}: {:.1f} MB in {} file{}", escape_name(path.string()), static_cast<double>(written.bytes) / 1e6, written.files.size(),
        written.files.size() == 1 ? "" : "s");
    std::vector<std::string> files;
    for (const std::filesystem::path& file : written.files) files.push_back(file.string());
    write_json(json, {{"files", files}, {"bytes", written.bytes}, {"warnings", written.warnings}});
    return EXIT_SUCCESS;
}

}  // namespace parhelion::cli
