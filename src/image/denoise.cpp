#include "image/denoise.h"

#include <array>
#include <cstdlib>
#include <initializer_list>
#include <new>
#include <type_traits>
#include <vector>

#include "base/error.h"
#include "base/platform.h"

namespace parhelion::image {

namespace {

// The part of the C API that is used, after "Open Image Denoise API" of the documentation. Enumerations are ints there.
struct OidnDevice;
struct OidnFilter;
constexpr int kDeviceCpu = 1, kFormatFloat3 = 3;
constexpr int kErrorNone = 0, kErrorOutOfMemory = 4;

constexpr const char* kWhere = "--denoise oidn";
constexpr const char* kGet = "install Open Image Denoise 2 (openimagedenoise.org), or set PARHELION_OIDN=/path/to/libOpenImageDenoise.so.2";

using Interleaved = std::vector<float>;  // [3 * pixel + channel]
using Names = std::array<const char*, 3>;
constexpr Names kColor{"R", "G", "B"}, kAlbedo{"albedo.R", "albedo.G", "albedo.B"}, kNormal{"normal.X", "normal.Y", "normal.Z"};

size_t channel_of(const ImageF& picture, const char* name) {
    const auto channel = picture.find_channel(name);
    PARHELION_CHECK(channel.has_value(), "a picture to denoise has no channel {}", name);
    return *channel;
}

Interleaved interleave(const ImageF& picture, const Names& names) {
    const size_t pixels = picture.pixel_count();
    Interleaved out(3 * pixels);
    for (size_t c = 0; c < 3; ++c) {
        const auto plane = picture.plane(channel_of(picture, names[c]));
        for (size_t i = 0; i < pixels; ++i) out[3 * i + c] = plane[i];
    }
    return out;
}

void store(const Interleaved& values, const Names& names, ImageF& picture) {
    for (size_t c = 0; c < 3; ++c) {
        const auto plane = picture.plane(channel_of(picture, names[c]));
        for (size_t i = 0; i < plane.size(); ++i) plane[i] = values[3 * i + c];
    }
}

}  // namespace

struct Denoiser::Library {
    OidnDevice* (*new_device)(int type) = nullptr;
    void (*commit_device)(OidnDevice*) = nullptr;
    void (*release_device)(OidnDevice*) = nullptr;
    int (*get_device_int)(OidnDevice*, const char* name) = nullptr;
    int (*get_device_error)(OidnDevice*, const char** message) = nullptr;
    OidnFilter* (*new_filter)(OidnDevice*, const char* type) = nullptr;
    void (*release_filter)(OidnFilter*) = nullptr;
    void (*set_image)(OidnFilter*, const char* name, void* data, int format, size_t width, size_t height, size_t offset, size_t pixel_stride, size_t row_stride) = nullptr;
    void (*set_bool)(OidnFilter*, const char* name, bool value) = nullptr;
    void (*commit_filter)(OidnFilter*) = nullptr;
    void (*execute_filter)(OidnFilter*) = nullptr;

    std::string name, version;
    OidnDevice* device = nullptr;

    ~Library() {
        if (device) release_device(device);
    }
    void load();
    void find_functions(void* handle);
    void open_device();
    void check(const ImageF& picture) const;

    // One filter "RT" over images of the picture's size.
    struct Input {
        const char* name;
        const Interleaved& values;
    };
    Interleaved filter(const ImageF& picture, std::initializer_list<Input> inputs, std::initializer_list<const char*> flags) const;
};

void Denoiser::Library::load() {
    const char* own = std::getenv("PARHELION_OIDN");
    if (own && *own) {
        name = own;
        void* handle = platform::load_library(name);
        if (!handle) throw Error(ErrorCode::Failed, "the library cannot be loaded", escape_name(name), "PARHELION_OIDN names the file libOpenImageDenoise.so.2 of Open Image Denoise 2, beside the files it came with");
        return find_functions(handle);
    }
    // A development package has the name without a version too, which may be of any.
    for (const char* usual : {"libOpenImageDenoise.so.2", "libOpenImageDenoise.so"}) {
        name = usual;
        if (void* handle = platform::load_library(name)) return find_functions(handle);
    }
    throw Error(ErrorCode::Failed, "the library libOpenImageDenoise.so.2 is not found", kWhere, kGet);
}

void Denoiser::Library::find_functions(void* handle) {
    if (!platform::library_symbol(handle, "oidnNewDevice"))
        throw Error(ErrorCode::Failed, "this library is not Open Image Denoise", escape_name(name), kGet);
    const auto find = [&](auto& function, const char* symbol) {
        function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(platform::library_symbol(handle, symbol));
        if (!function) throw Error(ErrorCode::Failed, fmt::format("this Open Image Denoise is older than version 2: it has no {}", symbol), escape_name(name), kGet);
    };
    find(new_device, "oidnNewDevice");
    find(commit_device, "oidnCommitDevice");
    find(release_device, "oidnReleaseDevice");
    find(get_device_int, "oidnGetDeviceInt");
    find(get_device_error, "oidnGetDeviceError");
    find(new_filter, "oidnNewFilter");
    find(release_filter, "oidnReleaseFilter");
    find(set_image, "oidnSetSharedFilterImage");
    find(set_bool, "oidnSetFilterBool");
    find(commit_filter, "oidnCommitFilter");
    find(execute_filter, "oidnExecuteFilter");
}

void Denoiser::Library::open_device() {
    device = new_device(kDeviceCpu);
    if (device) commit_device(device);
    const char* message = nullptr;
    if (const int error = get_device_error(device, &message); !device || error != kErrorNone)
        throw Error(ErrorCode::Failed, fmt::format("Open Image Denoise cannot use this CPU: {}", message ? escape_name(message) : "it does not say why"), escape_name(name),
                    "leave --denoise oidn out");
    version = fmt::format("{}.{}.{}", get_device_int(device, "versionMajor"), get_device_int(device, "versionMinor"), get_device_int(device, "versionPatch"));
}

void Denoiser::Library::check(const ImageF& picture) const {
    const char* message = nullptr;
    const int error = get_device_error(device, &message);
    if (error == kErrorNone) return;
    if (error == kErrorOutOfMemory) throw std::bad_alloc();
    throw Error(ErrorCode::Failed, fmt::format("Open Image Denoise failed on {}x{} pixels: {}", picture.width, picture.height, message ? escape_name(message) : "it does not say why"), kWhere,
                "leave it out");
}

Interleaved Denoiser::Library::filter(const ImageF& picture, std::initializer_list<Input> inputs, std::initializer_list<const char*> flags) const {
    Interleaved output(3 * picture.pixel_count());
    const auto release = [this](OidnFilter* filter) { release_filter(filter); };
    const std::unique_ptr<OidnFilter, decltype(release)> rt(new_filter(device, "RT"), release);
    check(picture);
    const auto set = [&](const char* image, const float* values) {
        set_image(rt.get(), image, const_cast<float*>(values), kFormatFloat3, picture.width, picture.height, 0, 0, 0);  // inputs are only read
    };
    for (const Input& input : inputs) set(input.name, input.values.data());
    set("output", output.data());
    for (const char* flag : flags) set_bool(rt.get(), flag, true);
    commit_filter(rt.get());
    check(picture);
    execute_filter(rt.get());
    check(picture);
    return output;
}

Denoiser::Denoiser() : library_(std::make_unique<Library>()) {
    library_->load();
    library_->open_device();
}
Denoiser::~Denoiser() = default;

const std::string& Denoiser::version() const { return library_->version; }
const std::string& Denoiser::library() const { return library_->name; }

void Denoiser::denoise(ImageF& picture) const {
    try {
        // "Prefiltering" of the documentation: guides without noise of their own let the filter keep all of their detail.
        const Interleaved albedo = library_->filter(picture, {{"albedo", interleave(picture, kAlbedo)}}, {});
        const Interleaved normal = library_->filter(picture, {{"normal", interleave(picture, kNormal)}}, {});
        const Interleaved color = library_->filter(picture, {{"color", interleave(picture, kColor)}, {"albedo", albedo}, {"normal", normal}}, {"hdr", "cleanAux"});
        store(color, kColor, picture);
    } catch (const std::bad_alloc&) {
        throw Error(ErrorCode::Failed, fmt::format("there is not enough memory to denoise {}x{} pixels", picture.width, picture.height), kWhere, "choose a smaller --size, or leave it out");
    }
}

}  // namespace parhelion::image
