// parhelion-view: a scene in a window. Options as `parhelion view` documents them.
#include <cstdlib>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include "app/view/script.h"
#include "base/error.h"
#include "base/file.h"
#include "base/log.h"
#include "base/platform.h"
#include "session/help.h"
#include "session/results.h"
#include "session/version.h"

namespace parhelion::view {

namespace {

int exit_code(platform::Interrupt interrupt) {
    if (interrupt == platform::Interrupt::None) return EXIT_SUCCESS;
    return static_cast<int>(interrupt == platform::Interrupt::Terminated ? ErrorCode::Terminated : ErrorCode::Interrupted);
}

void check_validation(const gpu::DevicePtr& device) {
    if (const uint64_t count = device->validation_message_count(); count != 0)
        throw Error(ErrorCode::Failed, fmt::format("the validation layers reported {} messages", count), "--validate", "they are printed above");
}

void loop(Window& window, gpu::Swapchain& swapchain, Interactive& session, std::optional<Script>& script) {
    Panels panels(window, session.device());
    Controls controls(window, session, panels);
    constexpr double kRest = 0.1;  // seconds, where nothing changes by itself
    while (!window.is_closing() && platform::interrupt_requested() == platform::Interrupt::None) {
        if (session.is_finished() && !script) window.wait(kRest);
        else window.poll();
        if (!swapchain.acquire(window.size().width, window.size().height)) {
            window.wait(kRest);
            continue;
        }
        session.resize({swapchain.extent().width, swapchain.extent().height});
        controls.steer(panels.begin(session, swapchain));
        const gpu::Image canvas = session.record();
        panels.draw(session.frame(), canvas);
        session.frame().show(canvas, swapchain);
        session.finish();
        if (script && !script->run(window, session, controls)) break;
    }
    window.on_key = {};
}

int view(const OptionValues& values) {
    const RenderOptions options = read_view_options(values);
    for (const std::filesystem::path& file : options.output.files) check_writable(file);
    std::optional<Script> script;
    if (values.given("--script")) script.emplace(values.text("--script"));
    Window window(options.size, "Parhelion: " + escape_name(options.scene));
    const gpu::DevicePtr device = gpu::Device::open({.selector = options.device, .validate = options.validate, .window_extensions = window.instance_extensions()});
    log(LogLevel::Info, "device {} ({})", escape_name(device->caps().name), escape_name(device->caps().driver));
    {
        const auto mode = values.text("--present") == "mailbox" ? gpu::PresentMode::Mailbox : gpu::PresentMode::Fifo;
        gpu::Swapchain swapchain(device, [&](VkInstance instance) { return window.make_surface(instance); }, mode);
        Interactive session(options, device);
        loop(window, swapchain, session, script);
    }
    check_validation(device);
    return exit_code(platform::interrupt_requested());
}

int run(const std::vector<std::string>& words) {
    try {
        log_level();  // PARHELION_LOG is checked first
        if (words.size() == 1 && words[0] == "--version") {
            print_result(fmt::format("parhelion-view {}\n", version()));
            return EXIT_SUCCESS;
        }
        const OptionValues values = parse_options(Command::View, words, [](const char* name) { return std::getenv(name); });
        if (values.wants_help) {
            print_result(command_help(Command::View));
            return EXIT_SUCCESS;
        }
        check_options(values);
        return view(values);
    } catch (const Error& error) {
        log_line(LogLevel::Error, error.line);
        return static_cast<int>(error.code);
    } catch (const std::bad_alloc&) {
        log_line(LogLevel::Error, "the machine's memory is used up (try a smaller --size or scene)");
    } catch (const std::exception& error) {
        log_line(LogLevel::Error, error.what());
    }
    return EXIT_FAILURE;
}

}  // namespace

}  // namespace parhelion::view

int main(int argc, char** argv) {
    parhelion::platform::install_interrupt_handlers();
    return parhelion::view::run({argv + (argc > 0 ? 1 : 0), argv + argc});
}
