#include "session/render_options.h"

#include <algorithm>

#include "base/error.h"
#include "renderers/rendered_view.h"

namespace parhelion {

namespace {

constexpr uint64_t kSampleBlock = 64;  // samples are summed in blocks of this many

// The position of a Choice's value among its choices, which is the value of the enum.
template <class Enum>
Enum read_choice(const OptionValues& values, std::string_view name) {
    const auto choices = split_choices(find_option(values.command(), name)->choices);
    return static_cast<Enum>(std::find(choices.begin(), choices.end(), values.text(name)) - choices.begin());
}

uint32_t read_uint(const OptionValues& values, std::string_view name) { return static_cast<uint32_t>(parse_int(values.text(name), name)); }

std::optional<double> read_optional_number(const OptionValues& values, std::string_view name) {
    return values.given(name) ? std::optional(parse_float(values.text(name), name)) : std::nullopt;
}

std::optional<std::array<double, 3>> read_optional_vector(const OptionValues& values, std::string_view name) {
    return values.given(name) ? std::optional(parse_vec3(values.text(name), name)) : std::nullopt;
}

void read_length(const OptionValues& values, RenderOptions& options) {
    if (values.given("--time-budget")) options.time_budget_seconds = parse_duration_seconds(values.text("--time-budget"), "--time-budget");
    if (!values.given("--spp-range")) {
        options.samples = {0, read_uint(values, "--spp")};
        return;
    }
    const IndexRange range = parse_range(values.text("--spp-range"), "--spp-range");
    if (range.begin % kSampleBlock != 0 || range.end % kSampleBlock != 0)
        throw Error(ErrorCode::Usage, fmt::format("{}-{} does not begin and end at multiples of {}", range.begin, range.end, kSampleBlock),
                    "--spp-range",
                    fmt::format("use for example {}-{}", range.begin / kSampleBlock * kSampleBlock,
                                (range.end + kSampleBlock - 1) / kSampleBlock * kSampleBlock));
    constexpr uint64_t kMaxSamples = 1 << 30;
    if (range.end > kMaxSamples)
        throw Error(ErrorCode::Usage, fmt::format("{} is out of range", range.end), "--spp-range", fmt::format("up to {}", kMaxSamples));
    options.samples = range;
    options.is_part = true;
}

[[noreturn]] void refuse(const std::string& where, std::string what, std::string hint) { throw Error(ErrorCode::Usage, std::move(what), where, std::move(hint)); }

// A path tracer's frames have different samples, so that noise does not stand still: whole blocks of them.
uint64_t whole_blocks(uint64_t samples) { return (samples + kSampleBlock - 1) / kSampleBlock * kSampleBlock; }

void check_frame_count(const OptionValues& values, const RenderOptions& options, uint64_t samples_of_frame) {
    constexpr uint64_t kMaxSamples = 1 << 30;
    const uint64_t most = kMaxSamples / samples_of_frame;
    if (options.play->frames.end > most) refuse(values.where("--frames"), fmt::format("{} is out of range", options.play->frames.end), fmt::format("up to {}", most));
}

void read_play(const OptionValues& values, RenderOptions& options) {
    const bool realtime = options.renderer == RendererKind::Realtime;
    if (!realtime && !values.given("--frames")) {
        if (values.given("--fps")) refuse(values.where("--fps"), "it is for frames", "add --frames N and --out NAME.####.exr");
        return;
    }
    FramePlay play;
    constexpr uint64_t kWarmup = 64;
    play.average = values.flag("--average");
    if (play.average) play.warmup = values.given("--warmup") ? read_uint(values, "--warmup") : kWarmup;
    else if (values.given("--warmup")) refuse(values.where("--warmup"), "it needs --average", "a sequence is written from --frames A-B on");
    play.frames.end += play.warmup;
    if (values.given("--fps")) play.fps = parse_float(values.text("--fps"), "--fps");
    if (values.given("--frames")) {
        const std::string text = values.text("--frames");
        play.frames = text.find('-', 1) != std::string::npos ? parse_range(text, "--frames") : IndexRange{0, read_uint(values, "--frames")};
    }
    if (play.frames.end <= play.warmup && play.average)
        refuse(values.where("--frames"), fmt::format("{} frames are no more than the warm-up of {}", play.frames.end, play.warmup), "ask for more, or set --warmup N");
    if (values.given("--preroll")) play.preroll = read_uint(values, "--preroll");
    if (options.is_part) refuse(values.where("--frames"), "it cannot be used together with --spp-range", "--frames A-B draws a part of a sequence");
    options.play = play;
    check_frame_count(values, options, realtime ? 1 : whole_blocks(options.samples.end));
}

void read_view(const OptionValues& values, RenderOptions& options) {
    if (values.given("--camera")) options.camera = values.text("--camera");
    options.look_from = read_optional_vector(values, "--look-from");
    options.look_at = read_optional_vector(values, "--look-at");
    options.fov_degrees = read_optional_number(values, "--fov");
    if (options.look_at && !options.look_from)
        throw Error(ErrorCode::Usage, "it needs --look-from", values.where("--look-at"), "say where the camera is: --look-from x,y,z");
    options.ortho_height = read_optional_number(values, "--ortho-height");
    if (options.ortho_height && !options.look_from)
        throw Error(ErrorCode::Usage, "it needs --look-from", values.where("--ortho-height"), "say where the camera is: --look-from x,y,z");
    if (options.look_from && options.look_from == options.look_at)
        throw Error(ErrorCode::Usage, "it is the same point as --look-from", values.where("--look-at"), "choose two different points");
    if (values.given("--camera-path")) options.camera_path = values.text("--camera-path");
    options.aperture_radius = parse_float(values.text("--aperture-radius"), "--aperture-radius");
    options.focus_distance = read_optional_number(values, "--focus-distance");
    if (options.focus_distance && options.aperture_radius == 0)
        throw Error(ErrorCode::Usage, "a pinhole shows every distance sharp", values.where("--focus-distance"), "add --aperture-radius METRES");
    if (values.given("--env")) options.environment = values.text("--env");
    options.env_intensity = parse_float(values.text("--env-intensity"), "--env-intensity");
    options.env_rotation_degrees = parse_float(values.text("--env-rotation"), "--env-rotation");
    options.default_light = !values.flag("--no-default-light");
}

bool has_extension(const std::filesystem::path& file, std::string_view extension) {
    std::string own = file.extension().string();
    std::transform(own.begin(), own.end(), own.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return own == extension;
}

// One kind of output: a sequence, or one picture.
void check_sequence(const OptionValues& values, const RenderOptions& options) {
    const auto& files = options.output.files;
    const auto sequences = std::count_if(files.begin(), files.end(), is_sequence);
    if (!options.play) {
        if (sequences != 0) refuse("--out", "'#' stands for the numbers of frames", "add --frames N");
        return;
    }
    if (!options.checkpoint.empty()) refuse(values.where("--checkpoint"), "a sequence has none", "--resume alone keeps the frames that are there");
    const bool one_picture = sequences != static_cast<std::ptrdiff_t>(files.size());
    if (sequences != 0 && one_picture) refuse("--out", "a sequence and a picture cannot be written together", "give every name a '####', or none");
    for (const auto& file : files)
        if (const std::string name = file.filename().string(); is_sequence(file) && name.find_first_not_of('#', name.find('#')) < name.rfind('#'))
            refuse("--out", fmt::format("'{}' has several runs of '#'", escape_name(file.string())), "use one, as in NAME.####.exr");
    if (one_picture && options.renderer != RendererKind::Realtime) refuse("--out", "a path tracer's frames are pictures of their own", "name them --out NAME.####.exr");
    if (one_picture && options.play->frames.begin != 0) refuse(values.where("--frames"), "one picture has no first frame", "use --frames N, or --out NAME.####.exr");
    if (sequences != 0 && options.play->average) refuse(values.where("--average"), "the mean is one picture", "use --out NAME.exr");
}

void check_resume(const OptionValues& values, const RenderOptions& options) {
    const std::string resume = values.where("--resume"), preroll = values.where("--preroll");
    if (options.resume && !options.play && options.checkpoint.empty()) refuse(resume, "there is nothing to resume from", "add --checkpoint F, or --frames N for a sequence");
    if (!options.play) return;
    const auto& files = options.output.files;
    const bool sequence = !files.empty() && is_sequence(files.front());
    if (options.play->preroll && options.play->average) refuse(preroll, "a mean has frames that it does not count", "use --warmup N");
    if (options.play->preroll && !options.dataset.empty()) refuse(preroll, "a dataset's frames have all of their history", "leave it out");
    if (options.play->preroll && !files.empty() && !sequence) refuse(preroll, "it is for a sequence", "use --frames A-B and --out NAME.####.exr");
    if (options.resume && !options.dataset.empty()) refuse(resume, "a dataset goes on by itself", "leave it out");
    if (options.resume && !sequence) refuse(resume, "it keeps the frames of a sequence", "name them --out NAME.####.exr");
}

void check_debug_layers(const RenderOptions& options, std::string_view where) {
    if (options.renderer == RendererKind::Realtime) return;
    for (const std::string& aov : options.aovs)
        if (aov.starts_with("debug.")) throw Error(ErrorCode::Usage, fmt::format("{} shows what the realtime renderer does", aov), std::string(where), "add --renderer realtime");
}

// What reconstruction gets is not of the film either, and there is one a frame.
void read_reconstruction_layers(RenderOptions& options, const std::string& where) {
    options.reconstruction_layers = std::erase(options.aovs, "reconstruction") != 0;
    if (!options.reconstruction_layers) return;
    if (options.renderer != RendererKind::Realtime) refuse(where, "reconstruction is what a realtime frame brings", "add --renderer realtime");
    if (options.play->average) refuse(where, "the mean of frames is no frame that could be reconstructed", "leave out --average, or the layer");
}

void read_dataset(const OptionValues& values, RenderOptions& options) {
    if (values.given("--dataset")) options.dataset = values.text("--dataset");
    if (values.given("--reference-spp")) options.reference_samples = read_uint(values, "--reference-spp");
    if (options.dataset.empty()) {
        if (values.given("--reference-spp")) refuse(values.where("--reference-spp"), "it is for the references of a dataset", "add --dataset DIR");
        return;
    }
    const std::string where = values.where("--dataset");
    if (options.play->average) refuse(where, "the mean of frames is no frame that could be reconstructed", "leave out --average");
    if (options.denoise == DenoiseKind::Oidn) refuse(where, "its frames stay noisy", "leave out --denoise oidn");
    for (const auto& file : options.output.files)
        if (!is_sequence(file)) refuse("--out", "a dataset has many frames", "name them --out NAME.####.exr, or leave it out");
    check_frame_count(values, options, whole_blocks(options.reference_samples));
}

// The layer "noisy" is not of the film: it is what the film's picture was.
void read_noisy(RenderOptions& options, const std::string& where) {
    options.keep_noisy = std::erase(options.aovs, "noisy") != 0;
    if (options.keep_noisy && options.denoise != DenoiseKind::Oidn) refuse(where, "noisy is what --denoise oidn was given", "add --denoise oidn, or leave the layer out");
}

void check_outputs(const OptionValues& values, const RenderOptions& options) {
    const bool exr =
        std::any_of(options.output.files.begin(), options.output.files.end(), [](const auto& file) { return has_extension(file, ".exr"); });
    if (options.output.files.empty() && options.dataset.empty() && !options.list_frame && options.json.empty() && !options.print_settings)
        throw Error(ErrorCode::Usage, "there is no output", "render", "add --out F.exr or --out F.png");
    if (options.is_part && (options.output.files.size() != 1 || !exr))
        throw Error(ErrorCode::Usage, "a part is written to exactly one EXR", "--out",
                    "use --out PART.exr; parhelion merge writes the picture");
    if (options.is_part && options.denoise == DenoiseKind::Oidn) refuse(values.where("--denoise"), "a part holds sums of samples, which have to stay as they are", "leave it out of parts");
    check_debug_layers(options, values.where("--aov"));
    if (options.upscale > 1) check_upscaled_layers(options.aovs);
    if (options.upscale > 1 && options.reconstruction_layers) refuse(values.where("--aov"), "what reconstruction gets has fewer pixels than the picture", "leave --upscale out, or write --dataset");
    if ((!options.aovs.empty() || options.keep_noisy || options.reconstruction_layers) && !exr) throw Error(ErrorCode::Usage, "layers need an EXR", values.where("--aov"), "add --out F.exr");
    check_sequence(values, options);
    check_resume(values, options);
}

}  // namespace

bool is_sequence(const std::filesystem::path& file) { return file.filename().string().find('#') != std::string::npos; }

std::filesystem::path frame_file(const std::filesystem::path& pattern, uint64_t frame) {
    const std::string name = pattern.filename().string();
    const size_t first = name.find('#'), end = std::min(name.find_first_not_of('#', first), name.size());
    return pattern.parent_path() / (name.substr(0, first) + fmt::format("{:0{}}", frame, end - first) + name.substr(end));
}

bool is_png(const std::filesystem::path& file) { return has_extension(file, ".png"); }

OutputOptions read_output_options(const OptionValues& values) {
    OutputOptions output;
    for (const std::string& text : values.texts("--out")) {
        const std::filesystem::path file = text;
        if (!has_extension(file, ".exr") && !has_extension(file, ".png"))
            throw Error(ErrorCode::Usage, fmt::format("'{}' is neither .exr nor .png", escape_name(text)), "--out",
                        "the extension chooses the format");
        if (std::find(output.files.begin(), output.files.end(), file) != output.files.end())
            throw Error(ErrorCode::Usage, fmt::format("'{}' is given twice", escape_name(text)), "--out", "leave one out");
        output.files.push_back(file);
    }
    output.exr_float = values.text("--exr-type") == "float";
    const std::string tonemap = values.text("--tonemap");
    output.tonemap = tonemap == "linear" ? image::ToneCurve::Linear : tonemap == "aces" ? image::ToneCurve::Aces : image::ToneCurve::Agx;
    return output;
}

LoadOptions read_load_options(const OptionValues& values) {
    LoadOptions load;
    load.time = parse_float(values.text("--time"), "--time");
    if (values.given("--animation")) load.animation = values.text("--animation");
    if (values.given("--animate")) load.animate = values.text("--animate");
    if (values.given("--variant")) load.variant = values.text("--variant");
    if (values.given("--triangles")) load.builtin.triangles = static_cast<uint64_t>(parse_int(values.text("--triangles"), "--triangles"));
    load.limits.allow_external = values.flag("--allow-external");
    return load;
}

namespace {

// What a picture and a window have in common.
RenderOptions read_picture(const OptionValues& values) {
    RenderOptions options;
    if (!values.positionals.empty()) options.scene = values.positionals.front();
    options.load = read_load_options(values);
    options.renderer = read_choice<RendererKind>(values, "--renderer");
    options.denoise = read_choice<DenoiseKind>(values, "--denoise");
    if (options.denoise == DenoiseKind::Builtin && options.renderer != RendererKind::Realtime)
        refuse(values.where("--denoise"), "builtin puts a realtime frame together with those before it", "add --renderer realtime, or leave it out");
    options.upscale = parse_float(values.text("--upscale"), "--upscale", 1, kMostUpscale);
    if (options.upscale > 1 && options.denoise != DenoiseKind::Builtin)
        refuse(values.where("--upscale"), "builtin puts the picture's pixels together", "add --denoise builtin, or leave it out");
    options.size = parse_size(values.text("--size"), "--size");
    options.seed = read_uint(values, "--seed");
    options.max_bounces = read_uint(values, "--max-bounces");
    options.point_filter = values.text("--pixel-filter") == "point";
    if (values.text("--exposure") != "scene") options.exposure_ev = parse_float(values.text("--exposure"), "--exposure");
    read_view(values, options);

    options.output = read_output_options(values);
    options.trace = read_choice<TraceChoice>(values, "--trace");
    if (values.given("--device")) options.device = values.text("--device");
    options.validate = values.flag("--validate");
    options.assignments = values.texts("--set");
    return options;
}

}  // namespace

RenderOptions read_view_options(const OptionValues& values) {
    RenderOptions options = read_picture(values);
    if (values.positionals.size() > 1) {
        if (values.given("--env")) refuse(values.where("--env"), "the environment is given already, after the scene", "leave out one of them");
        options.environment = values.positionals[1];
    }
    options.samples = {0, values.given("--spp") ? read_uint(values, "--spp") : 1u << 30};
    if (values.given("--aov"))
        options.aovs = expand_list(*find_option(values.command(), "--aov"), values.text("--aov"), values.where("--aov"));
    check_debug_layers(options, values.where("--aov"));
    if (options.aovs.size() > 1) throw Error(ErrorCode::Usage, "a window shows one layer", values.where("--aov"), "choose one; the panel has them all");
    return options;
}

RenderOptions read_render_options(const OptionValues& values) {
    RenderOptions options = read_picture(values);
    read_length(values, options);
    read_play(values, options);
    options.shutter_seconds = parse_float(values.text("--shutter"), "--shutter");
    if (values.given("--aov"))
        options.aovs = expand_list(*find_option(values.command(), "--aov"), values.text("--aov"), values.where("--aov"));
    read_noisy(options, values.where("--aov"));
    read_reconstruction_layers(options, values.where("--aov"));
    read_dataset(values, options);
    if (values.given("--checkpoint")) options.checkpoint = values.text("--checkpoint");
    options.checkpoint_seconds = parse_duration_seconds(values.text("--checkpoint-every"), "--checkpoint-every");
    options.resume = values.flag("--resume");
    if (values.given("--json")) options.json = values.text("--json");
    options.list_frame = values.flag("--list-frame");
    options.print_settings = values.flag("--print-settings");
    check_outputs(values, options);
    return options;
}

}  // namespace parhelion
