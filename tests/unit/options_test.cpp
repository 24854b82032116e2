// The option table, parsing, presets, and everything that is printed from the table.
#include <fstream>
#include <set>
#include <sstream>

#include <gtest/gtest.h>

#include "base/error.h"
#include "base/file.h"
#include "session/help.h"
#include "session/options.h"
#include "session/render_options.h"

namespace parhelion::options_test {
namespace {

using Words = std::vector<std::string>;

const char* no_environment(const char*) { return nullptr; }

RenderOptions parse_render(const Words& words, const EnvironmentLookup& environment = no_environment) {
    const OptionValues values = parse_options(Command::Render, words, environment);
    check_options(values);
    return read_render_options(values);
}

// The whole line of the usage error that these words give.
std::string usage_error(const Words& words, Command command = Command::Render) {
    try {
        const OptionValues values = parse_options(command, words, no_environment);
        check_options(values);
        if (command == Command::Render) read_render_options(values);
        if (command == Command::Merge) read_output_options(values);
    } catch (const Error& error) {
        EXPECT_EQ(error.code, ErrorCode::Usage) << error.line;
        EXPECT_FALSE(error.where.empty()) << error.line;
        return error.line;
    }
    return "(accepted)";
}

struct TemporaryFile {
    explicit TemporaryFile(std::string_view text) { write_text_file(path, text); }
    ~TemporaryFile() { std::filesystem::remove(path); }
    std::filesystem::path path =
        std::filesystem::temp_directory_path() /
        (std::string("parhelion_options_") + ::testing::UnitTest::GetInstance()->current_test_info()->name() + ".json");
};

}  // namespace

TEST(Options, the_defaults_are_those_of_the_design) {
    const RenderOptions options = parse_render({"builtin:cornell", "--out", "a.exr"});
    EXPECT_EQ(options.scene, "builtin:cornell");
    EXPECT_EQ(options.renderer, RendererKind::Reference);
    EXPECT_EQ(options.size, (Size2{1280, 720}));
    EXPECT_EQ(options.samples, (IndexRange{0, 64}));
    EXPECT_EQ(options.seed, 0u);
    EXPECT_EQ(options.max_bounces, 16u);
    EXPECT_FALSE(options.point_filter);
    EXPECT_FALSE(options.exposure_ev);
    EXPECT_EQ(options.output.tonemap, image::ToneCurve::Agx);
    EXPECT_FALSE(options.output.exr_float);
    EXPECT_EQ(options.trace, TraceChoice::Auto);
}

TEST(Options, values_arrive_as_they_were_given) {
    const RenderOptions options = parse_render({"--size=64x32",
                                                "--out",
                                                "a.exr",
                                                "--out=b.PNG",
                                                "--look-from",
                                                "-1,2.5,-3e1",
                                                "--look-at",
                                                "0,0,0",
                                                "--fov",
                                                "40",
                                                "--exposure",
                                                "-3.5",
                                                "--seed",
                                                "4294967295",
                                                "--aov",
                                                "path.*,albedo",
                                                "--set",
                                                "sampler.kind=pcg",
                                                "--set",
                                                "scene.culling=none",
                                                "--time-budget",
                                                "1500ms",
                                                "--spp",
                                                "5",
                                                "--spp",
                                                "6",
                                                "--",
                                                "-scene.glb"});
    EXPECT_EQ(options.scene, "-scene.glb");
    EXPECT_EQ(options.size, (Size2{64, 32}));
    EXPECT_EQ(options.output.files, (std::vector<std::filesystem::path>{"a.exr", "b.PNG"}));
    EXPECT_EQ((*options.look_from)[0], -1.0);
    EXPECT_EQ((*options.look_from)[2], -30.0);
    EXPECT_EQ(*options.fov_degrees, 40.0);
    EXPECT_EQ(*options.exposure_ev, -3.5);
    EXPECT_EQ(options.seed, 4294967295u);
    EXPECT_EQ(options.aovs.front(), "albedo");
    EXPECT_EQ(options.aovs.size(), 7u);
    EXPECT_EQ(options.assignments, (Words{"sampler.kind=pcg", "scene.culling=none"}));
    EXPECT_EQ(*options.time_budget_seconds, 1.5);
    EXPECT_EQ(options.samples.end, 6u) << "the last of two equal options counts";
}

TEST(Options, a_sample_range_makes_a_part) {
    const RenderOptions options = parse_render({"s.glb", "--spp-range", "128-256", "--out", "a.exr"});
    EXPECT_TRUE(options.is_part);
    EXPECT_EQ(options.samples, (IndexRange{128, 256}));
}

TEST(Options, wrong_usage_is_named_with_what_to_do) {
    const std::pair<Words, const char*> cases[] = {
        {{}, "SCENE is missing"},
        {{"a", "b", "--out", "x.exr"}, "'b' is one argument too many"},
        {{"a"}, "there is no output (add --out"},
        {{"a", "--out"}, "--out: its value is missing (--out F.exr|F.png)"},
        {{"a", "--out", "--spp"}, "--out: its value is missing"},
        {{"a", "--out="}, "--out: its value is empty"},
        {{"a", "--out", "x.jpg"}, "'x.jpg' is neither .exr nor .png"},
        {{"a", "--out", "x.exr", "--out", "x.exr"}, "given twice"},
        {{"a", "--sp", "4", "--out", "x.exr"}, "there is no option --sp (did you mean --spp?"},
        {{"a", "--max-flip", "4"}, "it belongs to parhelion compare"},
        {{"a", "-q"}, "there is no option -q"},
        {{"a", "--out", "x.exr", "--focus-distance", "2"}, "--focus-distance: a pinhole shows every distance sharp (add --aperture-radius METRES)"},
        {{"a", "--out", "x.exr", "--aperture-radius", "-1"}, "--aperture-radius: -1 is out of range"},
        {{"a", "--out", "x.exr", "--aperture-radius", "1", "--focus-distance", "0"}, "--focus-distance: 0 is out of range"},
        {{"a", "--out", "x.exr", "--shutter", "soon"}, "--shutter: 'soon' is not a"},
        {{"a", "--out", "x.exr", "--camera-path", "p.json", "--camera", "0"}, "--camera"},
        {{"a", "--spp", "0"}, "--spp: 0 is out of range (from 1 to 1073741824)"},
        {{"a", "--spp", "1.5"}, "--spp: '1.5' is not a whole number"},
        {{"a", "--spp", "12x"}, "--spp: '12x' is not a whole number"},
        {{"a", "--spp", "99999999999999999999"}, "--spp: '99999999999999999999' is not a whole number"},
        {{"a", "--seed", "4294967296"}, "--seed: 4294967296 is out of range"},
        {{"a", "--seed", "-1"}, "--seed: -1 is out of range"},
        {{"a", "--size", "64"}, "--size: '64' is not a size like 1280x720"},
        {{"a", "--size", "0x4"}, "--size: 0x4 is out of range"},
        {{"a", "--fov", "nan"}, "--fov: 'nan' is not a finite number"},
        {{"a", "--fov", "inf"}, "--fov: 'inf' is not a finite number"},
        {{"a", "--fov", "180"}, "--fov: 180 is out of range"},
        {{"a", "--exposure", "bright"}, "'bright' is not a finite number (a number from -32 to 32, or scene)"},
        {{"a", "--exposure", "33"}, "--exposure: 33 is out of range"},
        {{"a", "--tonemap", "agz"}, "'agz' is not a choice (did you mean agx? use one of agx|aces|linear)"},
        {{"a", "--look-from", "1,2"}, "--look-from: '1,2' is not three numbers"},
        {{"a", "--look-at", "1,2,3", "--out", "x.exr"}, "--look-at: it needs --look-from"},
        {{"a", "--look-at", "1,2,3", "--look-from", "1,2,3", "--out", "x.exr"}, "the same point"},
        {{"a", "--camera", "0", "--look-from", "1,2,3"}, "--look-from: it cannot be used together with --camera"},
        {{"a", "--spp", "8", "--spp-range", "0-64"}, "--spp-range: it cannot be used together with --spp"},
        {{"a", "--spp-range", "1-64", "--out", "x.exr"}, "does not begin and end at multiples of 64 (use for example 0-64)"},
        {{"a", "--spp-range", "64-64", "--out", "x.exr"}, "empty"},
        {{"a", "--spp-range", "0-64", "--out", "x.png"}, "a part is written to exactly one EXR"},
        {{"a", "--time-budget", "30"}, "--time-budget: '30' is not a duration like 30s"},
        {{"a", "--frames", "8", "--out", "x.exr"}, "--out: a path tracer's frames are pictures of their own (name them --out NAME.####.exr)"},
        {{"a", "--frames", "8", "--out", "x.#.exr", "--out", "x.png"}, "--out: a sequence and a picture cannot be written together"},
        {{"a", "--frames", "8", "--out", "x.#.y.##.exr"}, "--out: 'x.#.y.##.exr' has several runs of '#' (use one"},
        {{"a", "--frames", "8", "--spp-range", "0-64", "--out", "x.#.exr"}, "--frames: it cannot be used together with --spp-range (--frames A-B draws a part of a sequence)"},
        {{"a", "--frames", "8", "--checkpoint", "c", "--out", "x.#.exr"}, "--checkpoint: a sequence has none"},
        {{"a", "--frames", "8-8", "--out", "x.#.exr"}, "--frames: the range 8-8 is empty"},
        {{"a", "--frames", "0", "--out", "x.#.exr"}, "--frames: 0 is out of range"},
        {{"a", "--frames", "1000000000", "--out", "x.#.exr"}, "--frames: 1000000000 is out of range (up to 16777216)"},
        {{"a", "--out", "x.####.exr"}, "--out: '#' stands for the numbers of frames (add --frames N)"},
        {{"a", "--average"}, "--average: it does not fit --renderer reference (use --spp N"},
        {{"a", "--upscale", "2"}, "--upscale: it does not fit --renderer reference"},
        {{"a", "--upscale", "2", "--renderer", "realtime", "--out", "x.png"}, "--upscale: builtin puts the picture's pixels together (add --denoise builtin, or leave it out)"},
        {{"a", "--upscale", "2", "--renderer", "realtime", "--denoise", "oidn", "--out", "x.png"}, "--upscale: builtin puts the picture's pixels together (add --denoise builtin"},
        {{"a", "--upscale", "3.1", "--renderer", "realtime", "--denoise", "builtin", "--out", "x.png"}, "--upscale: 3.1 is out of range"},
        {{"a", "--upscale", "0.9", "--renderer", "realtime", "--denoise", "builtin", "--out", "x.png"}, "--upscale: 0.9 is out of range"},
        {{"a", "--upscale", "2", "--renderer", "realtime", "--denoise", "builtin", "--aov", "depth,albedo", "--out", "x.exr"},
         "--aov: albedo has a value a traced pixel, and --upscale traces fewer than the picture has (leave --upscale out, or ask for depth, ids, motion and variance alone)"},
        {{"a", "--denoise", "oidn", "--spp-range", "0-64", "--out", "x.exr"}, "--denoise: a part holds sums of samples, which have to stay as they are (leave it out of parts)"},
        {{"a", "--denoise", "oidn", "--aov", "noisy", "--out", "x.png"}, "--aov: layers need an EXR"},
        {{"a", "--aov", "noisy", "--out", "x.exr"}, "--aov: noisy is what --denoise oidn was given (add --denoise oidn"},
        {{"a", "--aov", "reconstruction", "--out", "x.exr"}, "--aov: reconstruction is what a realtime frame brings (add --renderer realtime)"},
        {{"a", "--renderer", "realtime", "--aov", "reconstruction", "--out", "x.png"}, "--aov: layers need an EXR"},
        {{"a", "--renderer", "realtime", "--average", "--frames", "80", "--aov", "reconstruction", "--out", "x.exr"}, "--aov: the mean of frames is no frame that could be reconstructed"},
        {{"a", "--dataset", "d"}, "--dataset: it does not fit --renderer reference (add --renderer realtime"},
        {{"a", "--renderer", "realtime", "--dataset", "d", "--average", "--frames", "80"}, "--dataset: the mean of frames is no frame"},
        {{"a", "--renderer", "realtime", "--dataset", "d", "--denoise", "oidn"}, "--dataset: its frames stay noisy (leave out --denoise oidn)"},
        {{"a", "--renderer", "realtime", "--dataset", "d", "--out", "x.exr"}, "--out: a dataset has many frames (name them --out NAME.####.exr"},
        {{"a", "--renderer", "realtime", "--dataset", "d", "--frames", "1025", "--reference-spp", "1048576"}, "--frames: 1025 is out of range (up to 1024)"},
        {{"a", "--renderer", "realtime", "--reference-spp", "9", "--out", "x.exr"}, "--reference-spp: it is for the references of a dataset (add --dataset DIR)"},
        {{"a", "--denoise", "builtin"}, "--denoise: builtin puts a realtime frame together with those before it"},
        {{"a", "--fps", "1", "--out", "x.exr"}, "--fps: it is for frames (add --frames N and --out NAME.####.exr)"},
        {{"a", "--warmup", "1", "--out", "x.exr"}, "--warmup: it does not fit --renderer reference (use --spp N"},
        {{"a", "--aov", "albedo,nromal", "--out", "x.exr"}, "--aov: 'nromal' is not a choice (did you mean normal?"},
        {{"a", "--aov", "way.*", "--out", "x.exr"}, "--aov: 'way.*' is not a choice"},
        {{"a", "--aov", "albedo,", "--out", "x.exr"}, "--aov: '' is not a choice"},
        {{"a", "--aov", "albedo", "--out", "x.png"}, "--aov: layers need an EXR"},
        {{"a", "--resume", "--out", "x.exr"}, "--resume: there is nothing to resume from (add --checkpoint F, or --frames N for a sequence)"},
        {{"a", "--resume", "--frames", "8", "--json", "x"}, "--resume: it keeps the frames of a sequence (name them --out NAME.####.exr)"},
        {{"a", "--resume", "--renderer", "realtime", "--out", "x.exr"}, "--resume: it keeps the frames of a sequence (name them"},
        {{"a", "--resume", "--renderer", "realtime", "--average", "--frames", "80", "--out", "x.exr"}, "--resume: it keeps the frames of a sequence (name them"},
        {{"a", "--resume", "--renderer", "realtime", "--dataset", "d"}, "--resume: a dataset goes on by itself (leave it out)"},
        {{"a", "--resume", "--checkpoint", "c", "--frames", "8", "--out", "x.#.exr"}, "--checkpoint: a sequence has none (--resume alone keeps"},
        {{"a", "--preroll", "8", "--frames", "8", "--out", "x.#.exr"}, "--preroll: it does not fit --renderer reference (leave it out"},
        {{"a", "--preroll", "8", "--renderer", "realtime", "--out", "x.exr"}, "--preroll: it is for a sequence (use --frames A-B"},
        {{"a", "--preroll", "8", "--renderer", "realtime", "--average", "--frames", "80", "--out", "x.exr"}, "--preroll: a mean has frames that it does not count (use --warmup N)"},
        {{"a", "--preroll", "8", "--renderer", "realtime", "--dataset", "d"}, "--preroll: a dataset's frames have all of their history"},
        {{"a", "--set", "sampler.kind"}, "'sampler.kind' is not of the form group.field=value"},
        {{"a", "--validate=on"}, "--validate: it takes no value"},
        {{"", "--out", "x.exr"}, "an argument is empty"},
    };
    for (const auto& [words, expected] : cases) {
        const std::string line = usage_error(words);
        EXPECT_NE(line.find(expected), std::string::npos) << "expected: " << expected << "\n  actual: " << line;
    }
    EXPECT_NE(usage_error({"a"}, Command::Compare).find("the second file is missing"), std::string::npos);
    EXPECT_NE(usage_error({}, Command::Merge).find("PART... is missing"), std::string::npos);
    EXPECT_NE(usage_error({"a"}, Command::Devices).find("one argument too many"), std::string::npos);
    EXPECT_NE(usage_error({"--completions", "csh"}, Command::Help).find("use one of bash|zsh|fish"), std::string::npos);
}

TEST(Options, control_characters_are_never_printed_back) {
    const std::string line = usage_error({"a", "--spp", "\x1b[2J"});
    EXPECT_EQ(line.find('\x1b'), std::string::npos);
    EXPECT_NE(line.find("\\x1b[2J"), std::string::npos);
}

TEST(Options, later_sources_win_and_replace_what_they_exclude) {
    const TemporaryFile preset(
        R"({"schema": 1, "spp": 256, "size": "640x360", "camera": "Left", "device": "nvidia", "no-default-light": true,
                                   "env-intensity": 0.5, "set": {"sampler.kind": "white", "reference.roulette_start": 4}})");
    const auto environment = [](const char* name) { return std::string_view(name) == "PARHELION_DEVICE" ? "llvmpipe" : nullptr; };
    const Words words{"a",     "--preset", preset.path.string(), "--out", "x.exr", "--size", "8x8", "--look-from",
                      "1,2,3", "--set",    "sampler.kind=pcg"};
    const RenderOptions options = parse_render(words, environment);
    EXPECT_EQ(options.samples.end, 256u);
    EXPECT_EQ(options.size, (Size2{8, 8}));
    EXPECT_EQ(options.device, "llvmpipe");
    EXPECT_EQ(options.env_intensity, 0.5);
    EXPECT_FALSE(options.default_light);
    EXPECT_TRUE(options.camera.empty()) << "--look-from takes the place of the preset's camera";
    EXPECT_EQ(options.assignments, (Words{"reference.roulette_start=4", "sampler.kind=white", "sampler.kind=pcg"}));

    Words with_device = words;
    with_device.insert(with_device.end(), {"--device", "0"});
    EXPECT_EQ(parse_render(with_device, environment).device, "0");
}

TEST(Options, a_wrong_preset_is_refused_with_its_key) {
    const std::pair<const char*, const char*> cases[] = {
        {"{", "p.json: is not valid JSON"},
        {"[1]", "p.json: is not a JSON object"},
        {R"({"spp": 4})", "p.json: lacks \"schema\": 1"},
        {R"({"schema": 2})", "p.json: lacks \"schema\": 1"},
        {R"({"schema": 1, "spp2": 4})", "p.json: spp2: there is no such option"},
        {R"({"schema": 1, "out": "a.exr"})", "p.json: out: belongs on the command line"},
        {R"({"schema": 1, "spp": [4]})", "p.json: spp: is neither text, a number"},
        {R"({"schema": 1, "set": 4})", "p.json: set: is not an object"},
        {R"({"schema": 1, "no-default-light": "yes"})", "p.json: no-default-light: is neither true nor false"},
    };
    for (const auto& [text, expected] : cases) try {
            parse_preset(text, "p.json");
            ADD_FAILURE() << text << " was accepted";
        } catch (const Error& error) {
            EXPECT_NE(error.line.find(expected), std::string::npos) << error.line;
            EXPECT_EQ(error.code, ErrorCode::Usage);
        }
    const TemporaryFile preset(R"({"schema": 1, "spp": 0})");
    EXPECT_NE(usage_error({"a", "--preset", preset.path.string()}).find("json: spp: 0 is out of range"), std::string::npos);
}

TEST(Options, json_of_reports_takes_no_following_word) {
    const OptionValues values = parse_options(Command::Compare, Words{"--json", "a.exr", "b.exr"}, no_environment);
    EXPECT_EQ(values.positionals, (Words{"a.exr", "b.exr"}));
    EXPECT_EQ(values.text("--json"), "-");
    EXPECT_EQ(parse_options(Command::Compare, Words{"a", "b", "--json", "-"}, no_environment).positionals.size(), 2u);
    EXPECT_EQ(parse_options(Command::Compare, Words{"a", "b", "--json=c"}, no_environment).text("--json"), "c");
}

TEST(Options, the_json_target_is_found_in_words_that_do_not_parse) {
    EXPECT_EQ(find_json_target(Command::Render, Words{"a", "--spp", "x", "--json", "-"}), "-");
    EXPECT_EQ(find_json_target(Command::Render, Words{"a", "--json=f.json", "--wrong"}), "f.json");
    EXPECT_EQ(find_json_target(Command::Render, Words{"a", "--json"}), "");
    EXPECT_EQ(find_json_target(Command::Compare, Words{"--json", "a"}), "-");
    EXPECT_EQ(find_json_target(Command::Help, Words{"--json", "a"}), "");
}

TEST(Options, the_table_is_consistent) {
    std::set<std::pair<std::string_view, uint32_t>> seen;
    for (const OptionSpec& option : option_table()) {
        SCOPED_TRACE(option.name);
        EXPECT_TRUE(option.name.starts_with("--"));
        EXPECT_NE(option.commands, 0u);
        EXPECT_FALSE(option.help.empty());
        EXPECT_FALSE(option.section.empty());
        EXPECT_EQ(option.value.empty(), option.kind == ValueKind::Flag);
        if (option.renderers != kEveryRenderer) {
            EXPECT_FALSE(option.instead.empty()) << "what should be used with another renderer?";
        }
        if (option.kind == ValueKind::Integer || option.kind == ValueKind::Number) {
            EXPECT_LT(option.min, option.max);
        }
        if (!option.fallback.empty()) {
            EXPECT_NO_THROW(check_value(option, option.fallback, option.name));
        }
        for (const CommandSpec& command : command_table())
            if ((option.commands & command_bit(command.id)) != 0) {
                EXPECT_TRUE(seen.emplace(option.name, command_bit(command.id)).second) << "twice in " << command.name;
            }
    }
}

TEST(Help, every_command_and_option_is_in_every_form_of_documentation) {
    const std::string man = man_page(), markdown = markdown_help(), overview = overview_help();
    for (const CommandSpec& command : command_table()) {
        const std::string help = command_help(command.id);
        EXPECT_NE(overview.find(command.name), std::string::npos);
        EXPECT_FALSE(command.examples.empty());
        for (const OptionSpec* option : options_of(command.id)) {
            SCOPED_TRACE(fmt::format("{} {}", command.name, option->name));
            EXPECT_NE(help.find(detail::option_form(*option)), std::string::npos);
            EXPECT_NE(help.find(option->help.substr(0, 20)), std::string::npos);
            EXPECT_NE(markdown.find("`" + std::string(option->name)), std::string::npos);
            std::string escaped;
            for (const char c : option->name) escaped += c == '-' ? "\\-" : std::string(1, c);
            EXPECT_NE(man.find(escaped), std::string::npos);
            for (const std::string_view shell : {"bash", "zsh", "fish"}) {
                const std::string name(option->name.substr(shell == "fish" ? 2 : 0));
                const bool offered = completions(shell).find(shell == "fish" ? " -l " + name + " " : name) != std::string::npos;
                if ((option->bits & kAbsent) == 0) {
                    EXPECT_TRUE(offered) << shell;
                }
            }
        }
    }
}

// Examples are commands that people copy: each has to parse.
TEST(Help, every_example_parses) {
    for (const CommandSpec& command : command_table())
        for (const std::string_view example : command.examples) {
            SCOPED_TRACE(example);
            std::istringstream stream{std::string(example)};
            Words words;
            for (std::string word; stream >> word && word != ">";) words.push_back(word);
            ASSERT_GE(words.size(), 2u);
            EXPECT_EQ(words[0], "parhelion");
            EXPECT_EQ(words[1], command.name);
            words.erase(words.begin(), words.begin() + 2);
            EXPECT_NO_THROW({
                const OptionValues values = parse_options(command.id, words, no_environment);
                check_options(values);
                if (command.id == Command::Render) read_render_options(values);
            });
        }
}

TEST(Help, lines_fit_a_terminal_of_100_columns) {
    for (const CommandSpec& command : command_table()) {
        std::istringstream stream(command_help(command.id));
        for (std::string line; std::getline(stream, line);)
            if (!line.starts_with("  parhelion")) {
                EXPECT_LE(line.size(), 100u) << line;
            }
    }
}

TEST(Help, the_document_in_the_repository_is_up_to_date) {
    std::ifstream file(std::string(PARHELION_SOURCE_DIR) + "/docs/command-line.md");
    std::stringstream text;
    text << file.rdbuf();
    EXPECT_EQ(text.str(), markdown_help()) << "run: parhelion help --markdown > docs/command-line.md";
}

TEST(Help, roff_escapes_what_would_be_a_request) {
    const std::string man = man_page();
    std::istringstream stream(man);
    const std::set<std::string> requests{".TH", ".SH", ".SS", ".TP", ".PP", ".B", ".I", ".nf", ".fi"};
    for (std::string line; std::getline(stream, line);)
        if (line.starts_with(".")) {
            EXPECT_TRUE(requests.count(line.substr(0, line.find(' ')))) << line;
        }
}

}  // namespace parhelion::options_test
