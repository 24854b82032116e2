#pragma once
// The settings visitor. A group of settings is a plain struct with defaults and one function
//     template <class V> void visit(V&& v, Group& g) {
//         v.field("sampler.kind", g.kind, choices({"owen", "cranley", "pcg", "white"}), "how sample points are made");
//         v.field("light.infinite_share", g.infinite_share, range(0.01, 0.99), "...");
//     }
// From that one list come `--set group.field=value`, presets, `settings` help, the effective-settings dump, the settings hash
// and the viewer's panels. Fields are bool, int32_t, uint32_t, float, or an enum (listed by choices in order of its values).
#include <charconv>
#include <initializer_list>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/hash.h"
#include "base/parse.h"

namespace parhelion {

struct SettingRange {
    double min, max;
};
struct SettingChoices {
    std::vector<std::string_view> names;
};
inline SettingRange range(double min, double max) { return {min, max}; }
inline SettingChoices choices(std::initializer_list<std::string_view> names) { return {names}; }
inline SettingChoices on_off() { return {{"off", "on"}}; }

// One row of the table that all uses are made from. Values are text in the form that `--set` takes.
struct SettingRow {
    std::string key, value, allowed, help;
};

namespace detail {

inline std::string join_choices(const SettingChoices& c) {
    std::string out;
    for (const std::string_view name : c.names) out += (out.empty() ? "" : "|") + std::string(name);
    return out;
}

template <class T>
std::string setting_text(const T& value, const SettingRange&) {
    char buffer[64];
    const auto result = std::to_chars(buffer, buffer + sizeof(buffer), value);
    return {buffer, result.ptr};
}
template <class T>
std::string setting_text(const T& value, const SettingChoices& c) {
    return std::string(c.names.at(static_cast<size_t>(value)));
}

template <class T>
void read_setting(T& field, std::string_view key, std::string_view text, const SettingRange& r) {
    if constexpr (std::is_integral_v<T>)
        field = static_cast<T>(parse_int(text, key, static_cast<int64_t>(r.min), static_cast<int64_t>(r.max)));
    else
        field = static_cast<T>(parse_float(text, key, r.min, r.max));
}
template <class T>
void read_setting(T& field, std::string_view key, std::string_view text, const SettingChoices& c) {
    for (size_t i = 0; i < c.names.size(); ++i)
        if (c.names[i] == text) {
            field = static_cast<T>(i);
            return;
        }
    throw Error(ErrorCode::Usage, fmt::format("'{}' is not one of {}", escape_name(text), join_choices(c)), std::string(key));
}

inline std::string allowed_text(const SettingRange& r) { return fmt::format("{}..{}", r.min, r.max); }
inline std::string allowed_text(const SettingChoices& c) { return join_choices(c); }

struct ListVisitor {
    std::vector<SettingRow> rows;
    template <class T, class Allowed>
    void field(std::string_view key, T& value, const Allowed& allowed, std::string_view help) {
        rows.push_back({std::string(key), setting_text(value, allowed), allowed_text(allowed), std::string(help)});
    }
};

struct SetVisitor {
    std::string_view key, text;
    bool found = false;
    template <class T, class Allowed>
    void field(std::string_view field_key, T& value, const Allowed& allowed, std::string_view) {
        if (field_key != key) return;
        read_setting(value, key, text, allowed);
        found = true;
    }
};

}  // namespace detail

// All settings of a struct, in declaration order.
template <class Group>
std::vector<SettingRow> list_settings(const Group& group) {
    Group copy = group;
    detail::ListVisitor visitor;
    visit(visitor, copy);
    return std::move(visitor.rows);
}

// Sets one field by key. Throws a usage Error (unknown key: names the nearest one; bad value: what is allowed).
template <class Group>
void apply_setting(Group& group, std::string_view key, std::string_view text) {
    detail::SetVisitor visitor{key, text};
    visit(visitor, group);
    if (visitor.found) return;
    std::string nearest;
    size_t best = 0;
    for (const SettingRow& row : list_settings(group)) {
        size_t common = 0;
        while (common < key.size() && common < row.key.size() && key[common] == row.key[common]) ++common;
        if (common > best) best = common, nearest = row.key;
    }
    throw Error(ErrorCode::Usage, fmt::format("there is no setting '{}'", escape_name(key)), "--set",
                nearest.empty() ? "parhelion settings lists them all" : fmt::format("did you mean {}? parhelion settings lists them all", nearest));
}

// "group.field=value"
template <class Group>
void apply_assignment(Group& group, std::string_view assignment) {
    const size_t equals = assignment.find('=');
    if (equals == std::string_view::npos)
        throw Error(ErrorCode::Usage, fmt::format("'{}' is not of the form group.field=value", escape_name(assignment)), "--set");
    apply_setting(group, assignment.substr(0, equals), assignment.substr(equals + 1));
}

template <class Group>
uint64_t hash_settings(const Group& group) {
    Hasher hasher;
    for (const SettingRow& row : list_settings(group)) hasher.text(row.key).text(row.value);
    return hasher.value();
}

}  // namespace parhelion
