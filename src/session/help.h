#pragma once
// Everything that is printed from the option table: help, the man page, shell completions and docs/command-line.md.
#include <string>
#include <string_view>

#include "session/option_table.h"

namespace parhelion {

std::string overview_help();                      // `parhelion help`
std::string command_help(Command command);        // `parhelion help COMMAND`, `parhelion COMMAND --help`
std::string man_page();                           // roff, section 1
std::string markdown_help();                      // docs/command-line.md
std::string completions(std::string_view shell);  // bash, zsh or fish; throws a usage Error for others

namespace detail {
std::string option_form(const OptionSpec& option);     // "--spp N"
std::string option_remarks(const OptionSpec& option);  // choices, default, which renderers, absent
}  // namespace detail

}  // namespace parhelion
