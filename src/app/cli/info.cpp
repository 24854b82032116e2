// parhelion info: what is in a scene.
#include <cstdlib>

#include <nlohmann/json.hpp>

#include "app/cli/commands.h"
#include "session/results.h"
#include "session/scene_info.h"

namespace parhelion::cli {

int run_info(const OptionValues& values) {
    const SceneInfo info = describe_scene(values.positionals.front());
    if (values.given("--json"))
        write_json(values.text("--json"), scene_info_json(info));
    else
        print_result(scene_info_text(info));
    return EXIT_SUCCESS;
}

}  // namespace parhelion::cli
