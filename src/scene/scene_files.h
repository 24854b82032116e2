#pragma once
// SceneFiles: every file that a scene names is read through one of these. Files come from anywhere, so their URIs may not leave the
// scene's folder or name a protocol, and all memory that a scene asks for is counted before it is allocated.
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace parhelion {

struct SceneFileLimits {
    bool allow_external = false;              // lets URIs leave the folder; protocols stay refused
    uint64_t max_file_bytes = 64ull << 30;    // of one file
    uint64_t budget_base_bytes = 1ull << 30;  // the memory budget is base + factor x bytes of all files read:
    uint64_t budget_factor = 64;              // what compression and sparse data may legally unfold to, and no more
};

class SceneFiles {
public:
    using Bytes = std::shared_ptr<const std::vector<std::byte>>;

    // `root`: the folder that URIs are relative to. Empty: no file may be read (scenes in memory).
    explicit SceneFiles(std::filesystem::path root, const SceneFileLimits& limits = {});

    // The main file, named by the user: any regular file.
    Bytes read_main(const std::filesystem::path& path);

    // What a URI names: a file below the root (percent-decoded; read once however often it is named) or the bytes of a data: URI.
    // `where` goes into the Error. Throws for absolute paths, `..` or links out of the root, protocols, anything but regular files,
    // files that are too large, and base64 that is not.
    Bytes read_uri(std::string_view uri, std::string_view where);

    // Counts memory that is about to be allocated; throws Error when the budget is exceeded. Safe to call from several threads.
    void charge(uint64_t bytes, std::string_view where);

    uint64_t bytes_read() const { return bytes_read_; }
    uint64_t bytes_charged() const { return charged_; }
    uint64_t budget_left() const;

private:
    std::filesystem::path resolve(std::string_view uri, std::string_view where) const;
    Bytes read_counted(const std::filesystem::path& path, std::string_view where);

    std::filesystem::path root_;
    SceneFileLimits limits_;
    std::map<std::filesystem::path, Bytes> cache_;
    std::atomic<uint64_t> bytes_read_ = 0, charged_ = 0;
};

bool is_data_uri(std::string_view uri);
// The bytes of a data: URI (base64 or percent-encoded). Throws Error for broken base64.
std::vector<std::byte> decode_data_uri(std::string_view uri, std::string_view where);
std::string percent_decode(std::string_view text);  // sequences that are none stay as they are

}  // namespace parhelion
