// The built program as a process: every documented error with its message and exit code, what is left behind after each way to
// end, and the promises about files (whole or not at all, identical, nothing about the machine in them).
#include <chrono>
#include <csignal>
#include <optional>
#include <regex>

#include <unistd.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "base/file.h"
#include "session/trace_choice.h"
#include "support/gpu_fixture.h"
#include "support/process.h"

namespace parhelion::testing::cli_test {
namespace {

using Words = std::vector<std::string>;
using Json = nlohmann::json;
const Words kSmall{"render", "builtin:cornell", "--size", "24x16", "--spp", "2", "--exposure", "3"};
// Hours of work on a CPU, a minute on a GPU: it never ends by itself in a test.
const Words kEndless{"render", "builtin:cornell", "--size", "96x96", "--spp", "9999999", "--exposure", "3"};

Words operator+(Words words, const Words& more) {
    words.insert(words.end(), more.begin(), more.end());
    return words;
}

// One line on stderr that begins with "error:"; nothing on stdout.
void expect_error(const ProcessResult& result, int code, const std::string& message) {
    EXPECT_EQ(result.exit_code, code) << result.err;
    EXPECT_EQ(result.out, "");
    const size_t begin = result.err.rfind("error: ");
    ASSERT_NE(begin, std::string::npos) << result.err;
    EXPECT_NE(result.err.find(message, begin), std::string::npos) << result.err;
    EXPECT_EQ(std::count(result.err.begin() + static_cast<long>(begin), result.err.end(), '\n'), 1) << result.err;
}

// Tests of what needs no device.
class Cli : public ::testing::Test {
protected:
    TemporaryFolder folder;
    std::string file(const std::string& name) const { return folder.file(name); }
};

// Tests that render.
class CliRender : public Cli {
protected:
    void SetUp() override {
        if (shared_device()) return;
        if (is_required("device")) FAIL() << "there is no Vulkan device";
        GTEST_SKIP() << "there is no Vulkan device";
    }
    // Sends the signal two seconds after the program has begun to take samples.
    ProcessResult interrupt(const Words& words, int signal) {
        std::optional<std::chrono::steady_clock::time_point> begun;
        ProcessOptions options{.signal = signal};
        options.signal_when = [&](const ProcessResult& so_far) {
            if (!begun && so_far.err.find("exposure") != std::string::npos) begun = std::chrono::steady_clock::now();
            return begun && std::chrono::steady_clock::now() - *begun > std::chrono::seconds(2);
        };
        return run_parhelion(words, options);
    }
    // A picture of kEndless that stopped early: as bright as one with few samples (whose mean is known to better than 2 %).
    void expect_right_brightness(const std::string& picture) {
        const std::string reference = file("reference.exr");
        ASSERT_EQ(
            run_parhelion({"render", "builtin:cornell", "--size", "96x96", "--spp", "8", "--exposure", "3", "--out", reference}).exit_code,
            0);
        const Json json = run_parhelion({"compare", picture, reference, "--json"}).json();
        EXPECT_NEAR(json.value("mean_ratio", 0.0), 1.0, 0.1);
        EXPECT_EQ(json["nan_count"], 0);
    }
};

}  // namespace

TEST_F(Cli, version_and_help_go_to_stdout) {
    const ProcessResult version = run_parhelion({"--version"});
    EXPECT_EQ(version.exit_code, 0);
    EXPECT_TRUE(std::regex_match(version.out, std::regex("parhelion [0-9]+\\.[0-9]+\\.[0-9]+\n"))) << version.out;
    EXPECT_EQ(version.err, "");
    for (const Words& words : {Words{"help"}, Words{"--help"}, Words{"-h"}, Words{"help", "render"}, Words{"render", "--help"},
                               Words{"help", "--man"}, Words{"help", "--completions", "bash"}, Words{"settings"}}) {
        const ProcessResult help = run_parhelion(words);
        EXPECT_EQ(help.exit_code, 0);
        EXPECT_GT(help.out.size(), 100u);
        EXPECT_EQ(help.err, "");
    }
}

TEST_F(Cli, wrong_usage_exits_with_2_and_leaves_nothing) {
    expect_error(run_parhelion({}), 2, "a command is missing (parhelion help lists them)");
    expect_error(run_parhelion({"rendr"}), 2, "there is no command 'rendr' (did you mean render?)");
    expect_error(run_parhelion({"render"}), 2, "render: SCENE is missing");
    expect_error(run_parhelion(kSmall), 2, "render: there is no output (add --out F.exr or --out F.png)");
    expect_error(run_parhelion(kSmall + Words{"--out", file("a.bmp")}), 2, "is neither .exr nor .png");
    expect_error(run_parhelion(kSmall + Words{"--out", file("a.exr"), "--size", "0x4"}), 2, "--size: 0x4 is out of range");
    expect_error(run_parhelion(kSmall + Words{"--out", file("a.exr"), "--renderer", "realtime"}), 2, "--spp: it does not fit --renderer realtime (use --frames N");
    expect_error(run_parhelion({"render", "builtin:cornell", "--out", file("a.exr"), "--frames", "3"}), 2,
                 "--out: a path tracer's frames are pictures of their own (name them --out NAME.####.exr)");
    expect_error(run_parhelion(kSmall + Words{"--out", file("a.exr"), "--set", "sampler.kin=pcg"}), 2,
                 "there is no setting 'sampler.kin' (did you mean sampler.kind?");
    expect_error(run_parhelion(kSmall + Words{"--out", file("a.exr"), "--set", "sampler.kind=pgc"}), 2,
                 "sampler.kind: 'pgc' is not one of owen|cranley|pcg|white");
    expect_error(run_parhelion(kSmall + Words{"--out", file("a.exr"), "--trace", "compute", "--set", "reference.shade_in=closest_hit"}), 2,
                 "reference.shade_in: only the ray tracing pipeline can shade in closest-hit shaders (add --trace pipeline");
    expect_error(run_parhelion(kSmall + Words{"--out", file("a.exr"), "--trace", "pipeline", "--set", "reference.shade_in=closest_hit", "--set", "texture.lod=cone"}), 2,
                 "reference.shade_in: closest-hit shaders read textures at full resolution only (use texture.lod=full");
    expect_error(run_parhelion({"render", "builtin:nothing", "--out", file("a.exr")}), 2, "builtin:nothing");
    expect_error(run_parhelion({"bench", "enormous"}), 2, "there is no suite 'enormous' (use quick or replay or full or reference or wavefront or trace)");
    expect_error(run_parhelion(kSmall + Words{"--out", file("a.exr")}, {.environment = {{"PARHELION_LOG", "loud"}}}), 2,
                 "'loud' is not a log level");
    EXPECT_TRUE(folder.names().empty());
}

TEST_F(Cli, wrong_files_exit_with_1_before_any_work) {
    write_text_file(file("broken.glb"), "glTF but no more");
    write_text_file(file("text.exr"), "not an image");
    write_text_file(file("preset.json"), "{\"schema\": 1, \"spp\": 0}");
    const std::vector<std::string> before = folder.names();
    expect_error(run_parhelion({"render", file("none.glb"), "--out", file("a.exr")}), 1, "none.glb: there is no such file");
    expect_error(run_parhelion({"render", folder.path().string(), "--out", file("a.exr")}), 1, "is a folder");
    expect_error(run_parhelion({"render", file("broken.glb"), "--out", file("a.exr")}), 1, "broken.glb");
    expect_error(run_parhelion({"info", file("none.glb")}), 1, "none.glb: there is no such file");
    expect_error(run_parhelion(kSmall + Words{"--out", file("none/a.exr")}), 1, "does not exist (create it first)");
    expect_error(run_parhelion(kSmall + Words{"--out", file("a.exr"), "--out", file("none/a.png")}), 1, "does not exist (create it first)");
    expect_error(run_parhelion(kSmall + Words{"--out", file("a.exr"), "--json", file("none/a.json")}), 1,
                 "does not exist (create it first)");
    expect_error(run_parhelion(kSmall + Words{"--out", "/dev/full.exr/a.exr"}), 1, "does not exist");
    expect_error(run_parhelion(kSmall + Words{"--out", file("a.exr"), "--env", file("none.hdr")}), 1, "none.hdr: there is no such file");
    expect_error(run_parhelion(kSmall + Words{"--out", file("a.exr"), "--env", file("text.exr")}), 1, "text.exr");
    expect_error(run_parhelion({"render", "x", "--preset", file("none.json")}), 1, "none.json: there is no such file");
    expect_error(run_parhelion({"render", "x", "--preset", file("preset.json")}), 2, "spp: 0 is out of range");
    expect_error(run_parhelion({"merge", file("none.exr"), "--out", file("a.exr")}), 1, "none.exr: there is no such file");
    expect_error(run_parhelion({"merge", file("text.exr"), "--out", file("a.exr")}), 1, "text.exr");
    expect_error(run_parhelion({"compare", file("none.exr"), file("text.exr")}), 1, "none.exr: there is no such file");
    EXPECT_EQ(folder.names(), before);
}

// A folder in which nothing can be made, for root too.
TEST_F(Cli, an_output_in_a_read_only_folder_is_refused_at_once) {
    const auto begin = std::chrono::steady_clock::now();
    expect_error(run_parhelion(kEndless + Words{"--out", "/proc/a.exr"}), 1, "/proc/a.exr: cannot be written");
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(5));
}

TEST_F(Cli, names_with_control_characters_are_escaped) {
    const ProcessResult result = run_parhelion({"render", "evil\x1b[31m\n.glb", "--out", file("a.exr")});
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_EQ(result.err.find('\x1b'), std::string::npos);
    EXPECT_NE(result.err.find("evil\\x1b[31m\\x0a.glb"), std::string::npos) << result.err;
}

TEST_F(Cli, a_failure_is_json_where_json_was_asked_for) {
    const ProcessResult result = run_parhelion({"render", file("none.glb"), "--out", file("a.exr"), "--json", "-"});
    EXPECT_EQ(result.exit_code, 1);
    const Json json = result.json();
    ASSERT_TRUE(json.is_object()) << result.out;
    EXPECT_EQ(json["schema"], 1);
    EXPECT_EQ(json["error"]["code"], "failed");
    EXPECT_EQ(json["error"]["what"], "there is no such file");
    EXPECT_NE(json["error"]["where"].get<std::string>().find("none.glb"), std::string::npos);
    EXPECT_TRUE(json["error"].contains("hint"));

    EXPECT_EQ(run_parhelion({"render", "x", "--spp", "no", "--json", file("e.json")}).exit_code, 2);
    EXPECT_EQ(Json::parse(read_bytes(file("e.json")))["error"]["code"], "usage");
    EXPECT_EQ(run_parhelion({"compare", "--json", "x", "y"}).json()["error"]["code"], "failed");
}

TEST_F(Cli, results_that_cannot_be_written_are_a_failure) {
    EXPECT_EQ(run_parhelion({"--version"}, {.stdout_file = "/dev/full"}).exit_code, 1);
    EXPECT_EQ(run_parhelion({"help", "--man"}, {.stdout_file = "/dev/full"}).exit_code, 1);
    EXPECT_NE(run_parhelion({"settings"}, {.stdout_file = "/dev/full"}).err.find("stdout: writing failed"), std::string::npos);
}

TEST_F(Cli, a_machine_without_a_device_exits_with_3) {
    const ProcessOptions no_driver{.environment = {{"VK_DRIVER_FILES", "/nonexistent.json"}, {"VK_ICD_FILENAMES", "/nonexistent.json"}}};
    expect_error(run_parhelion(kSmall + Words{"--out", file("a.exr")}, no_driver), 3, "Vulkan");
    expect_error(run_parhelion({"devices", "--require"}, no_driver), 3, "Vulkan");
    const ProcessResult list = run_parhelion({"devices", "--json"}, no_driver);
    EXPECT_EQ(list.exit_code, 0);
    EXPECT_TRUE(list.json()["devices"].empty());
    EXPECT_TRUE(folder.names().empty());
}

TEST_F(Cli, printed_settings_are_a_preset_that_prints_the_same) {
    const ProcessResult first = run_parhelion({"render", "--print-settings", "--spp", "7", "--camera", "Left", "--env-intensity", "0.1",
                                               "--no-default-light", "--set", "sampler.kind=pcg"});
    ASSERT_EQ(first.exit_code, 0) << first.err;
    EXPECT_EQ(first.json()["spp"], 7);
    EXPECT_EQ(first.json()["set"]["sampler.kind"], "pcg");
    write_text_file(file("p.json"), first.out);
    const ProcessResult second = run_parhelion({"render", "--print-settings", "--preset", file("p.json")});
    EXPECT_EQ(second.out, first.out) << second.err;
    EXPECT_EQ(run_parhelion({"render", "--print-settings", "--preset", file("p.json"), "--spp", "9"}).json()["spp"], 9);
}

TEST_F(Cli, devices_and_info_speak_json) {
    const Json devices = run_parhelion({"devices", "--json"}).json();
    EXPECT_EQ(devices["schema"], 1);
    const Json required = run_parhelion({"devices", "--require", "--json"}).json();
    EXPECT_GE(required["required"].size(), 10u);
    EXPECT_EQ(required["required"][0], "Vulkan 1.3");
    const Json info = run_parhelion({"info", "builtin:cornell", "--json"}).json();
    EXPECT_EQ(info["schema"], 1);
    EXPECT_GT(info["triangles"].get<int>(), 10);
}

TEST_F(CliRender, a_picture_and_its_numbers) {
    const ProcessResult result = run_parhelion(kSmall + Words{"--out", file("a.exr"), "--out", file("a.png"), "--json", "-"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(folder.names(), (Words{"a.exr", "a.png"}));
    const Json json = result.json();
    for (const char* key :
         {"schema", "renderer", "device", "driver", "trace", "scene", "triangles", "traced_triangles", "lights", "size", "spp", "seconds", "passes", "memory"})
        EXPECT_TRUE(json.contains(key)) << key;
    EXPECT_EQ(json["schema"], 1);
    EXPECT_EQ(json["spp"], 2);
    EXPECT_EQ(json["complete"], true);
    EXPECT_GT(json["passes"].size(), 1u);
}

TEST_F(CliRender, the_same_command_gives_identical_files_that_do_not_name_the_machine) {
    std::filesystem::create_directories(folder.path() / "one");
    std::filesystem::create_directories(folder.path() / "two");
    for (const char* name : {"one", "two"})
        ASSERT_EQ(run_parhelion(kSmall + Words{"--out", "a.exr", "--out", "a.png", "--aov", "albedo"}, {.folder = folder.path() / name})
                      .exit_code,
                  0);
    for (const char* name : {"a.exr", "a.png"}) {
        const std::string bytes = read_bytes(folder.path() / "one" / name);
        EXPECT_GT(bytes.size(), 100u);
        EXPECT_EQ(bytes, read_bytes(folder.path() / "two" / name)) << name;
        EXPECT_EQ(bytes.find(folder.path().filename().string()), std::string::npos);
        char host[256] = {};
        gethostname(host, sizeof(host) - 1);
        EXPECT_EQ(bytes.find(host), std::string::npos);
        EXPECT_EQ(bytes.find("capDate"), std::string::npos);
    }
}

// A CPU driver runs a dispatch on as many threads as LP_NUM_THREADS says (0: on the submitting one); others do not read it. Of every
// way to trace, sums, variances and classes of light are the same bits.
TEST_F(CliRender, the_number_of_threads_changes_no_bit) {
    const Words job{"render", "builtin:cornell", "--size", "40x24", "--spp", "2", "--exposure", "3", "--max-bounces", "3", "--aov", "variance,path.*", "--out", "a.exr"};
    for (const gpu::TraceWay way : {gpu::TraceWay::Query, gpu::TraceWay::Pipeline, gpu::TraceWay::Compute}) {
        if (!shared_device()->caps().supports(way)) continue;
        std::string of_one_thread;
        for (const char* threads : {"0", "1", "2", "7"}) {
            const ProcessOptions options{.environment = {{"LP_NUM_THREADS", threads}}, .folder = folder.path()};
            const ProcessResult result = run_parhelion(job + Words{"--trace", std::string(gpu::trace_way_name(way))}, options);
            ASSERT_EQ(result.exit_code, 0) << result.err;
            const std::string bytes = read_bytes(file("a.exr"));
            if (of_one_thread.empty()) of_one_thread = bytes;
            EXPECT_GT(bytes.size(), 1000u);
            EXPECT_TRUE(bytes == of_one_thread) << gpu::trace_way_name(way) << " on " << threads << " threads";
        }
    }
}

TEST_F(CliRender, an_existing_file_is_kept_when_the_job_fails) {
    write_text_file(file("a.exr"), "precious");
    EXPECT_EQ(run_parhelion({"render", file("none.glb"), "--out", file("a.exr")}).exit_code, 1);
    EXPECT_EQ(read_bytes(file("a.exr")), "precious");
}

// `merge` writes pictures as `render` does but opens no device: software drivers keep their memory in files, which the limit would hit.
TEST_F(CliRender, a_full_disk_is_one_clear_line_and_no_file) {
    const Words part{"render", "builtin:cornell", "--size", "48x48", "--spp-range", "0-64", "--max-bounces", "1", "--exposure", "3"};
    ASSERT_EQ(run_parhelion(part + Words{"--out", file("part.exr")}).exit_code, 0);
    write_text_file(file("old.exr"), "precious");
    for (const char* name : {"a.exr", "a.png", "old.exr"}) {
        const ProcessResult result = run_parhelion({"merge", file("part.exr"), "--out", file(name)}, {.file_size_limit = 1024});
        expect_error(result, 1, std::string(name) + ": writing failed");
    }
    EXPECT_EQ(folder.names(), (Words{"old.exr", "part.exr"}));
    EXPECT_EQ(read_bytes(file("old.exr")), "precious");
}

TEST_F(CliRender, ctrl_c_writes_what_is_finished_and_says_how_much) {
    const ProcessResult result = interrupt(kEndless + Words{"--out", file("a.exr"), "--json", "-"}, SIGINT);
    EXPECT_EQ(result.exit_code, 130) << result.err;
    EXPECT_LT(result.seconds_after_signal, 5.0) << "within a second on a quiet machine, then the files are written";
    EXPECT_TRUE(std::regex_search(result.err, std::regex("interrupted: [0-9]+ of 9999999 samples"))) << result.err;
    EXPECT_EQ(folder.names(), (Words{"a.exr"}));
    const Json json = result.json();
    EXPECT_EQ(json["interrupted"], true);
    EXPECT_EQ(json["complete"], false);
    EXPECT_GT(json["spp"].get<int>(), 0);
    expect_right_brightness(file("a.exr"));
}

TEST_F(CliRender, termination_does_the_same_with_143) {
    const ProcessResult result = interrupt(kEndless + Words{"--out", file("a.png")}, SIGTERM);
    EXPECT_EQ(result.exit_code, 143) << result.err;
    EXPECT_EQ(folder.names(), (Words{"a.png"}));
}

TEST_F(CliRender, a_second_ctrl_c_ends_at_once) {
    ProcessOptions options{.signal = SIGINT, .signal_count = 2};
    options.signal_when = [](const ProcessResult& so_far) { return so_far.err.find("scene") != std::string::npos; };
    const ProcessResult result = run_parhelion(kEndless + Words{"--out", file("a.exr")}, options);
    EXPECT_EQ(result.exit_code, 130);
    EXPECT_LT(result.seconds_after_signal, 3.0);
}

TEST_F(CliRender, a_killed_job_leaves_no_file_under_the_final_name) {
    const ProcessResult result = interrupt(kEndless + Words{"--out", file("a.exr")}, SIGKILL);
    EXPECT_EQ(result.signal, SIGKILL);
    EXPECT_FALSE(std::filesystem::exists(file("a.exr")));
    ASSERT_EQ(run_parhelion(kSmall + Words{"--out", file("a.exr")}).exit_code, 0);
    EXPECT_EQ(folder.names(), (Words{"a.exr"})) << "the next run sweeps what the killed one left";
}

TEST_F(CliRender, a_time_budget_ends_a_job_with_a_picture) {
    const ProcessResult result = run_parhelion(kEndless + Words{"--time-budget", "2s", "--out", file("a.exr"), "--json", "-"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.json()["out_of_time"], true);
    EXPECT_GT(result.json()["spp"].get<int>(), 0);
    EXPECT_EQ(folder.names(), (Words{"a.exr"}));
    expect_right_brightness(file("a.exr"));
}

TEST_F(CliRender, merged_parts_are_the_whole_bit_for_bit) {
    const Words base{"render", "builtin:cornell", "--size", "20x12", "--exposure", "3", "--aov",
                     "albedo,normal,emission,roughness,depth,ids,motion,variance,path.*"};
    ASSERT_EQ(run_parhelion(base + Words{"--spp", "256", "--out", file("whole.exr"), "--out", file("whole.png")}).exit_code, 0);
    for (const char* range : {"0-64", "64-128", "128-192", "192-256"})
        ASSERT_EQ(run_parhelion(base + Words{"--spp-range", range, "--out", file(std::string(range) + ".exr")}).exit_code, 0);
    ASSERT_EQ(run_parhelion(base + Words{"--spp-range", "64-256", "--out", file("64-256.exr")}).exit_code, 0);
    const auto merge = [&](const Words& parts) {
        return run_parhelion(Words{"merge"} + parts + Words{"--out", file("m.exr"), "--out", file("m.png"), "--json", "-"});
    };
    for (const Words& parts :
         {Words{file("128-192.exr"), file("0-64.exr"), file("192-256.exr"), file("64-128.exr")}, Words{file("0-64.exr"), file("64-256.exr")}}) {
        const ProcessResult result = merge(parts);
        ASSERT_EQ(result.exit_code, 0) << result.err;
        EXPECT_EQ(result.json()["spp"], 256);
        EXPECT_EQ(read_bytes(file("m.exr")), read_bytes(file("whole.exr")));
        EXPECT_EQ(read_bytes(file("m.png")), read_bytes(file("whole.png")));
    }
    std::filesystem::remove(file("m.exr"));
    std::filesystem::remove(file("m.png"));

    const auto refused = [&](const Words& parts, const std::string& message) {
        expect_error(run_parhelion(Words{"merge"} + parts + Words{"--out", file("m.exr")}), 1, message);
        EXPECT_FALSE(std::filesystem::exists(file("m.exr")));
    };
    refused({file("0-64.exr"), file("0-64.exr")}, "overlap");
    refused({file("0-64.exr"), file("128-192.exr")}, "the samples 64-128 are missing");
    refused({file("64-128.exr"), file("128-192.exr")}, "the samples 0-64 are missing before it");
    refused({file("whole.exr")}, "whole.exr");
    for (const Words& other : {Words{"--seed", "1"}, Words{"--set", "sampler.kind=pcg"}, Words{"--exposure", "4"}}) {
        ASSERT_EQ(run_parhelion(base + other + Words{"--spp-range", "64-128", "--out", file("other.exr")}).exit_code, 0);
        refused({file("0-64.exr"), file("other.exr")}, other[0] == "--exposure" ? "exposure_ev100 is '4'" : "settings_hash is");
    }
    expect_error(run_parhelion({"merge", file("0-64.exr"), "--out", file("0-64.exr")}), 2, "is a part too");
}

TEST_F(CliRender, a_resumed_job_gives_the_same_file_as_one_run) {
    const Words base{"render", "builtin:cornell", "--size", "16x16", "--exposure", "3", "--aov", "depth,ids,motion,variance"};
    ASSERT_EQ(run_parhelion(base + Words{"--spp", "200", "--out", file("whole.exr")}).exit_code, 0);
    const Words saved = base + Words{"--checkpoint", file("c.state"), "--resume"};
    ASSERT_EQ(run_parhelion(saved + Words{"--spp", "128", "--out", file("first.exr")}).exit_code, 0);
    const ProcessResult second = run_parhelion(saved + Words{"--spp", "200", "--out", file("second.exr"), "--json", "-"});
    ASSERT_EQ(second.exit_code, 0) << second.err;
    EXPECT_EQ(second.json()["resumed_at"], 128);
    EXPECT_EQ(read_bytes(file("second.exr")), read_bytes(file("whole.exr")));

    expect_error(run_parhelion(saved + Words{"--spp", "64", "--out", file("x.exr")}), 1, "it already holds 128 samples");
    expect_error(run_parhelion(saved + Words{"--seed", "3", "--out", file("x.exr")}), 1, "it is the checkpoint of another render");
    write_text_file(file("c.state"), "garbage");
    expect_error(run_parhelion(saved + Words{"--spp", "200", "--out", file("x.exr")}), 1, "c.state");
    EXPECT_FALSE(std::filesystem::exists(file("x.exr")));
}

TEST_F(CliRender, an_interrupted_job_resumes_from_its_last_block) {
    const Words base{"render",        "builtin:cornell",    "--size", "16x16",   "--exposure", "3", "--checkpoint",
                     file("c.state"), "--checkpoint-every", "1ms",    "--resume"};
    const ProcessResult first = interrupt(base + Words{"--spp", "1000000", "--out", file("first.exr"), "--json", "-"}, SIGINT);
    ASSERT_EQ(first.exit_code, 130) << first.err;
    const int blocks = first.json()["spp"].get<int>() / 64;
    ASSERT_GE(blocks, 1) << "too slow to finish one block in two seconds";
    const std::string total = std::to_string(64 * (blocks + 1));
    const ProcessResult second = run_parhelion(base + Words{"--spp", total, "--out", file("second.exr"), "--json", "-"});
    ASSERT_EQ(second.exit_code, 0) << second.err;
    EXPECT_EQ(second.json()["resumed_at"], 64 * blocks);
}

TEST_F(CliRender, a_listing_of_the_frame_needs_no_output) {
    const ProcessResult result = run_parhelion(kSmall + Words{"--list-frame"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_NE(result.out.find("reference/path_trace"), std::string::npos);
}

TEST_F(CliRender, an_unknown_device_is_wrong_usage_that_lists_the_devices) {
    expect_error(run_parhelion(kSmall + Words{"--out", file("a.exr"), "--device", "no such thing"}), 2,
                 "no device is called 'no such thing'");
    expect_error(run_parhelion(kSmall + Words{"--out", file("a.exr")}, {.environment = {{"PARHELION_DEVICE", "no such thing"}}}), 2,
                 "no such thing");
    EXPECT_TRUE(folder.names().empty());
}

TEST_F(CliRender, a_device_without_ray_tracing_traces_by_compute_and_says_so) {
    const ProcessOptions masked{.environment = {{"PARHELION_MASK", "pipeline,query"}}};
    const ProcessResult devices = run_parhelion({"devices", "--json", "-"}, masked);
    ASSERT_EQ(devices.exit_code, 0) << devices.err;
    for (const auto& device : devices.json()["devices"])
        EXPECT_TRUE(!device["usable"].get<bool>() || device["trace"] == Json::array({"compute"})) << device;
    EXPECT_NE(run_parhelion({"devices"}, masked).out.find("traces by compute\n"), std::string::npos);
    const ProcessResult automatic = run_parhelion(kSmall + Words{"--trace", "auto", "--out", file("a.exr"), "--json", "-"} + (shared_device_validates() ? Words{"--validate"} : Words{}), masked);
    ASSERT_EQ(automatic.exit_code, 0) << automatic.err;
    EXPECT_EQ(automatic.json()["trace"], "compute");
    for (const std::string way : {"pipeline", "query"}) expect_error(run_parhelion(kSmall + Words{"--trace", way, "--out", file("b.exr")}, masked), 3, "cannot trace by " + way);
    expect_error(run_parhelion(kSmall + Words{"--out", file("b.exr")}, {.environment = {{"PARHELION_MASK", "queries"}}}), 2, "'queries' cannot be masked");
    EXPECT_EQ(folder.names(), std::vector<std::string>{"a.exr"});
}

TEST_F(CliRender, a_comparison_over_its_limit_exits_with_4) {
    ASSERT_EQ(run_parhelion(kSmall + Words{"--out", file("a.exr")}).exit_code, 0);
    ASSERT_EQ(run_parhelion(kSmall + Words{"--seed", "1", "--out", file("b.exr")}).exit_code, 0);
    EXPECT_EQ(run_parhelion({"compare", file("a.exr"), file("a.exr"), "--max-flip", "0", "--max-relmse", "0"}).exit_code, 0);
    const ProcessResult over = run_parhelion({"compare", file("a.exr"), file("b.exr"), "--max-flip", "0.0001", "--json"});
    EXPECT_EQ(over.exit_code, 4) << over.err;
    EXPECT_NE(over.err.find("FLIP"), std::string::npos) << over.err;
    EXPECT_GT(over.json()["flip"].get<double>(), 0.0001);
    EXPECT_EQ(run_parhelion({"compare", file("a.exr"), file("b.exr"), "--max-relmse", "1e-9"}).exit_code, 4);
}

TEST_F(CliRender, the_bench_of_the_reference_shades_in_both_places) {
    const ProcessResult result = run_parhelion({"bench", "reference", "--scene", "builtin:furnace", "--also", "builtin:diffuse-box", "--size", "16x16", "--spp", "1", "--json", "-"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const nlohmann::json all = result.json();
    std::map<std::string, int> cases;
    for (const auto& run : all["runs"]) {
        EXPECT_GT(run["mega_samples_per_s"], 0.0);
        EXPECT_GT(run["rays"]["path"], 0);
        ++cases[run["scene"].get<std::string>() + " " + run["trace"].get<std::string>() + " " + run["shade_in"].get<std::string>()];
    }
    const bool pipeline = shared_device()->caps().ray_pipeline, query = shared_device()->caps().ray_query;
    for (const std::string scene : {"builtin:furnace", "builtin:diffuse-box"}) {
        EXPECT_EQ(cases[scene + " compute raygen"], 1);
        EXPECT_EQ(cases[scene + " query raygen"], query);
        EXPECT_EQ(cases[scene + " pipeline raygen"], pipeline);
        EXPECT_EQ(cases[scene + " pipeline closest_hit"], pipeline);
    }
}

TEST_F(CliRender, the_bench_of_tracing_holds_every_way_against_the_others_on_the_same_rays) {
    const ProcessResult result = run_parhelion({"bench", "trace", "--scene", "room-s", "--scene", "room-s-instanced", "--size", "40x24", "--json", "-"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const nlohmann::json all = result.json();
    ASSERT_EQ(all["rates"].size(), 6u);
    const auto& caps = shared_device()->caps();
    for (const auto& row : all["rates"]) {
        EXPECT_EQ(row["rays"], 40 * 24);
        // A closed room: what looks or bounces meets something; some of the random points are seen, and some are not.
        if (row["kind"] != "shadow") EXPECT_EQ(row["hits"], 40 * 24);
        else EXPECT_TRUE(row["hits"] > 48 && row["hits"] < 40 * 24 - 48) << row["hits"];
        EXPECT_EQ(row["tracers"].size(), 1u + caps.ray_pipeline + caps.ray_query);
        for (const auto& tracer : row["tracers"]) EXPECT_GT(tracer["mrays_per_s"], 0.0);
    }
    const ProcessResult wrong = run_parhelion({"bench", "trace", "--spp", "4"});
    EXPECT_EQ(wrong.exit_code, 2);
    EXPECT_NE(wrong.err.find("--spp"), std::string::npos) << wrong.err;
}

TEST_F(CliRender, what_was_measured_decides_auto_and_is_named_in_the_json) {
    setenv("PARHELION_CACHE_DIR", file("cache").c_str(), 1);
    const Words render{"render", "builtin:furnace", "--size", "8x8", "--spp", "1", "--exposure", "0", "--json", "-"};
    EXPECT_EQ(run_parhelion(render).json()["trace_source"], "table");
    const gpu::DeviceCaps& caps = shared_device()->caps();
    store_measured_trace(caps, {{{"four", 2.0}, {"compact", 1.0}}});
    nlohmann::json json = run_parhelion(render).json();
    EXPECT_EQ(json["trace"], "compute");
    EXPECT_EQ(json["trace_source"], "measured");
    EXPECT_EQ(json["own_bvh"]["nodes"], "four");
    if (caps.ray_query) {
        store_measured_trace(caps, {{{"four", 2.0}, {"query", 3.0}}});
        json = run_parhelion(render).json();
        EXPECT_EQ(json["trace"], "query");
        EXPECT_EQ(run_parhelion(render + Words{"--trace", "compute"}).json()["trace_source"], "option");
    }
    unsetenv("PARHELION_CACHE_DIR");
}

TEST_F(CliRender, a_bench_run_prints_a_table_and_compares_with_its_own_json) {
    const Words words{"bench", "--scene", "builtin:furnace", "--size", "16x16", "--spp", "1", "--trace", "compute"};
    ASSERT_EQ(run_parhelion(words + Words{"--json", file("b.json")}).exit_code, 0);
    const ProcessResult second = run_parhelion(words + Words{"--baseline", file("b.json"), "--json", "-"});
    ASSERT_EQ(second.exit_code, 0) << second.err;
    EXPECT_TRUE(second.json()["runs"][0].contains("baseline_seconds"));
    EXPECT_NE(run_parhelion(words).out.find("builtin:furnace"), std::string::npos);
    expect_error(run_parhelion(words + Words{"--baseline", file("none.json")}), 1, "none.json");
}

}  // namespace parhelion::testing::cli_test
