#pragma once
// From words to checked option values. Later wins: the table's defaults, a preset, the environment, the words of the command line.
// Every complaint is a usage Error that names the option (or the preset's key, or the variable), what is wrong and what to do.
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "session/option_table.h"

namespace parhelion {

class OptionValues {
public:
    explicit OptionValues(Command command) : command_(command) {}

    Command command() const { return command_; }
    std::vector<std::string> positionals;
    bool wants_help = false;

    bool given(std::string_view name) const { return given_.find(name) != given_.end(); }
    bool flag(std::string_view name) const;
    // The value: the one given, else the table's default. `has` is false where there is neither.
    bool has(std::string_view name) const;
    std::string text(std::string_view name) const;
    std::vector<std::string> texts(std::string_view name) const;  // all values of an option that repeats
    std::string where(std::string_view name) const;               // what an error about this value calls it

    // Adds values of one source over those of earlier ones; checks each. A repeating option adds to the earlier source's values,
    // others replace them, and also what they exclude. Two that exclude each other within one source are an error.
    struct Given {
        std::string name, value, where;
    };
    void add_source(const std::vector<Given>& values);

private:
    struct Value {
        std::vector<std::string> texts;
        std::string where;
    };
    Command command_;
    std::map<std::string, Value, std::less<>> given_;
};

using EnvironmentLookup = std::function<const char*(const char*)>;

// The words after the command's name. Reads the preset that they name. Does not check that options fit together: see below.
OptionValues parse_options(Command command, std::span<const std::string> words, const EnvironmentLookup& environment);

// An option that does not fit the renderer, that this version lacks, or a wrong number of positional arguments.
void check_options(const OptionValues& values);

// Presets: {"schema": 1, "spp": 256, "size": "640x360", "set": {"sampler.kind": "pcg"}}. `where` names the file in errors.
std::vector<OptionValues::Given> parse_preset(std::string_view json_text, std::string_view where);

// Where a failing run should write its error as JSON, found without parsing the rest: "" nowhere, "-" stdout, else a file.
std::string find_json_target(Command command, std::span<const std::string> words);

// Whether the renderer that the values of a command with --renderer name has this option.
bool fits_renderer(const OptionValues& values, const OptionSpec& option);

}  // namespace parhelion
