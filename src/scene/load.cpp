#include "scene/load.h"

#include <algorithm>
#include <cmath>

#include "base/file.h"
#include "base/log.h"
#include "image/decode.h"
#include "scene/gltf/read.h"
#include "scene/gltf/variants.h"
#include "scene/pose.h"

namespace parhelion {

namespace {

std::string file_hint(const std::filesystem::path& path) {
    const std::string extension = path.extension().string();
    if (extension == ".gltf" || extension == ".glb") return {};
    return "SCENE is a .gltf or .glb file, or builtin:NAME";
}

const ScriptedEdit& find_scripted_edit(const LoadedScene& loaded, const std::string& name) {
    std::string names;
    for (const ScriptedEdit& edit : loaded.scripted_edits) {
        if (edit.name == name) return edit;
        names += (names.empty() ? "" : ", ") + edit.name;
    }
    throw Error(ErrorCode::Usage, fmt::format("{} has no scripted edit '{}'", loaded.scene.source().name, escape_name(name)), "--animate", "it has " + names);
}

LoadedScene load_builtin(const std::string& name, const LoadOptions& options) {
    find_variant({}, options.variant, name);
    if (!options.animation.empty())
        throw Error(ErrorCode::Usage, "animations belong to glTF files", "--animation", "--animate plays a scripted edit of a built-in scene");
    try {
        LoadedScene loaded = make_builtin(name, options.builtin);
        loaded.scene.apply(state_at(loaded, options, options.time));
        loaded.scene.begin_frame();  // what stands somewhere at the start has not moved there
        return loaded;
    } catch (const std::bad_alloc&) {
        throw Error(ErrorCode::Failed, "does not fit into the memory of this machine", escape_name(name));
    }
}

}  // namespace

LoadedScene load_scene(const std::string& name, const LoadOptions& options) {
    if (options.builtin.triangles != 0 && name != "builtin:forest" && name != "builtin:room" && name != "builtin:room-instanced")
        throw Error(ErrorCode::Usage, "only builtin:forest and builtin:room come in several sizes", "--triangles", "leave the option out");
    if (is_builtin(name)) return load_builtin(name, options);
    if (!options.animate.empty())
        throw Error(ErrorCode::Usage, "scripted edits belong to built-in scenes", "--animate", "--animation plays an animation of a glTF file");
    const std::filesystem::path path(name);
    const std::string shown = escape_name(name);
    std::error_code ec;
    if (!std::filesystem::exists(path, ec)) throw Error(ErrorCode::Failed, "there is no such file", shown, file_hint(path));
    const std::filesystem::path folder = path.parent_path();
    SceneFiles files(folder.empty() ? "." : folder, options.limits);
    const SceneFiles::Bytes bytes = files.read_main(path);
    try {
        LoadedScene out;
        out.scene.apply(read_gltf(files, *bytes, shown, {.median_order = options.median_order, .keep_encoded = options.keep_encoded, .variant = options.variant}));
        const auto charge = [&](uint64_t memory) { files.charge(memory, shown); };
        if (!options.at_rest) out.scene.apply(pose_at(out.scene, options.time, options.animation, charge));
        out.scene.begin_frame();
        for (const std::string& warning : out.scene.source().warnings) log(LogLevel::Warn, "{}: {}", shown, warning);
        return out;
    } catch (const std::bad_alloc&) {
        throw Error(ErrorCode::Failed, "does not fit into the memory of this machine", shown);
    }
}

SceneEdit state_at(const LoadedScene& loaded, const LoadOptions& options, double seconds) {
    if (!options.animate.empty()) return find_scripted_edit(loaded, options.animate).apply(loaded.scene, seconds);
    return loaded.scene.animations().empty() ? SceneEdit() : pose_at(loaded.scene, seconds, options.animation);
}

Environment load_environment(const std::filesystem::path& path) {
    constexpr uint64_t kMaxBytes = 4ull << 30;
    constexpr float kLargest = 65504.0f;
    const std::string shown = escape_name(path.string());
    const image::ImageF image = image::decode_linear(read_file(path, kMaxBytes), {}, shown);
    const image::RgbPlanes planes = image::rgb_planes(image, {}, shown);
    Environment out{.name = path.filename().string(), .width = image.width, .height = image.height, .scale = glm::vec3(1.0f)};
    out.radiance.resize(image.pixel_count());
    size_t mended = 0;
    const auto mend = [&](float x) {
        if (x >= 0.0f && x < std::numeric_limits<float>::infinity()) return x;
        ++mended;
        return x > 0.0f ? kLargest : 0.0f;
    };
    for (size_t i = 0; i < out.radiance.size(); ++i) out.radiance[i] = {mend(planes.r[i]), mend(planes.g[i]), mend(planes.b[i])};
    if (mended != 0) log(LogLevel::Warn, "{}: {} values were negative or not finite and were mended", shown, mended);
    if (image.width != 2 * image.height)
        log(LogLevel::Warn, "{}: is {}x{}; an equirectangular map is twice as wide as high", shown, image.width, image.height);
    return out;
}

}  // namespace parhelion
