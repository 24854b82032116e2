#include "session/help.h"

#include <algorithm>

#include "base/error.h"
#include "session/version.h"

namespace parhelion {

namespace {

constexpr size_t kWidth = 100;

// Breaks text at spaces so that lines stay within kWidth; every line starts with `indent` spaces. Ends with a newline.
std::string wrap(std::string_view text, size_t indent) {
    std::string out, line(indent, ' ');
    while (!text.empty()) {
        const size_t space = std::min(text.find(' '), text.size());
        if (line.size() > indent && line.size() + 1 + space > kWidth) {
            out += line + "\n";
            line.assign(indent, ' ');
        }
        if (line.size() > indent) line += ' ';
        line += text.substr(0, space);
        text.remove_prefix(std::min(space + 1, text.size()));
    }
    return out + line + "\n";
}

std::string named_rows(std::span<const NamedHelp> rows) {
    std::string out;
    for (const NamedHelp& row : rows) out += fmt::format("  {:<24}{}\n", row.name, row.help);
    return out;
}

std::string option_help(const OptionSpec& option) {
    return fmt::format("  {}\n", detail::option_form(option)) + wrap(std::string(option.help) + detail::option_remarks(option), 8);
}

std::string usage_line(const CommandSpec& spec) {
    std::string line = fmt::format("parhelion {}", spec.name);
    if (!spec.positionals.empty()) line += fmt::format(" {}", spec.positionals);
    return options_of(spec.id).empty() ? line : line + " [options]";
}

// Calls visit(paragraph) for each piece between empty lines.
template <class Visit>
void for_each_paragraph(std::string_view text, Visit&& visit) {
    while (!text.empty()) {
        const size_t gap = std::min(text.find("\n\n"), text.size());
        visit(text.substr(0, gap));
        text.remove_prefix(std::min(gap + 2, text.size()));
    }
}

}  // namespace

namespace detail {

std::string option_form(const OptionSpec& option) {
    if (option.value.empty()) return std::string(option.name);
    if ((option.bits & kOptionalValue) != 0) return fmt::format("{}[={}]", option.name, option.value);
    return fmt::format("{} {}", option.name, option.value);
}

std::string option_remarks(const OptionSpec& option) {
    std::string out;
    const auto add = [&](const std::string& text) { out += "; " + text; };
    if (option.kind == ValueKind::Choice) out = ": " + std::string(option.choices);
    if (option.kind == ValueKind::List)
        for (const std::string_view choice : split_choices(option.choices)) out += (out.empty() ? ": " : ", ") + std::string(choice);
    if (!option.fallback.empty()) add("default " + std::string(option.fallback));
    if (option.renderers == kPathTracers) add("reference and wavefront only");
    if (option.renderers == kRealtime) add("realtime only");
    if (!option.environment.empty()) add(fmt::format("also by {}", option.environment));
    if (!option.absent_choices.empty()) add(fmt::format("not in this version: {}", option.absent_choices));
    if ((option.bits & kAbsent) != 0) add("not in this version");
    return out;
}

}  // namespace detail

std::string overview_help() {
    std::string out =
        fmt::format("Parhelion {}: a ray-traced lighting renderer.\n\nUsage: parhelion COMMAND [options]\n\nCommands:\n", version());
    for (const CommandSpec& spec : command_table())
        out += fmt::format("  {:<24}{}\n", std::string(spec.name) + " " + std::string(spec.positionals), spec.summary);
    out += "\nTry:\n  parhelion render builtin:cornell --out cornell.png\n  parhelion help render\n\n";
    return out + "Exit codes:\n" + named_rows(exit_code_table()) + "\nEnvironment:\n" + named_rows(environment_table());
}

std::string command_help(Command command) {
    const CommandSpec& spec = command_spec(command);
    std::string out =
        fmt::format("Usage: {}\n\n{}{}.\n", usage_line(spec), static_cast<char>(std::toupper(spec.summary[0])), spec.summary.substr(1));
    for_each_paragraph(spec.description, [&](std::string_view paragraph) { out += "\n" + wrap(paragraph, 0); });
    std::string_view section;
    for (const OptionSpec* option : options_of(command)) {
        if (option->section != section) out += fmt::format("\n{}:\n", section = option->section);
        out += option_help(*option);
    }
    out += "\nExamples:\n";
    for (const std::string_view example : spec.examples) out += fmt::format("  {}\n", example);
    return out;
}

// Markdown.

namespace {

std::string markdown_cell(std::string_view text) {
    std::string out;
    for (const char c : text) out += c == '|' ? std::string("\\|") : std::string(1, c);
    return out;
}

std::string markdown_rows(std::string_view heading, std::span<const NamedHelp> rows) {
    std::string out = fmt::format("\n## {}\n\n| | |\n|---|---|\n", heading);
    for (const NamedHelp& row : rows) out += fmt::format("| `{}` | {} |\n", row.name, row.help);
    return out;
}

std::string markdown_command(const CommandSpec& spec) {
    std::string out = fmt::format("\n## {}\n\n`{}`: {}.\n", spec.name, usage_line(spec), spec.summary);
    for_each_paragraph(spec.description, [&](std::string_view paragraph) { out += fmt::format("\n{}\n", paragraph); });
    out += "\n```sh\n";
    for (const std::string_view example : spec.examples) out += fmt::format("{}\n", example);
    out += "```\n";
    const auto options = options_of(spec.id);
    if (!options.empty()) out += "\n| option | what it does |\n|---|---|\n";
    for (const OptionSpec* option : options)
        out += fmt::format("| `{}` | {} |\n", markdown_cell(detail::option_form(*option)),
                           markdown_cell(std::string(option->help) + detail::option_remarks(*option)));
    return out;
}

}  // namespace

std::string markdown_help() {
    std::string out =
        "# Command line\n\nMade by `parhelion help --markdown` from the table in `src/session/option_table.cpp`: change it there.\n\n"
        "Results go to stdout, everything else to stderr. An option's value may be written `--spp 64` or `--spp=64`. Later wins: "
        "defaults, `--preset`, environment, options.\nEvery JSON has `\"schema\": 1`; a failed run with `--json` writes "
        "`{\"schema\": 1, \"error\": {\"code\", \"what\", \"where\", \"hint\"}}`.\n";
    for (const CommandSpec& spec : command_table()) out += markdown_command(spec);
    return out + markdown_rows("Exit codes", exit_code_table()) + markdown_rows("Environment", environment_table());
}

// The man page.

namespace {

// Plain text as roff: backslashes and dashes escaped, no line taken for a request.
std::string roff(std::string_view text) {
    std::string out;
    for (const char c : text) {
        if (c == '\\')
            out += "\\e";
        else if (c == '-')
            out += "\\-";
        else if ((c == '.' || c == '\'') && (out.empty() || out.back() == '\n'))
            out += std::string("\\&") + c;
        else
            out += c;
    }
    return out;
}

std::string roff_item(std::string_view term, std::string_view text) { return fmt::format(".TP\n.B {}\n{}\n", roff(term), roff(text)); }

std::string man_command(const CommandSpec& spec) {
    std::string out = fmt::format(".SS {}\n{}.\n", roff(usage_line(spec)), roff(spec.summary));
    for_each_paragraph(spec.description, [&](std::string_view paragraph) { out += fmt::format(".PP\n{}\n", roff(paragraph)); });
    for (const OptionSpec* option : options_of(spec.id))
        out += roff_item(detail::option_form(*option), std::string(option->help) + detail::option_remarks(*option));
    return out;
}

}  // namespace

std::string man_page() {
    std::string out = fmt::format(".TH PARHELION 1 \"\" \"Parhelion {}\" \"User Commands\"\n", version());
    out += ".SH NAME\nparhelion \\- ray\\-traced lighting renderer\n.SH SYNOPSIS\n.B parhelion\n.I command\n[options]\n";
    out +=
        ".SH DESCRIPTION\nDraws glTF scenes on any Vulkan device: a GPU with ray tracing hardware, one without, or a CPU.\n"
        "Results go to stdout, everything else to stderr.\n.SH COMMANDS\n";
    for (const CommandSpec& spec : command_table()) out += man_command(spec);
    out += ".SH EXIT STATUS\n";
    for (const NamedHelp& row : exit_code_table()) out += roff_item(row.name, row.help);
    out += ".SH ENVIRONMENT\n";
    for (const NamedHelp& row : environment_table()) out += roff_item(row.name, row.help);
    out += ".SH EXAMPLES\n.nf\n";
    for (const CommandSpec& spec : command_table())
        for (const std::string_view example : spec.examples) out += roff(example) + "\n";
    return out + ".fi\n";
}

}  // namespace parhelion
