// parhelion info: what is in a scene.
#include <cstdlib>

#include <nlohmann/json.hpp>

#include "app/cli/commands.h"
#include "scene/load.h"
#include "session/info_json.h"
#include "session/render_options.h"
#include "session/results.h"

namespace parhelion::cli {

int run_info(const OptionValues& values) {
    const SceneInfo info = describe(load_scene(values.positionals.front(), read_load_options(values)));
    if (values.given("--json"))
        write_json(values.text("--json"), info_json(info));
    else
        print_result(format_info(info));
    return EXIT_SUCCESS;
}

}  // namespace parhelion::cli
