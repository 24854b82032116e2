// Look-ups in the option table and the check of one value.
#include <algorithm>
#include <array>

#include "base/error.h"
#include "base/parse.h"
#include "session/option_table.h"

namespace parhelion {

const CommandSpec& command_spec(Command command) {
    const auto table = command_table();
    return *std::find_if(table.begin(), table.end(), [&](const CommandSpec& spec) { return spec.id == command; });
}

const CommandSpec* find_command(std::string_view name) {
    for (const CommandSpec& spec : command_table())
        if (spec.name == name) return &spec;
    return nullptr;
}

const OptionSpec* find_option(Command command, std::string_view name) {
    for (const OptionSpec& spec : option_table())
        if (spec.name == name && (spec.commands & command_bit(command)) != 0) return &spec;
    return nullptr;
}

std::vector<const OptionSpec*> options_of(Command command) {
    std::vector<const OptionSpec*> found;
    std::vector<std::string_view> sections;
    for (const OptionSpec& spec : option_table()) {
        if ((spec.commands & command_bit(command)) == 0) continue;
        found.push_back(&spec);
        if (std::find(sections.begin(), sections.end(), spec.section) == sections.end()) sections.push_back(spec.section);
    }
    const auto rank = [&](const OptionSpec* spec) { return std::find(sections.begin(), sections.end(), spec->section); };
    std::stable_sort(found.begin(), found.end(), [&](const OptionSpec* a, const OptionSpec* b) { return rank(a) < rank(b); });
    return found;
}

std::vector<std::string_view> split_choices(std::string_view choices) {
    std::vector<std::string_view> parts;
    while (!choices.empty()) {
        const size_t bar = std::min(choices.find('|'), choices.size());
        parts.push_back(choices.substr(0, bar));
        choices.remove_prefix(std::min(bar + 1, choices.size()));
    }
    return parts;
}

namespace {

// Optimal string alignment distance: Levenshtein's with swapped neighbours as one step.
size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
    for (size_t j = 0; j <= b.size(); ++j) last[j] = j;
    for (size_t i = 1; i <= a.size(); ++i) {
        row[0] = i;
        for (size_t j = 1; j <= b.size(); ++j) {
            row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) row[j] = std::min(row[j], before[j - 2] + 1);
        }
        before = last;
        last = row;
    }
    return last[b.size()];
}

bool contains(std::string_view choices, std::string_view name) {
    const auto parts = split_choices(choices);
    return std::find(parts.begin(), parts.end(), name) != parts.end();
}

void refuse_absent(const OptionSpec& option, std::string_view text, std::string_view where) {
    if (!contains(option.absent_choices, text)) return;
    std::string present;
    for (const std::string_view choice : split_choices(option.choices))
        if (!contains(option.absent_choices, choice)) present += (present.empty() ? "" : ", ") + std::string(choice);
    throw Error(ErrorCode::Usage, fmt::format("'{}' is not built into this version", text), std::string(where), "it has " + present);
}

void check_choice(const OptionSpec& option, std::string_view text, std::string_view where) {
    if (contains(option.choices, text)) return refuse_absent(option, text, where);
    std::string hint = "use one of " + std::string(option.choices);
    const auto names = split_choices(option.choices);
    if (const std::string near = nearest_name(text, names); !near.empty()) hint = fmt::format("did you mean {}? {}", near, hint);
    throw Error(ErrorCode::Usage, fmt::format("'{}' is not a choice", escape_name(text)), std::string(where), hint);
}

void check_number(const OptionSpec& option, std::string_view text, std::string_view where) {
    if (contains(option.choices, text)) return;
    try {
        if (option.kind == ValueKind::Integer)
            parse_int(text, where, static_cast<int64_t>(option.min), static_cast<int64_t>(option.max));
        else
            parse_float(text, where, option.min, option.max);
    } catch (const Error& error) {
        if (option.choices.empty()) throw;
        throw Error(error.code, error.problem, error.where,
                    fmt::format("a number from {} to {}, or {}", option.min, option.max, option.choices));
    }
}

void check_assignment(std::string_view text, std::string_view where) {
    const size_t equals = text.find('=');
    if (equals == std::string_view::npos || equals == 0 || equals + 1 == text.size() ||
        text.substr(0, equals).find('.') == std::string_view::npos)
        throw Error(ErrorCode::Usage, fmt::format("'{}' is not of the form group.field=value", escape_name(text)), std::string(where),
                    "parhelion settings lists them all");
}

}  // namespace

std::string nearest_name(std::string_view given, std::span<const std::string_view> names) {
    std::string nearest;
    size_t best = std::max<size_t>(2, given.size() / 3) + 1;
    for (const std::string_view name : names) {
        const size_t distance = edit_distance(given, name);
        if (distance < best && distance < name.size()) best = distance, nearest = name;
    }
    return nearest;
}

std::vector<std::string> expand_list(const OptionSpec& option, std::string_view text, std::string_view where) {
    const auto choices = split_choices(option.choices);
    std::vector<bool> wanted(choices.size(), false);
    for (std::string_view rest = text;;) {
        const size_t comma = rest.find(',');
        const std::string_view part = rest.substr(0, comma);
        if (part.ends_with(".*")) {
            const std::string_view prefix = part.substr(0, part.size() - 1);
            bool any = false;
            for (size_t i = 0; i < choices.size(); ++i)
                if (choices[i].starts_with(prefix) && !contains(option.absent_choices, choices[i])) any = wanted[i] = true;
            if (!any) check_choice(option, part, where);
        } else {
            check_choice(option, part, where);
            wanted[static_cast<size_t>(std::find(choices.begin(), choices.end(), part) - choices.begin())] = true;
        }
        if (comma == std::string_view::npos) break;
        rest.remove_prefix(comma + 1);
    }
    std::vector<std::string> names;
    for (size_t i = 0; i < choices.size(); ++i)
        if (wanted[i]) names.emplace_back(choices[i]);
    return names;
}

void check_value(const OptionSpec& option, std::string_view text, std::string_view where) {
    if (text.empty() && option.kind != ValueKind::Flag)
        throw Error(ErrorCode::Usage, "its value is empty", std::string(where), fmt::format("{} {}", option.name, option.value));
    switch (option.kind) {
        case ValueKind::Flag:
            parse_bool(text, where);
            break;
        case ValueKind::Integer:
        case ValueKind::Number:
            check_number(option, text, where);
            break;
        case ValueKind::Size:
            parse_size(text, where);
            break;
        case ValueKind::Range:
            parse_range(text, where);
            break;
        case ValueKind::CountOrRange:
            if (text.find('-', 1) != std::string_view::npos)
                parse_range(text, where);
            else
                parse_int(text, where, 1, 1 << 30);
            break;
        case ValueKind::Vector:
            parse_vec3(text, where);
            break;
        case ValueKind::Duration:
            parse_duration_seconds(text, where);
            break;
        case ValueKind::Choice:
            check_choice(option, text, where);
            break;
        case ValueKind::List:
            expand_list(option, text, where);
            break;
        case ValueKind::Assignment:
            check_assignment(text, where);
            break;
        case ValueKind::Text:
        case ValueKind::File:
            break;
    }
}

}  // namespace parhelion
