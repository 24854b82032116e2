// parhelion: finds the command, runs it, and turns what goes wrong into one line, JSON where it was asked for, and an exit code.
#include <cstdlib>
#include <new>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/cli/commands.h"
#include "base/error.h"
#include "base/log.h"
#include "base/platform.h"
#include "session/help.h"
#include "session/results.h"
#include "session/version.h"

namespace parhelion::cli {

namespace {

int dispatch(const OptionValues& values, const std::vector<std::string>& words) {
    switch (values.command()) {
        case Command::Render:
            return run_render(values);
        case Command::View:
            return run_view(values, words);
        case Command::Compare:
            return run_compare(values);
        case Command::Merge:
            return run_merge(values);
        case Command::Devices:
            return run_devices(values);
        case Command::Info:
            return run_info(values);
        case Command::Export:
            return run_export(values);
        case Command::Bench:
            return run_bench(values);
        case Command::Settings:
            return run_settings(values);
        case Command::Help:
            return run_help(values);
    }
    return EXIT_FAILURE;
}

const CommandSpec& require_command(const std::string& name) {
    if (const CommandSpec* spec = find_command(name)) return *spec;
    std::vector<std::string_view> names;
    for (const CommandSpec& spec : command_table()) names.push_back(spec.name);
    const std::string near = nearest_name(name, names);
    throw Error(ErrorCode::Usage, fmt::format("there is no command '{}'", escape_name(name)), {},
                near.empty() ? "parhelion help lists them" : fmt::format("did you mean {}?", near));
}

int run_command(const CommandSpec& spec, const std::vector<std::string>& words) {
    const OptionValues values = parse_options(spec.id, words, [](const char* name) { return std::getenv(name); });
    if (values.wants_help) {
        print_result(command_help(spec.id));
        return EXIT_SUCCESS;
    }
    check_options(values);
    return dispatch(values, words);
}

// Returns the exit code. A JSON target that cannot be written adds a second line, unless it is what the error is about.
int report(const Error& error, const std::string& json_target) {
    log_line(LogLevel::Error, error.line);
    try {
        write_json(json_target, error_json(error));
    } catch (const Error& second) {
        if (second.where != error.where) log_line(LogLevel::Error, second.line);
    }
    return static_cast<int>(error.code);
}

int run(const std::vector<std::string>& words) {
    if (words.empty()) {
        log_line(LogLevel::Error, "a command is missing (parhelion help lists them)");
        return static_cast<int>(ErrorCode::Usage);
    }
    std::string json_target;
    try {
        log_level();  // PARHELION_LOG is checked first
        if (words[0] == "--version") {
            print_result(fmt::format("parhelion {}\n", version()));
            return EXIT_SUCCESS;
        }
        if (words[0] == "--help" || words[0] == "-h") {
            print_result(overview_help());
            return EXIT_SUCCESS;
        }
        const CommandSpec& spec = require_command(words[0]);
        const std::vector<std::string> rest(words.begin() + 1, words.end());
        json_target = find_json_target(spec.id, rest);
        return run_command(spec, rest);
    } catch (const Error& error) {
        return report(error, json_target);
    } catch (const std::bad_alloc&) {
        return report(Error(ErrorCode::Failed, "the machine's memory is used up", words[0], "try a smaller --size or scene"), json_target);
    } catch (const std::exception& error) {
        return report(Error(ErrorCode::Failed, error.what(), words[0]), json_target);
    }
}

}  // namespace

}  // namespace parhelion::cli

int main(int argc, char** argv) {
    parhelion::platform::install_interrupt_handlers();
    return parhelion::cli::run({argv + (argc > 0 ? 1 : 0), argv + argc});
}
