#include "app/view/window.h"

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
    glfwGetFramebufferSize(window_, &width, &height);
    return {static_cast<uint32_t>(width), static_cast<uint32_t>(height)};
}

void Window::resize(Size2 size) { glfwSetWindowSize(window_, static_cast<int>(size.width), static_cast<int>(size.height)); }
void Window::set_title(const std::string& title) { glfwSetWindowTitle(window_, title.c_str()); }
void Window::poll() { glfwPollEvents(); }
void Window::wait(double seconds) { glfwWaitEventsTimeout(seconds); }
bool Window::is_closing() const { return glfwWindowShouldClose(window_) != 0; }
void Window::close() { glfwSetWindowShouldClose(window_, GLFW_TRUE); }
bool Window::is_down(int key) const { return glfwGetKey(window_, key) == GLFW_PRESS; }

}  // namespace parhelion::view
