#pragma once
// What becomes of each glTF extension that a file names.
#include <cstdint>
#include <string_view>

namespace parhelion {

enum class ExtensionUse : uint8_t {
    Read,      // what it says is in the Scene; what of that is not drawn, SceneInfo tells from the scene itself, or the reader (GltfDocument::leave_out)
    Harmless,  // says nothing about the picture
    Unknown,   // required: an error; only used: a warning
};

ExtensionUse extension_use(std::string_view name);

}  // namespace parhelion
