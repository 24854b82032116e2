#pragma once
// Runs the built program as a process, as a user or a farm does.
#include <chrono>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace parhelion::testing {

struct ProcessResult {
    int exit_code = -1;  // -1: ended by a signal
    int signal = 0;
    std::string out, err;
    double seconds_after_signal = 0;

    nlohmann::json json() const { return nlohmann::json::parse(out, nullptr, false); }
};

struct ProcessOptions {
    std::map<std::string, std::string> environment;                // added to the test's own
    std::filesystem::path folder;                                  // working folder; empty: the test's own
    std::string stdout_file;                                       // instead of capturing stdout
    std::optional<uint64_t> file_size_limit;                       // a write beyond it fails (EFBIG), like on a full disk
    std::function<bool(const ProcessResult& so_far)> signal_when;  // polled; when true, `signal` is sent
    int signal = 0;
    int signal_count = 1;  // with 50 ms between two
};

// The program `parhelion` of this build.
ProcessResult run_parhelion(const std::vector<std::string>& arguments, const ProcessOptions& options = {});

// A folder that is removed with everything in it.
class TemporaryFolder {
public:
    TemporaryFolder();
    ~TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    const std::filesystem::path& path() const { return path_; }
    std::string file(const std::string& name) const { return (path_ / name).string(); }
    std::vector<std::string> names() const;  // sorted, hidden ones included

private:
    std::filesystem::path path_;
};

std::string read_bytes(const std::filesystem::path& file);  // "" if it is not there

}  // namespace parhelion::testing
