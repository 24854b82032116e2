#pragma once
// A Scene to glTF 2.0: .glb, or .gltf with F.bin and its images beside it. Section numbers in gltf_write*.cpp are those of the glTF 2.0
// specification (Khronos, version 2.0.1).
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace parhelion {

struct GltfWriteOptions {
    std::string generator = "Parhelion";
    uint64_t max_glb_bytes = 0xFFFFFFFFull;  // what the container's 32-bit length can say (4.4.2)
};

struct GltfWritten {
    std::vector<std::filesystem::path> files;  // the one that was asked for comes last
    uint64_t bytes = 0;                        // of all of them
    std::vector<std::string> warnings;         // what glTF cannot say and is therefore not in the file, each text once
};

bool is_gltf_name(const std::filesystem::path& path);  // ends in .glb or .gltf

// Writes the scene at rest: instances show their own meshes, not the posed ones; animations, skins and morph targets are written as
// such. Numbers keep every bit, so that read_gltf (in the file's order of triangles) gives the same scene and writing that gives the
// same bytes. What stands on no node, or beside another of its kind on one node, gets a nameless node of its own.
//
// The extension of `path` chooses the form. All files appear whole or none does. Beside F.gltf come F.bin and F-NAME.png (.jpg ...);
// one that is there already is replaced only if F.gltf is replaced too. Throws Error where a file cannot be written, a GLB would be
// too large, or an image of compressed blocks has no file to be written as.
GltfWritten write_gltf(const Scene& scene, const std::filesystem::path& path, const GltfWriteOptions& options = {});

// The bytes of a .glb.
std::vector<std::byte> write_glb(const Scene& scene, const GltfWriteOptions& options = {}, std::vector<std::string>* warnings = nullptr);

}  // namespace parhelion
