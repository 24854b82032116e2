#pragma once
// Files: whole reads with a limit, and writes that are either complete or not there.
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace parhelion {

// Reads a regular file whole. Throws Error if it is missing, not a regular file (pipe, device, folder), or over max_bytes.
std::vector<std::byte> read_file(const std::filesystem::path& path, uint64_t max_bytes);
std::string read_text_file(const std::filesystem::path& path, uint64_t max_bytes);

// Throws a clear Error unless a file can be created at `path` (folder exists and is writable, target is no folder).
// Called for every output before the first sample is taken.
void check_writable(const std::filesystem::path& path);

// A file that appears whole or not at all: written under a temporary name beside the target, renamed by commit().
// Without commit() nothing is left behind. A leftover of a killed process is removed by the next write to the same target.
class AtomicFile {
public:
    explicit AtomicFile(std::filesystem::path target);
    ~AtomicFile();
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    // Where a writer that wants a path of its own (OpenEXR) writes.
    const std::filesystem::path& temporary_path() const { return temporary_; }
    void write(std::span<const std::byte> bytes);  // creates or replaces the temporary file
    void write_parts(std::span<const std::span<const std::byte>> parts);  // likewise, one part after the other
    void commit();                                 // flushes to disk and renames; throws Error, then nothing is left

private:
    std::filesystem::path target_, temporary_;
    bool committed_ = false;
};

void write_file(const std::filesystem::path& path, std::span<const std::byte> bytes);  // atomic
void write_text_file(const std::filesystem::path& path, std::string_view text);        // atomic

}  // namespace parhelion
