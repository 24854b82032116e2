// A library with the functions of Open Image Denoise 2 that image/denoise.cpp calls; what it does can be told from outside:
//     guides alone     are moved up by a 64th, so that prefiltered ones are known
//     colours          R becomes half of itself, G the first guide's first value, B the second guide's second
// It refuses (kInvalid) anything but the documented order of calls. STUB_FAILS=device, memory or filter makes it fail; STUB_IS_VERSION_1
// leaves out what only version 2 has. STUB_SECONDS is how long a filter takes.
#include <chrono>
#include <cstdlib>
#include <map>
#include <string>
#include <thread>

namespace {

constexpr int kNone = 0, kUnknown = 1, kInvalid = 3, kOutOfMemory = 4, kUnsupported = 5;

struct Device {
    bool committed = false;
    int error = kNone;
    const char* message = nullptr;
};

struct Filter {
    Device* device;
    bool committed = false;
    std::map<std::string, float*> images = {};
    std::map<std::string, bool> flags = {};
    size_t values = 0;
};

bool fails(const char* what) {
    const char* wanted = std::getenv("STUB_FAILS");
    return wanted && std::string(wanted) == what;
}

void set_error(Device* device, int error, const char* message) {
    device->error = error;
    device->message = message;
}

}  // namespace

extern "C" {

Device* oidnNewDevice(int type) { return type == 1 ? new Device : nullptr; }
void oidnReleaseDevice(Device* device) { delete device; }
void oidnCommitDevice(Device* device) {
    device->committed = true;
    if (fails("device")) set_error(device, kUnsupported, "this machine is not good enough");
}
int oidnGetDeviceError(Device* device, const char** message) {
    const int error = device ? device->error : kUnknown;
    if (error != kNone) *message = device ? device->message : "there is no device";
    if (device) device->error = kNone;
    return error;
}

#ifndef STUB_IS_VERSION_1
int oidnGetDeviceInt(Device*, const char* name) {
    const std::string what = name;
    return what == "versionMajor" ? 2 : what == "versionMinor" ? 34 : what == "versionPatch" ? 5 : -1;
}

Filter* oidnNewFilter(Device* device, const char* type) {
    if (device->committed && std::string(type) == "RT") return new Filter{device};
    set_error(device, kInvalid, "no such filter, or an uncommitted device");
    return nullptr;
}
void oidnReleaseFilter(Filter* filter) { delete filter; }
void oidnSetSharedFilterImage(Filter* filter, const char* name, void* data, int format, size_t width, size_t height, size_t offset, size_t pixel_stride, size_t row_stride) {
    if (format != 3 || offset != 0 || pixel_stride != 0 || row_stride != 0) set_error(filter->device, kInvalid, "images are packed float3");
    filter->images[name] = static_cast<float*>(data);
    filter->values = 3 * width * height;
}
void oidnSetFilterBool(Filter* filter, const char* name, bool value) { filter->flags[name] = value; }
void oidnCommitFilter(Filter* filter) { filter->committed = true; }

void oidnExecuteFilter(Filter* filter) {
    if (const char* seconds = std::getenv("STUB_SECONDS")) std::this_thread::sleep_for(std::chrono::duration<double>(std::atof(seconds)));
    if (fails("memory")) return set_error(filter->device, kOutOfMemory, "out of memory");
    if (fails("filter")) return set_error(filter->device, kUnknown, "something\nunexpected");
    const auto& images = filter->images;
    if (!filter->committed || !images.contains("output")) return set_error(filter->device, kInvalid, "not committed, or no output");
    float* output = images.at("output");
    if (!images.contains("color")) {
        if (images.size() != 2 || !filter->flags.empty()) return set_error(filter->device, kInvalid, "a guide is filtered alone");
        const float* guide = images.contains("albedo") ? images.at("albedo") : images.at("normal");
        for (size_t i = 0; i < filter->values; ++i) output[i] = guide[i] + 1.0f / 64.0f;
        return;
    }
    if (!filter->flags["hdr"] || !filter->flags["cleanAux"]) return set_error(filter->device, kInvalid, "light needs hdr, prefiltered guides cleanAux");
    for (size_t i = 0; i < filter->values; i += 3) {
        output[i] = images.at("color")[i] / 2;
        output[i + 1] = images.at("albedo")[i];
        output[i + 2] = images.at("normal")[i + 1];
    }
}
#endif

}  // extern "C"
