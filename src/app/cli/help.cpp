#include "session/help.h"

#include <cstdlib>

#include "app/cli/commands.h"
#include "base/error.h"
#include "session/results.h"

namespace parhelion::cli {

namespace {

std::string help_text(const OptionValues& values) {
    if (values.flag("--man")) return man_page();
    if (values.flag("--markdown")) return markdown_help();
    if (values.given("--completions")) return completions(values.text("--completions"));
    if (values.positionals.empty()) return overview_help();
    const std::string& name = values.positionals.front();
    if (const CommandSpec* spec = find_command(name)) return command_help(spec->id);
    throw Error(ErrorCode::Usage, fmt::format("there is no command '{}'", escape_name(name)), "help", "parhelion help lists them");
}

}  // namespace

int run_help(const OptionValues& values) {
    print_result(help_text(values));
    return EXIT_SUCCESS;
}

}  // namespace parhelion::cli
