#pragma once
// The one table of commands and options. Parsing, checks, `help`, the man page, shell completions, docs/command-line.md and
// presets are all made from it, so that none of them can disagree with another.
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace parhelion {

enum class Command : uint32_t { Render, View, Compare, Merge, Devices, Info, Export, Bench, Settings, Help };

struct CommandSpec {
    Command id;
    std::string_view name;
    std::string_view positionals;  // as the usage line shows them; "" for none
    uint32_t min_positionals, max_positionals;
    std::string_view summary;      // one line
    std::string_view description;  // paragraphs, separated by an empty line
    std::vector<std::string_view> examples;
};

enum class ValueKind : uint32_t {
    Flag,          // no value
    Integer,       // whole number in [min, max]
    Number,        // finite number in [min, max], or one of `choices`
    Size,          // WxH
    Range,         // A-B with A < B
    CountOrRange,  // N or A-B
    Vector,        // x,y,z
    Duration,      // 30s, 2m
    Choice,        // one of `choices`
    List,          // comma-separated `choices`; "group.*" stands for all of a group
    Text,
    File,
    Assignment,  // group.field=value
};

// Which renderers an option fits.
enum RendererBits : uint32_t { kReference = 1, kWavefront = 2, kRealtime = 4, kPathTracers = kReference | kWavefront, kEveryRenderer = 7 };

enum OptionBits : uint32_t {
    kRepeats = 1,        // may be given several times, all count; otherwise the last one does
    kNotInPreset = 2,    // names a place or an action of one run, not a property of the picture
    kOptionalValue = 4,  // alone it means `-`; a value follows an equals sign
    kAbsent = 8,         // the name is settled, this version does not have it
};

struct OptionSpec {
    std::string_view name;     // "--spp"
    std::string_view section;  // heading in `help`
    uint32_t commands = 0;     // bits: command_bit()
    ValueKind kind = ValueKind::Flag;
    std::string_view value;           // how help shows the value: "N"
    std::string_view fallback;        // default, "" for none
    std::string_view help;            // one line
    std::string_view choices;         // "a|b|c"
    std::string_view absent_choices;  // those of them that this version does not have: "b|c"
    double min = 0, max = 0;          // Integer and Number
    uint32_t bits = 0;
    uint32_t renderers = kEveryRenderer;
    std::string_view instead;      // for a renderer that it does not fit: what to use
    std::string_view environment;  // variable that sets it too
    uint32_t exclusive = 0;        // options of one non-zero group exclude each other
};

constexpr uint32_t command_bit(Command command) { return 1u << static_cast<uint32_t>(command); }

std::span<const CommandSpec> command_table();
std::span<const OptionSpec> option_table();
const CommandSpec& command_spec(Command command);
const CommandSpec* find_command(std::string_view name);                                     // nullptr: there is none
const OptionSpec* find_option(Command command, std::string_view name);                      // with its dashes; nullptr: there is none
std::vector<const OptionSpec*> options_of(Command command);                                 // in table order, sections together
std::vector<std::string_view> split_choices(std::string_view choices);                      // at '|'
std::string nearest_name(std::string_view given, std::span<const std::string_view> names);  // "" if none is close

// Throws a usage Error unless `text` is a complete, valid value of the option. `where` names the source: "--spp", a preset's key.
void check_value(const OptionSpec& option, std::string_view text, std::string_view where);
// The choices that a List value names, wildcards expanded, in table order and once each.
std::vector<std::string> expand_list(const OptionSpec& option, std::string_view text, std::string_view where);

struct NamedHelp {
    std::string_view name, help;
};
std::span<const NamedHelp> exit_code_table();
std::span<const NamedHelp> environment_table();

}  // namespace parhelion
