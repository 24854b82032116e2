#pragma once
// What reconstruction got of a frame as layers of an EXR, and what belongs to them in words. docs/reconstruction.md, "From files", is for who
// reads them.
#include <nlohmann/json_fwd.hpp>

#include "image/image.h"
#include "renderers/kept_input.h"

namespace parhelion {

inline constexpr const char* kReconstructionAttribute = "reconstruction";  // its text: input_json()
inline constexpr uint32_t kReconstructionLayout = 1;  // goes up when a layer or a word is no longer what it was

// Size, exposure, jitter, cut, and both cameras.
nlohmann::ordered_json input_json(const InputReadback& input);
// The layers go into a picture of the input's size, and the words into its attribute.
void add_reconstruction_layers(const InputReadback& input, image::ImageF& picture);

}  // namespace parhelion
