#pragma once
// Intel Open Image Denoise 2, a shared library of the user's: loaded at run time, never needed to build. On the CPU, so that a picture does
// not depend on the GPU. Its documentation: https://www.openimagedenoise.org/documentation.html
#include <memory>
#include <string>

#include "image/image.h"

namespace parhelion::image {

class Denoiser {
public:
    // Loads PARHELION_OIDN (a file) or, if that is not set, libOpenImageDenoise.so.2 from where the loader looks. Throws Error for a library
    // that is not there, is another one or version 1, and for a CPU that it cannot run on.
    Denoiser();
    ~Denoiser();
    Denoiser(const Denoiser&) = delete;
    Denoiser& operator=(const Denoiser&) = delete;

    const std::string& version() const;  // "2.5.1"
    const std::string& library() const;  // the name that was loaded

    // R, G, B without their noise: linear light in any unit. albedo.R, .G, .B and normal.X, .Y, .Z of the first surface guide it; they are
    // freed of their own noise first, in copies. All other channels stay. Throws Error if memory is short; the picture is then as it was.
    // May run in several threads at once, each with a Denoiser of its own.
    void denoise(ImageF& picture) const;

private:
    struct Library;
    std::unique_ptr<Library> library_;
};

}  // namespace parhelion::image
