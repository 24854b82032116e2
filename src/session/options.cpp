#include "session/options.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/file.h"
#include "base/parse.h"

namespace parhelion {

namespace {

using Given = OptionValues::Given;

const OptionSpec& known_option(Command command, std::string_view name) {
    const OptionSpec* spec = find_option(command, name);
    PARHELION_CHECK(spec, "the option table has no {}", name);
    return *spec;
}

[[noreturn]] void refuse_unknown(Command command, std::string_view name) {
    std::vector<std::string_view> names{"--help"};
    for (const OptionSpec* spec : options_of(command)) names.push_back(spec->name);
    const std::string near = nearest_name(name, names);
    std::string hint = fmt::format("parhelion help {} lists its options", command_spec(command).name);
    if (!near.empty()) hint = fmt::format("did you mean {}? {}", near, hint);
    for (const CommandSpec& other : command_table())
        if (near.empty() && find_option(other.id, name)) hint = fmt::format("it belongs to parhelion {}; {}", other.name, hint);
    throw Error(ErrorCode::Usage, fmt::format("there is no option {}", escape_name(name)), std::string(command_spec(command).name), hint);
}

// Takes words from the front, one option or positional at a time.
class WordReader {
public:
    WordReader(Command command, std::span<const std::string> words) : command_(command), words_(words) {}

    void read(std::vector<Given>& given, OptionValues& values) {
        bool only_positionals = false;
        while (next_ < words_.size()) {
            const std::string& word = words_[next_++];
            if (only_positionals || word.size() < 2 || word[0] != '-')
                values.positionals.push_back(word);
            else if (word == "--")
                only_positionals = true;
            else if (word == "--help" || word == "-h")
                values.wants_help = true;
            else
                given.push_back(read_option(word));
        }
    }

private:
    Given read_option(const std::string& word) {
        const size_t equals = word.find('=');
        const std::string name = word.substr(0, equals);
        const OptionSpec* spec = find_option(command_, name);
        if (!spec) refuse_unknown(command_, name);
        const bool flag = spec->kind == ValueKind::Flag;
        if (equals != std::string::npos) {
            if (flag) throw Error(ErrorCode::Usage, "it takes no value", name, fmt::format("write {} alone", name));
            return {name, word.substr(equals + 1), name};
        }
        if (flag) return {name, "on", name};
        if ((spec->bits & kOptionalValue) != 0) {
            if (next_ < words_.size() && words_[next_] == "-") ++next_;
            return {name, "-", name};
        }
        if (next_ == words_.size() || words_[next_].starts_with("--"))
            throw Error(ErrorCode::Usage, "its value is missing", name, fmt::format("{} {}", name, spec->value));
        return {name, words_[next_++], name};
    }

    Command command_;
    std::span<const std::string> words_;
    size_t next_ = 0;
};

std::vector<Given> read_environment(Command command, const EnvironmentLookup& environment) {
    std::vector<Given> given;
    for (const OptionSpec* spec : options_of(command)) {
        if (spec->environment.empty()) continue;
        const std::string variable(spec->environment);
        if (const char* value = environment(variable.c_str()); value && *value) given.push_back({std::string(spec->name), value, variable});
    }
    return given;
}

// JSON numbers keep their digits: 0.1 stays "0.1", 64 stays "64".
std::string preset_text(const nlohmann::json& value, const std::string& where) {
    if (value.is_string()) return value.get<std::string>();
    if (value.is_boolean()) return value.get<bool>() ? "on" : "off";
    if (value.is_number()) return value.dump();
    throw Error(ErrorCode::Usage, "is neither text, a number, true nor false", where);
}

void check_schema(const nlohmann::json& root, const std::string& file) {
    if (!root.is_object()) throw Error(ErrorCode::Usage, "is not a JSON object", file, "a preset looks like {\"schema\": 1, \"spp\": 256}");
    const auto schema = root.find("schema");
    if (schema == root.end() || *schema != 1)
        throw Error(ErrorCode::Usage, "lacks \"schema\": 1", file, "render --print-settings writes a preset");
}

}  // namespace

bool OptionValues::flag(std::string_view name) const { return given(name) && parse_bool(text(name), name); }

bool OptionValues::has(std::string_view name) const { return given(name) || !known_option(command_, name).fallback.empty(); }

std::string OptionValues::text(std::string_view name) const {
    if (const auto found = given_.find(name); found != given_.end()) return found->second.texts.back();
    const OptionSpec& spec = known_option(command_, name);
    PARHELION_CHECK(!spec.fallback.empty(), "{} has no value", name);
    return std::string(spec.fallback);
}

std::vector<std::string> OptionValues::texts(std::string_view name) const {
    const auto found = given_.find(name);
    return found == given_.end() ? std::vector<std::string>{} : found->second.texts;
}

std::string OptionValues::where(std::string_view name) const {
    const auto found = given_.find(name);
    return found == given_.end() ? std::string(name) : found->second.where;
}

void OptionValues::add_source(const std::vector<Given>& values) {
    for (size_t i = 0; i < values.size(); ++i) {
        const OptionSpec& spec = known_option(command_, values[i].name);
        check_value(spec, values[i].value, values[i].where);
        if (spec.exclusive == 0) continue;
        for (size_t k = 0; k < i; ++k)
            if (values[k].name != values[i].name && known_option(command_, values[k].name).exclusive == spec.exclusive)
                throw Error(ErrorCode::Usage, fmt::format("it cannot be used together with {}", values[k].where), values[i].where,
                            "leave one out");
        for (const OptionSpec* other : options_of(command_))
            if (other->exclusive == spec.exclusive) given_.erase(std::string(other->name));
    }
    for (const Given& value : values) {
        Value& kept = given_[value.name];
        if ((known_option(command_, value.name).bits & kRepeats) == 0) kept.texts.clear();
        kept.texts.push_back(value.value);
        kept.where = value.where;
    }
}

std::vector<Given> parse_preset(std::string_view json_text, std::string_view where) {
    const std::string file = escape_name(where);
    nlohmann::json root;
    try {
        root = nlohmann::json::parse(json_text);
    } catch (const nlohmann::json::exception&) {
        throw Error(ErrorCode::Usage, "is not valid JSON", file);
    }
    check_schema(root, file);
    std::vector<Given> given;
    for (const auto& [key, value] : root.items()) {
        if (key == "schema") continue;
        const std::string place = fmt::format("{}: {}", file, escape_name(key));
        if (key == "set") {
            if (!value.is_object()) throw Error(ErrorCode::Usage, "is not an object", place, "write \"set\": {\"group.field\": value}");
            for (const auto& [field, text] : value.items()) given.push_back({"--set", field + "=" + preset_text(text, place), place});
            continue;
        }
        const OptionSpec* spec = find_option(Command::Render, "--" + key);
        if (!spec) throw Error(ErrorCode::Usage, "there is no such option", place, "parhelion help render lists them");
        if ((spec->bits & kNotInPreset) != 0) throw Error(ErrorCode::Usage, "belongs on the command line, not into a preset", place);
        if (spec->kind == ValueKind::Flag && !value.is_boolean()) throw Error(ErrorCode::Usage, "is neither true nor false", place);
        given.push_back({"--" + key, preset_text(value, place), place});
    }
    return given;
}

OptionValues parse_options(Command command, std::span<const std::string> words, const EnvironmentLookup& environment) {
    OptionValues values(command);
    std::vector<Given> given;
    WordReader(command, words).read(given, values);
    for (const Given& preset : given) {
        if (preset.name != "--preset") continue;
        check_value(known_option(command, preset.name), preset.value, preset.where);
        constexpr uint64_t kMaxPresetBytes = 1 << 20;
        values.add_source(parse_preset(read_text_file(preset.value, kMaxPresetBytes), preset.value));
    }
    values.add_source(read_environment(command, environment));
    values.add_source(given);
    return values;
}

bool fits_renderer(const OptionValues& values, const OptionSpec& option) {
    const auto names = split_choices(known_option(values.command(), "--renderer").choices);
    const auto index = std::find(names.begin(), names.end(), values.text("--renderer")) - names.begin();
    return (option.renderers & (1u << index)) != 0;
}

namespace {

void check_renderer(const OptionValues& values) {
    for (const OptionSpec* spec : options_of(values.command()))
        if (values.given(spec->name) && !fits_renderer(values, *spec))
            throw Error(ErrorCode::Usage, fmt::format("it does not fit --renderer {}", values.text("--renderer")), values.where(spec->name),
                        std::string(spec->instead));
}

void check_positionals(const OptionValues& values) {
    const CommandSpec& spec = command_spec(values.command());
    const std::string usage = fmt::format("parhelion {} {}", spec.name, spec.positionals);
    const bool prints_only = values.command() == Command::Render && values.flag("--print-settings");
    if (values.positionals.size() < spec.min_positionals && !prints_only)
        throw Error(ErrorCode::Usage, fmt::format("{} is missing", values.positionals.empty() ? spec.positionals : "the second file"),
                    std::string(spec.name), usage);
    if (values.positionals.size() > spec.max_positionals)
        throw Error(ErrorCode::Usage, fmt::format("'{}' is one argument too many", escape_name(values.positionals[spec.max_positionals])),
                    std::string(spec.name), usage);
    for (const std::string& positional : values.positionals)
        if (positional.empty()) throw Error(ErrorCode::Usage, "an argument is empty", std::string(spec.name), usage);
}

}  // namespace

void check_options(const OptionValues& values) {
    check_positionals(values);
    if (find_option(values.command(), "--renderer")) check_renderer(values);
    for (const OptionSpec* spec : options_of(values.command()))
        if (values.given(spec->name) && (spec->bits & kAbsent) != 0)
            throw Error(ErrorCode::Usage, "it is not built into this version", values.where(spec->name), "leave it out");
}

std::string find_json_target(Command command, std::span<const std::string> words) {
    const OptionSpec* spec = find_option(command, "--json");
    std::string target;
    for (size_t i = 0; spec && i < words.size() && words[i] != "--"; ++i) {
        if (words[i].starts_with("--json=")) target = words[i].substr(7);
        if (words[i] != "--json") continue;
        if ((spec->bits & kOptionalValue) != 0)
            target = "-";
        else if (i + 1 < words.size() && !words[i + 1].starts_with("--"))
            target = words[i + 1];
    }
    return target;
}

}  // namespace parhelion
