#pragma once
// The window, by GLFW.
#include <functional>
#include <string>
#include <vector>

#include <glm/vec2.hpp>

#include "base/parse.h"
#include "gpu/vulkan_handles.h"

struct GLFWwindow;

namespace parhelion::view {

class Window {
public:
    // `size` in pixels of the framebuffer, as near as the display allows. Throws MissingFeature where no window can be opened.
    Window(Size2 size, const std::string& title);
    ~Window();
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    GLFWwindow* handle() const { return window_; }
    // What a Vulkan instance must be made with, and the surface of the window for one; null: it cannot be made.
    std::vector<std::string> instance_extensions() const;
    VkSurfaceKHR make_surface(VkInstance instance) const;

    Size2 size() const;  // of the framebuffer in pixels; 0x0: minimised
    void resize(Size2 size);
    void set_title(const std::string& title);
    void poll();                 // takes in what has happened
    void wait(double seconds);   // until something happens, at most so long
    bool is_closing() const;
    void close();
    bool is_down(int key) const;  // GLFW_KEY_...
    glm::uvec2 pointer() const;   // pixel of the framebuffer, inside it
    // How much larger than usual panels must be for the display's many pixels; 1 where the window system enlarges by itself.
    float panel_scale() const;
    void copy(const std::string& text);  // to the clipboard
    std::function<void(int key)> on_key;  // pressed, also again and again while it is held
    std::function<void(const std::vector<std::string>& files)> on_drop;

private:
    GLFWwindow* window_ = nullptr;
};

}  // namespace parhelion::view
