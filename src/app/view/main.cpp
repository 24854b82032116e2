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
#include "image/encode.h"
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

// What the window goes on with after a session on one device.
struct Next {
    InteractiveState state;
    std::string note;  // why
};

constexpr double kRest = 0.1;           // seconds, where nothing changes by itself
constexpr uint64_t kFewestFrames = 10;  // a device that is lost before so many is lost for good

// The window with its panels on one device, until it closes or goes on elsewhere.
class Session {
public:
    Session(const OptionValues& given, Window& window, const Next& from, std::optional<Script>& script, ShaderWatch& shaders)
        : device_(gpu::Device::open({.selector = from.state.options.device, .validate = from.state.options.validate, .window_extensions = window.instance_extensions()})),
          window_(window),
          swapchain_(device_, [&](VkInstance instance) { return window.make_surface(instance); }, given.text("--present") == "mailbox" ? gpu::PresentMode::Mailbox : gpu::PresentMode::Fifo),
          session_(from.state, device_),
          panels_(window, device_),
          controls_(given, window, session_, panels_, shaders),
          script_(script),
          shaders_(shaders) {
        log(LogLevel::Info, "device {} ({})", escape_name(device_->caps().name), escape_name(device_->caps().driver));
        if (!from.note.empty()) session_.set_note(from.note);
    }

    // None: the window was closed, or the script is done.
    std::optional<Next> run() {
        try {
            while (!window_.is_closing() && platform::interrupt_requested() == platform::Interrupt::None) {
                if (!frame()) break;
                if (!panels_.wanted_device.empty()) return elsewhere(panels_.wanted_device, "");
            }
        } catch (const DeviceLost& lost) {
            if (frames_ < kFewestFrames) throw;
            log_line(LogLevel::Error, lost.line);
            return elsewhere(session_.options().device, lost.line + "; begun anew");
        }
        check_validation(device_);
        return std::nullopt;
    }

private:
    Next elsewhere(const std::string& device, std::string note) const {
        Next next{session_.state(), std::move(note)};
        next.state.options.device = device;
        return next;
    }

    // False: the script is done.
    bool frame() {
        if (session_.is_finished() && !script_) window_.wait(kRest);
        else window_.poll();
        if (!swapchain_.acquire(window_.size().width, window_.size().height)) {
            window_.wait(kRest);
            return true;
        }
        session_.resize({swapchain_.extent().width, swapchain_.extent().height});
        controls_.steer(panels_.begin(session_, swapchain_));
        const gpu::Image canvas = session_.record();
        panels_.draw(session_.frame(), canvas);
        const std::filesystem::path shot = controls_.take_shot();
        const gpu::Buffer shown = shot.empty() ? gpu::Buffer() : session_.frame().read_back(canvas);
        session_.frame().show(canvas, swapchain_);
        session_.finish();
        if (shown) write_shot(shot, shown, session_.options().size);
        ++frames_;
        return !script_ || script_->run({window_, session_, panels_, controls_, shaders_});
    }

    // The window as it is: rgba8 rows.
    void write_shot(const std::filesystem::path& file, const gpu::Buffer& texels, Size2 size) {
        image::Picture8 picture{.width = size.width, .height = size.height};
        picture.rgb.reserve(size_t{3} * size.width * size.height);
        const auto bytes = texels.mapped_as<uint8_t>();
        for (size_t i = 0; i < size_t{4} * size.width * size.height; ++i)
            if (i % 4 != 3) picture.rgb.push_back(bytes[i]);
        Panels::change(session_, [&] {
            image::write_png(file, picture);
            session_.set_note("the window was written to " + escape_name(file.string()));
        });
    }

    gpu::DevicePtr device_;
    Window& window_;
    gpu::Swapchain swapchain_;
    Interactive session_;
    Panels panels_;
    Controls controls_;
    std::optional<Script>& script_;
    ShaderWatch& shaders_;
    uint64_t frames_ = 0;
};

// `opened`: the device that was opened last. One that was chosen in the window and cannot be opened leaves that.
std::optional<Next> run_session(const OptionValues& values, Window& window, const Next& from, std::optional<std::string>& opened, std::optional<Script>& script, ShaderWatch& shaders) {
    std::optional<Session> session;
    try {
        session.emplace(values, window, from, script, shaders);
    } catch (const Error& error) {
        if (!opened || from.state.options.device == *opened) throw;
        log_line(LogLevel::Error, error.line);
        Next back{from.state, error.line};
        back.state.options.device = *opened;
        return back;
    }
    opened = from.state.options.device;
    return session->run();
}

int view(const OptionValues& values) {
    const RenderOptions options = read_view_options(values);
    for (const std::filesystem::path& file : options.output.files) check_writable(file);
    std::optional<Script> script;
    if (values.given("--script")) script.emplace(values.text("--script"));
    const auto variable = [](const char* name) { return std::string(std::getenv(name) ? std::getenv(name) : ""); };
    ShaderWatch shaders(variable("PARHELION_SHADER_DIR"), variable("PARHELION_SHADER_BUILD"));
    Window window(options.size, "Parhelion: " + escape_name(options.scene));
    std::optional<std::string> opened;
    std::optional<Next> next = Next{initial_state(options), ""};
    while (next) {
        const Next from = *next;
        next = run_session(values, window, from, opened, script, shaders);
    }
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
