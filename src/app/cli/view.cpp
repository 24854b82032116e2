// parhelion view: starts parhelion-view, which alone knows windows.
#include "app/cli/commands.h"

namespace parhelion::cli {

int run_view(const OptionValues&, const std::vector<std::string>& words) {
    const std::filesystem::path program = platform::program_folder() / "parhelion-view";
    const std::string problem = platform::become_program(program, words);
    throw Error(ErrorCode::Failed, "cannot be started: " + problem, escape_name(program.string()),
                "the viewer is a program of its own, which is built where libglfw3-dev and libimgui-dev are installed (./dev view)");
}

}  // namespace parhelion::cli
