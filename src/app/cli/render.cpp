// parhelion render: options to a job, and the job's numbers to JSON.
#include <cstdlib>

#include <nlohmann/json.hpp>

#include "app/cli/commands.h"
#include "base/error.h"
#include "session/effective_settings.h"
#include "session/job.h"
#include "session/results.h"

namespace parhelion::cli {

int run_render(const OptionValues& values) {
    const RenderOptions options = read_render_options(values);
    if (options.print_settings) {
        print_result(effective_settings(values).dump(2) + "\n");
        return EXIT_SUCCESS;
    }
    check_json_target(options.json);
    const RenderReport report = run_render_job(options);
    if (options.list_frame) print_result(report.listing);
    write_json(options.json, report_json(report));
    return exit_code(report.interrupt);
}

}  // namespace parhelion::cli
