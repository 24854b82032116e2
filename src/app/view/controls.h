#pragma once
// What mouse, keys and dropped files mean.
#include <optional>

#include "app/view/panels.h"
#include "session/options.h"
#include "session/shader_watch.h"

namespace parhelion::view {

class Controls {
public:
    // The window's keys and files come here from now on. `given`: the options that the program was started with.
    Controls(const OptionValues& given, Window& window, Interactive& session, Panels& panels, ShaderWatch& shaders);
    ~Controls();
    Controls(const Controls&) = delete;
    Controls& operator=(const Controls&) = delete;

    // Between two frames: moves the camera by what the mouse and held keys say, and does what panels ask for.
    void steer(const Panels::Input& input);
    // Writes the picture where --out says, else beside the caller under the scene's name.
    void save();
    // The line that draws this picture: to the clipboard and to stdout. The realtime renderer begins anew, so that its frames are those of the line.
    void copy();
    void open(const std::string& file);  // a preset (.json), an environment (.hdr, .exr), else a scene
    void look_at(glm::uvec2 pixel);      // what is seen there
    void build_shaders();
    // Writes the window as it is after the next frame; empty: under the scene's name.
    void shoot(const std::filesystem::path& file = {});
    std::filesystem::path take_shot() { return std::exchange(shot_, {}); }  // the file that is waited for, if there is one

private:
    void press(int key);
    void next_camera();
    void move_line(float by);
    void write_preset();
    void poll_shaders();
    std::filesystem::path free_name(const char* pattern) const;

    const OptionValues& given_;
    Window& window_;
    Interactive& session_;
    Panels& panels_;
    ShaderWatch& shaders_;
    size_t camera_ = 0;
    bool keys_ = true;   // are not for a panel
    bool looks_ = false; // at what the pixel that is looked into shows
    std::filesystem::path shot_;
};

}  // namespace parhelion::view
