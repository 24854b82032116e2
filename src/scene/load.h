#pragma once
// The front door: a scene or an environment from what the user names.
#include <filesystem>
#include <string>

#include "scene/builtin.h"
#include "scene/scene_files.h"

namespace parhelion {

struct LoadOptions {
    SceneFileLimits limits;
    bool median_order = true;
    bool keep_encoded = false;  // images keep the files that they were decoded from (Image::encoded)
    std::string variant;        // material variant of a file; empty: the file's own materials
    std::string animation;      // name or index of the file's animation to play; empty: all that do not move the same things
    std::string animate;        // scripted edit of a built-in scene; empty: none
    bool at_rest = false;       // leave a file's scene unposed: no animation is evaluated, no instance has a posed mesh
    double time = 0;            // seconds at which animations and scripted edits stand
    BuiltinOptions builtin;
};

// "builtin:NAME", or a .gltf or .glb file (told apart by content). Warnings of the file go to the log and into scene.source().
LoadedScene load_scene(const std::string& name, const LoadOptions& options = {});

// What brings a loaded scene to another moment: the scripted edit that the options name, or the animations of a file. Throws as
// load_scene() does.
SceneEdit state_at(const LoadedScene& loaded, const LoadOptions& options, double seconds);

// An equirectangular .hdr or .exr (also .png and .jpg, as sRGB) with scale 1 and no rotation. Values that are negative or not
// finite are made 0 or the largest half float, with a warning.
Environment load_environment(const std::filesystem::path& path);

}  // namespace parhelion
