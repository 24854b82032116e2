#include "session/shader_watch.h"

#include "base/error.h"
#include "base/file.h"

namespace parhelion {

namespace {

constexpr std::chrono::milliseconds kLookOften(250);
constexpr uint64_t kMostPackBytes = 256ull << 20;

std::filesystem::file_time_type written_at(const std::filesystem::path& file) {
    std::error_code none;
    return std::filesystem::last_write_time(file, none);
}

// What a person wants to read of a compiler's output.
std::string first_error(const std::string& output) {
    std::string first;
    for (size_t begin = 0; begin < output.size();) {
        const size_t end = std::min(output.find('\n', begin), output.size());
        const std::string line = output.substr(begin, end - begin);
        if (line.find("error:") != std::string::npos) return line;
        if (first.empty()) first = line;
        begin = end + 1;
    }
    return first.empty() ? "it said nothing" : first;
}

}  // namespace

ShaderWatch::ShaderWatch(std::filesystem::path folder, std::string build_line) : build_line_(std::move(build_line)) {
    if (folder.empty()) return;
    file_ = folder / "shaders.pack";
    seen_ = written_at(file_);
}

void ShaderWatch::build() {
    if (file_.empty() || build_line_.empty())
        throw Error(ErrorCode::Usage, "there is nothing to build the shaders with", "F6", "start the viewer by ./dev view, or set PARHELION_SHADER_DIR and PARHELION_SHADER_BUILD");
    if (!is_building()) building_ = std::async(std::launch::async, platform::run_command, build_line_);
}

std::shared_ptr<const gpu::ShaderPack> ShaderWatch::poll() {
    if (file_.empty()) return nullptr;
    if (is_building()) {
        if (building_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return nullptr;
        const platform::CommandResult result = building_.get();
        if (result.exit_code != 0) throw Error(ErrorCode::Usage, escape_name(first_error(result.output)), "shaders", "the old ones stay");
    } else if (std::chrono::steady_clock::now() - looked_at_ < kLookOften) {
        return nullptr;
    }
    looked_at_ = std::chrono::steady_clock::now();
    const auto now = written_at(file_);
    if (now == seen_) return nullptr;
    seen_ = now;
    try {
        return std::make_shared<gpu::ShaderPack>(read_file(file_, kMostPackBytes));
    } catch (const Error& error) {
        throw Error(ErrorCode::Usage, error.problem, error.where, "the old shaders stay");
    }
}

}  // namespace parhelion
