// A .gltf: JSON text, with its buffers and images as data: URIs. gltf.dict holds the words of glTF.
#include <cstdint>

#include "fuzz_scene.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    parhelion::fuzz::load(std::as_bytes(std::span(data, size)));
    return 0;
}
