#pragma once
// A camera for any scene that moves along keys (`--camera-path F.json`, docs/camera.md).
#include <filesystem>
#include <string>
#include <vector>

#include "scene/camera.h"

namespace parhelion {

struct CameraKey {
    double time = 0;  // seconds
    glm::dvec3 look_from{0.0}, look_at{0.0};
    double yfov = 0.8;  // radians
};

struct CameraPath {
    std::string file;             // as errors show it
    std::vector<CameraKey> keys;  // times increase; not empty

    // Position, target and angle go evenly from key to key; before the first and after the last key the camera stands still.
    // Throws Error where it would look at the point where it stands.
    CameraView view_at(double seconds) const;
};

// Throws Error, with file, place and expectation, for whatever is not such a file.
CameraPath read_camera_path(const std::filesystem::path& file);
// The same from text. `name` stands for the file in errors.
CameraPath parse_camera_path(std::string_view text, std::string name);

}  // namespace parhelion
