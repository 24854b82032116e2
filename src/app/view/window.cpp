#include "app/view/window.h"

#include <algorithm>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "base/error.h"

// GLFW declares this only beside Vulkan's own header, which only src/gpu includes.
extern "C" int glfwCreateWindowSurface(VkInstance instance, GLFWwindow* window, const void* allocator, VkSurfaceKHR* surface);

namespace parhelion::view {

namespace {

constexpr const char* kNoWindowHint = "a window needs a display (X11: the variable DISPLAY); parhelion render needs none";

std::string last_problem(const char* otherwise = "the display does not answer") {
    const char* text = nullptr;
    glfwGetError(&text);
    return text ? escape_name(text) : otherwise;
}

}  // namespace

Window::Window(Size2 size, const std::string& title) {
    if (!glfwInit()) throw Error(ErrorCode::MissingFeature, "no window can be opened: " + last_problem(), "display", kNoWindowHint);
    glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
    window_ = glfwCreateWindow(static_cast<int>(size.width), static_cast<int>(size.height), title.c_str(), nullptr, nullptr);
    if (!window_) {
        const std::string problem = last_problem();
        glfwTerminate();
        throw Error(ErrorCode::MissingFeature, "no window can be opened: " + problem, "display", kNoWindowHint);
    }
    glfwSetWindowUserPointer(window_, this);
    glfwSetKeyCallback(window_, [](GLFWwindow* handle, int key, int, int action, int) {
        const auto* window = static_cast<Window*>(glfwGetWindowUserPointer(handle));
        if (action != GLFW_RELEASE && window->on_key) window->on_key(key);
    });
    glfwSetDropCallback(window_, [](GLFWwindow* handle, int count, const char** files) {
        const auto* window = static_cast<Window*>(glfwGetWindowUserPointer(handle));
        if (window->on_drop) window->on_drop({files, files + count});
    });
}

Window::~Window() {
    glfwDestroyWindow(window_);
    glfwTerminate();
}

std::vector<std::string> Window::instance_extensions() const {
    uint32_t count = 0;
    const char** names = glfwGetRequiredInstanceExtensions(&count);
    if (!names) throw Error(ErrorCode::MissingFeature, "Vulkan cannot draw to windows here: " + last_problem("no driver knows this display"), "Vulkan", "install a Vulkan driver (./dev brings one for the CPU)");
    return {names, names + count};
}

VkSurfaceKHR Window::make_surface(VkInstance instance) const {
    VkSurfaceKHR surface = nullptr;
    return glfwCreateWindowSurface(instance, window_, nullptr, &surface) == 0 ? surface : nullptr;
}

Size2 Window::size() const {
    int width = 0, height = 0;
    // X11 leaves a minimised window its size.
    if (glfwGetWindowAttrib(window_, GLFW_ICONIFIED) == 0) glfwGetFramebufferSize(window_, &width, &height);
    return {static_cast<uint32_t>(width), static_cast<uint32_t>(height)};
}

void Window::resize(Size2 size) { glfwSetWindowSize(window_, static_cast<int>(size.width), static_cast<int>(size.height)); }
void Window::set_title(const std::string& title) { glfwSetWindowTitle(window_, title.c_str()); }
void Window::poll() { glfwPollEvents(); }
void Window::wait(double seconds) { glfwWaitEventsTimeout(seconds); }
bool Window::is_closing() const { return glfwWindowShouldClose(window_) != 0; }
void Window::close() { glfwSetWindowShouldClose(window_, GLFW_TRUE); }
bool Window::is_down(int key) const { return glfwGetKey(window_, key) == GLFW_PRESS; }

void Window::copy(const std::string& text) { glfwSetClipboardString(window_, text.c_str()); }

glm::uvec2 Window::pointer() const {
    double x = 0, y = 0;
    int width = 1, height = 1;
    glfwGetCursorPos(window_, &x, &y);
    glfwGetWindowSize(window_, &width, &height);
    const Size2 pixels = size();
    const auto place = [](double at, int extent, uint32_t count) { return static_cast<uint32_t>(std::clamp(at / std::max(1, extent) * count, 0.0, std::max(1.0, double(count)) - 1)); };
    return {place(x, width, pixels.width), place(y, height, pixels.height)};
}

float Window::panel_scale() const {
    float x = 1, y = 1;
    int width = 0, height = 0;
    glfwGetWindowContentScale(window_, &x, &y);
    glfwGetWindowSize(window_, &width, &height);
    return static_cast<uint32_t>(width) == size().width ? std::max(1.0f, x) : 1.0f;
}

}  // namespace parhelion::view
