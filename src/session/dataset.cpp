#include "session/dataset.h"

#include <utility>

#include "base/error.h"
#include "base/file.h"
#include "session/pictures.h"
#include "session/reconstruction_layers.h"
#include "session/version.h"

namespace parhelion {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

constexpr const char* kIndex = "dataset.json";
constexpr uint64_t kMostIndexBytes = 1u << 30;

std::string text_of(const Json& json, int indent) { return json.dump(indent, ' ', false, Json::error_handler_t::replace); }  // invalid UTF-8 of names: U+FFFD
std::string shown(const fs::path& path) { return escape_name(path.string()); }
std::string input_name(uint64_t frame) { return frame_file("frame.####.exr", frame).string(); }
std::string reference_name(uint64_t frame) { return frame_file("reference.####.exr", frame).string(); }

// For who finds the folder without the program's documents.
Json conventions() {
    return {{"images", "rows from the top; x to the right, y down; pixel (i, j) looks through film position (i + 0.5, j + 0.5) + jitter_px"},
            {"world", "right-handed, +Y up, metres"},
            {"light", "frame files: linear Rec.709 in nits times exposure; reference files: nits"},
            {"raw", "nits of the noisy frame = (diffuse * albedo + specular * specular_albedo + emission) / exposure"},
            {"depth", "metres along the camera's forward axis; +infinity: sky"},
            {"motion", "where the surface was on the last frame's film minus where it is, pixels, without jitter; +infinity: it was not in front"},
            {"hit", "metres from the surface to what the path met; 0: it took the other lobe"},
            {"camera", "a film position (x, y) of a picture w by h looks along forward + (2 x / w - 1) right + (1 - 2 y / h) up"},
            {"clip_from_world", "rows, for (x, y, z, 1); film position = ((1 + cx / cw) w / 2, (1 + cy / cw) h / 2)"}};
}

}  // namespace

void check_dataset_folder(const fs::path& folder) {
    std::error_code ec;
    const auto refuse = [&](std::string what, std::string hint) { throw Error(ErrorCode::Failed, std::move(what), shown(folder), std::move(hint)); };
    if (!fs::exists(folder, ec)) {
        const fs::path whole = fs::absolute(folder, ec), parent = (whole.has_filename() ? whole : whole.parent_path()).parent_path();
        if (!fs::is_directory(parent, ec)) refuse(fmt::format("the folder '{}' does not exist", shown(parent)), "create it first");
        return;
    }
    if (!fs::is_directory(folder, ec)) refuse("is a file; a dataset needs a folder", "choose another name");
    if (!fs::exists(folder / kIndex, ec) && !fs::is_empty(folder, ec)) refuse(fmt::format("the folder is not empty and has no {}", kIndex), "choose an empty folder, or a new name");
    check_writable(folder / kIndex);
}

Json describe_dataset(const RenderOptions& options, const RenderReport& report, uint64_t reference_hash) {
    const auto hash = [](uint64_t value) { return fmt::format("{:016x}", value); };
    return {{"dataset", "reconstruction"},
            {"layout", kReconstructionLayout},
            {"program", fmt::format("parhelion {}", version())},
            {"scene", options.scene},
            {"animation", options.load.animation},
            {"animate", options.load.animate},
            {"camera", report.camera},
            {"camera_path", options.camera_path.string()},
            {"size", {options.size.width, options.size.height}},
            {"seed", options.seed},
            {"max_bounces", options.max_bounces},
            {"time", options.load.time},
            {"fps", options.play->fps},
            {"exposure_ev100", report.exposure_ev},
            {"denoise", options.denoise == DenoiseKind::Builtin ? "builtin" : "none"},
            {"set", options.assignments},
            {"settings_hash", hash(report.settings_hash)},
            {"reference", {{"renderer", "reference"}, {"spp", options.reference_samples}, {"settings_hash", hash(reference_hash)}}},
            {"conventions", conventions()}};
}

Dataset::Dataset(fs::path folder, const Json& about) : folder_(std::move(folder)), about_(Json::parse(text_of(about, -1))) {
    std::error_code ec;
    fs::create_directory(folder_, ec);
    if (!fs::is_directory(folder_, ec)) throw Error(ErrorCode::Failed, "the folder cannot be made", shown(folder_), "choose a folder that you may write to");
    if (fs::exists(folder_ / kIndex, ec)) read();
    else write();
}

void Dataset::read() {
    const fs::path file = folder_ / kIndex;
    const auto refuse = [&](std::string what, std::string hint) { throw Error(ErrorCode::Failed, std::move(what), shown(file), std::move(hint)); };
    const Json index = Json::parse(read_text_file(file, kMostIndexBytes), nullptr, false);
    if (!index.is_object() || !index.contains("frames") || !index["frames"].is_array()) refuse("it is no list of a dataset's frames", "choose an empty folder, or a new name");
    for (const auto& [key, value] : about_.items())
        if (!index.contains(key) || index[key] != value)
            refuse(fmt::format("it is another dataset: its '{}' is not this one's", key), "repeat the command that began it, or choose another folder");
    for (const Json& entry : index["frames"]) {
        if (!entry.is_object() || !entry.contains("frame") || !entry["frame"].is_number_unsigned()) refuse("a frame has no number", "choose another folder");
        frames_[entry["frame"].get<uint64_t>()] = entry;
    }
}

void Dataset::write() const {
    // A frame a line.
    std::string text = text_of(about_, 1);
    text.erase(text.rfind('\n'));
    text += ",\n \"frames\": [";
    const char* separator = "\n  ";
    for (const auto& [number, entry] : frames_) text += std::exchange(separator, ",\n  ") + text_of(entry, -1);
    write_text_file(folder_ / kIndex, text + "\n ]\n}\n");
}

bool Dataset::has(uint64_t frame) const {
    std::error_code ignored;
    return frames_.contains(frame) && fs::exists(folder_ / input_name(frame), ignored) && fs::exists(folder_ / reference_name(frame), ignored);
}

void Dataset::add(Pair pair, const OutputOptions& output) {
    const auto write_exr = [&](const std::string& name, const image::ImageF& picture) {
        OutputOptions one = output;
        one.files = {folder_ / name};
        write_pictures(one, picture);
    };
    add_reconstruction_layers(pair.input, pair.layers);
    write_exr(input_name(pair.frame), pair.layers);
    write_exr(reference_name(pair.frame), pair.reference);
    Json entry = {{"frame", pair.frame}, {"time", pair.time}, {"input", input_name(pair.frame)}, {"reference", reference_name(pair.frame)}};
    entry.update(input_json(pair.input));
    entry.erase("layout");
    frames_[pair.frame] = std::move(entry);
    write();
}

}  // namespace parhelion
