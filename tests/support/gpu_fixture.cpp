#include "support/gpu_fixture.h"

#include <cstdlib>
#include <filesystem>

#include "base/error.h"
#include "base/file.h"
#include "base/log.h"

namespace parhelion::embedded {
extern const unsigned char test_shaders[];
extern const size_t test_shaders_size;
}  // namespace parhelion::embedded

namespace parhelion::testing {

namespace {

bool environment_lists(const char* variable, std::string_view what) {
    const char* list = std::getenv(variable);
    if (!list) return false;
    std::string_view rest = list;
    while (!rest.empty()) {
        const size_t comma = rest.find(',');
        if (rest.substr(0, comma) == what) return true;
        rest = comma == std::string_view::npos ? std::string_view() : rest.substr(comma + 1);
    }
    return false;
}

struct SharedDevice {
    gpu::DevicePtr device;
    bool validates = false;
};

const SharedDevice& open_shared_device() {
    static const SharedDevice shared = []() -> SharedDevice {
        try {
            return {gpu::Device::open({.validate = true}), true};
        } catch (const Error& error) {
            log(LogLevel::Warn, "{}", error.what());
            if (is_required("validation")) return {};
        }
        try {
            return {gpu::Device::open({}), false};
        } catch (const Error& error) {
            log(LogLevel::Warn, "{}", error.what());
            return {};
        }
    }();
    return shared;
}

}  // namespace

bool is_required(std::string_view what) { return environment_lists("PARHELION_REQUIRE", what) && !environment_lists("PARHELION_MASK", what); }

const gpu::DevicePtr& shared_device() { return open_shared_device().device; }
bool shared_device_validates() { return open_shared_device().validates; }

const gpu::ShaderPack& test_shader_pack() {
    // Seeded bugs bring their own (tests/seeded/run.sh).
    static const gpu::ShaderPack pack = [] {
        constexpr uint64_t kMaxBytes = 64 << 20;
        const char* folder = std::getenv("PARHELION_SHADER_DIR");
        const std::filesystem::path file = folder ? std::filesystem::path(folder) / "test_shaders.pack" : std::filesystem::path();
        if (folder && std::filesystem::exists(file)) return gpu::ShaderPack(read_file(file, kMaxBytes));
        return gpu::ShaderPack(std::as_bytes(std::span(embedded::test_shaders, embedded::test_shaders_size)));
    }();
    return pack;
}

void GpuTest::SetUp() {
    if (!shared_device()) {
        if (is_required("device")) FAIL() << "PARHELION_REQUIRE names a device, and there is none (see the messages above)";
        GTEST_SKIP() << "no Vulkan device";
    }
    messages_before_ = shared_device()->validation_message_count();
    // Tests go through the ways that the device has: without this, a required one that is not there would go unseen.
    for (const gpu::TraceWay way : {gpu::TraceWay::Pipeline, gpu::TraceWay::Query})
        if (!device()->caps().supports(way) && is_required(gpu::trace_way_name(way)))
            FAIL() << device()->caps().name << " cannot trace by " << gpu::trace_way_name(way) << ", which PARHELION_REQUIRE names";
}

void GpuTest::TearDown() {
    if (shared_device()) {
        EXPECT_EQ(shared_device()->validation_message_count(), messages_before_) << "the validation layers were not silent";
    }
}

void GpuTest::require_way(gpu::TraceWay way) {
    if (device()->caps().supports(way)) return;
    GTEST_SKIP() << device()->caps().name << " cannot trace by " << gpu::trace_way_name(way);
}

}  // namespace parhelion::testing
