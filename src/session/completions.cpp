// Shell completions, made from the option table.
#include <algorithm>

#include "base/error.h"
#include "session/help.h"

namespace parhelion {

namespace {

// Words that a shell can offer for an option's value, separated by spaces; choices this version lacks are left out.
std::string value_words(const OptionSpec& option) {
    if (option.kind != ValueKind::Choice && option.kind != ValueKind::List) return std::string(option.choices);
    const auto absent = split_choices(option.absent_choices);
    std::string words;
    for (const std::string_view choice : split_choices(option.choices))
        if (std::find(absent.begin(), absent.end(), choice) == absent.end()) words += (words.empty() ? "" : " ") + std::string(choice);
    return words;
}

bool is_offered(const OptionSpec& option) { return (option.bits & kAbsent) == 0; }

std::string command_words() {
    std::string words;
    for (const CommandSpec& spec : command_table()) words += (words.empty() ? "" : " ") + std::string(spec.name);
    return words;
}

std::string bash_command(const CommandSpec& spec) {
    std::string options, values;
    for (const OptionSpec* option : options_of(spec.id)) {
        if (!is_offered(*option)) continue;
        options += std::string(option->name) + " ";
        if (option->kind == ValueKind::Flag || (option->bits & kOptionalValue) != 0) continue;
        const std::string words = value_words(*option);
        if (option->kind == ValueKind::File)
            values += fmt::format("                {}) COMPREPLY=($(compgen -f -- \"$word\")); return ;;\n", option->name);
        else
            values += fmt::format("                {}) COMPREPLY=($(compgen -W '{}' -- \"$word\")); return ;;\n", option->name, words);
    }
    std::string out = fmt::format("        {})\n", spec.name);
    if (!values.empty()) out += fmt::format("            case $previous in\n{}            esac\n", values);
    return out + fmt::format("            options='{}--help' ;;\n", options);
}

std::string bash_completions() {
    std::string out = fmt::format(
        "# bash completion for parhelion; made by: parhelion help --completions bash\n"
        "_parhelion() {{\n"
        "    local word=${{COMP_WORDS[COMP_CWORD]}} previous=${{COMP_WORDS[COMP_CWORD-1]}} options=\n"
        "    COMPREPLY=()\n"
        "    if ((COMP_CWORD == 1)); then\n"
        "        COMPREPLY=($(compgen -W '{0} --version --help' -- \"$word\"))\n"
        "        return\n"
        "    fi\n"
        "    case ${{COMP_WORDS[1]}} in\n",
        command_words());
    for (const CommandSpec& spec : command_table()) out += bash_command(spec);
    return out + fmt::format(
                     "    esac\n"
                     "    if [[ $word == -* ]]; then\n"
                     "        COMPREPLY=($(compgen -W \"$options\" -- \"$word\"))\n"
                     "    elif [[ ${{COMP_WORDS[1]}} == help ]]; then\n"
                     "        COMPREPLY=($(compgen -W '{0}' -- \"$word\"))\n"
                     "    else\n"
                     "        COMPREPLY=($(compgen -f -- \"$word\"))\n"
                     "    fi\n"
                     "}}\n"
                     "complete -o filenames -F _parhelion parhelion\n",
                     command_words());
}

// Text inside single quotes; zsh's _arguments also gives meaning to brackets and colons.
std::string zsh_text(std::string_view text) {
    std::string out;
    for (const char c : text) {
        if (c == '\'')
            out += "'\\''";
        else if (c == '[' || c == ']' || c == ':')
            out += std::string("\\") + c;
        else
            out += c;
    }
    return out;
}

std::string zsh_option(const OptionSpec& option) {
    const bool repeats = (option.bits & kRepeats) != 0;
    std::string out = fmt::format("            '{}{}[{}]", repeats ? "*" : "", option.name, zsh_text(option.help));
    if (option.kind == ValueKind::Flag || (option.bits & kOptionalValue) != 0) return out + "'";
    const std::string words = value_words(option);
    out += fmt::format(":{}:", zsh_text(option.value));
    if (option.kind == ValueKind::File) return out + "_files'";
    return out + (words.empty() ? "'" : fmt::format("({})'", words));
}

std::string zsh_completions() {
    std::string out =
        "#compdef parhelion\n# made by: parhelion help --completions zsh\n_parhelion() {\n    if ((CURRENT == 2)); then\n"
        "        local -a commands=(\n";
    for (const CommandSpec& spec : command_table()) out += fmt::format("            '{}:{}'\n", spec.name, zsh_text(spec.summary));
    out += "        )\n        _describe command commands\n        return\n    fi\n    local -a arguments\n    case ${words[2]} in\n";
    for (const CommandSpec& spec : command_table()) {
        out += fmt::format("        {}) arguments=(\n", spec.name);
        for (const OptionSpec* option : options_of(spec.id))
            if (is_offered(*option)) out += zsh_option(*option) + "\n";
        out += spec.id == Command::Help ? fmt::format("            '*:command:({})'\n", command_words()) : "            '*:file:_files'\n";
        out += "        ) ;;\n";
    }
    return out + "    esac\n    shift words\n    ((CURRENT--))\n    _arguments $arguments\n}\n_parhelion \"$@\"\n";
}

std::string fish_text(std::string_view text) {
    std::string out;
    for (const char c : text) {
        if (c == '\'' || c == '\\') out += '\\';
        out += c;
    }
    return out;
}

std::string fish_completions() {
    std::string out = "# fish completion for parhelion; made by: parhelion help --completions fish\n";
    for (const CommandSpec& spec : command_table())
        out += fmt::format("complete -c parhelion -n __fish_use_subcommand -f -a {} -d '{}'\n", spec.name, fish_text(spec.summary));
    for (const CommandSpec& spec : command_table())
        for (const OptionSpec* option : options_of(spec.id)) {
            if (!is_offered(*option)) continue;
            out += fmt::format("complete -c parhelion -n '__fish_seen_subcommand_from {}' -l {} -d '{}'", spec.name, option->name.substr(2),
                               fish_text(option->help));
            if (option->kind != ValueKind::Flag && (option->bits & kOptionalValue) == 0) {
                const std::string words = value_words(*option);
                out += option->kind == ValueKind::File ? " -r -F" : words.empty() ? " -x" : fmt::format(" -x -a '{}'", words);
            }
            out += "\n";
        }
    return out + fmt::format("complete -c parhelion -n '__fish_seen_subcommand_from help' -f -a '{}'\n", command_words());
}

}  // namespace

std::string completions(std::string_view shell) {
    if (shell == "bash") return bash_completions();
    if (shell == "zsh") return zsh_completions();
    if (shell == "fish") return fish_completions();
    throw Error(ErrorCode::Usage, fmt::format("there are no completions for '{}'", escape_name(shell)), "--completions",
                "use bash, zsh or fish");
}

}  // namespace parhelion
