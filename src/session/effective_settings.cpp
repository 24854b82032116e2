// `render --print-settings`: all options as they would be used, in the form that --preset reads.
#include "session/effective_settings.h"

#include <nlohmann/json.hpp>

#include "base/error.h"
#include "session/render_settings.h"

namespace parhelion {

using Json = nlohmann::ordered_json;

namespace {

Json typed_value(const OptionSpec& option, const std::string& text) {
    if (option.kind == ValueKind::Integer) return parse_int(text, option.name);
    if (option.kind == ValueKind::Number && option.choices.find(text) == std::string_view::npos) return parse_float(text, option.name);
    return text;
}

// Numbers and switches of the settings as JSON ones, names as text.
Json setting_value(const std::string& text) {
    const Json parsed = Json::parse(text, nullptr, false);
    return parsed.is_number() ? parsed : Json(text);
}

}  // namespace

Json effective_settings(const OptionValues& values) {
    Json out = {{"schema", 1}};
    for (const OptionSpec* option : options_of(values.command())) {
        if ((option->bits & (kNotInPreset | kAbsent | kRepeats)) != 0 || !fits_renderer(values, *option)) continue;
        const std::string key(option->name.substr(2));
        if (option->kind == ValueKind::Flag)
            out[key] = values.flag(option->name);
        else if (values.has(option->name))
            out[key] = typed_value(*option, values.text(option->name));
    }
    RenderSettings settings;
    for (const std::string& assignment : values.texts("--set")) apply_assignment(settings, assignment);
    for (const SettingRow& row : list_settings(settings)) out["set"][row.key] = setting_value(row.value);
    return out;
}

}  // namespace parhelion
