// parhelion settings: every key of --set with its default, its range and what it does.
#include <cstdlib>

#include <nlohmann/json.hpp>

#include "app/cli/commands.h"
#include "session/render_settings.h"
#include "session/results.h"

namespace parhelion::cli {

int run_settings(const OptionValues& values) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    std::string text;
    for (const SettingRow& row : list_settings(RenderSettings{})) {
        list.push_back({{"key", row.key}, {"default", row.value}, {"allowed", row.allowed}, {"help", row.help}});
        text += fmt::format("{}={}\n    {} [{}]\n", row.key, row.value, row.help, row.allowed);
    }
    if (values.given("--json"))
        write_json(values.text("--json"), {{"settings", list}});
    else
        print_result(text);
    return EXIT_SUCCESS;
}

}  // namespace parhelion::cli
