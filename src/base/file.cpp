#include "base/file.h"

#include <atomic>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <memory>
#include <system_error>

#include "base/error.h"
#include "base/platform.h"

namespace parhelion {

namespace fs = std::filesystem;

namespace {

struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
};
using FileHandle = std::unique_ptr<std::FILE, CloseFile>;

std::string shown(const fs::path& path) { return escape_name(path.string()); }

[[noreturn]] void fail(const fs::path& path, std::string what, std::string hint = {}) {
    throw Error(ErrorCode::Failed, std::move(what), shown(path), std::move(hint));
}

fs::path folder_of(const fs::path& path) {
    const fs::path folder = path.parent_path();
    return folder.empty() ? fs::path(".") : folder;
}

std::string temporary_prefix(const fs::path& target) { return "." + target.filename().string() + ".partial-"; }

// Temporary files of processes that are gone (killed in the middle of a write) are swept by the next writer of the target.
void remove_leftovers(const fs::path& target) {
    std::error_code ignored;
    const std::string prefix = temporary_prefix(target);
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_of(target), ignored)) {
        const std::string name = entry.path().filename().string();
        if (name.rfind(prefix, 0) != 0) continue;
        uint64_t process = 0;
        std::from_chars(name.data() + prefix.size(), name.data() + name.size(), process);
        if (process != 0 && !platform::process_exists(process)) fs::remove(entry.path(), ignored);
    }
}

}  // namespace

std::vector<std::byte> read_file(const fs::path& path, uint64_t max_bytes) {
    const auto refuse_kind = [&](bool folder) { fail(path, folder ? "is a folder, not a file" : "is a pipe or device, not a regular file"); };
    std::error_code ec;
    const fs::file_status status = fs::status(path, ec);
    if (ec || status.type() == fs::file_type::not_found) fail(path, "there is no such file");
    // Asked before, because opening a device may do something, and after, because the name may stand for another file by then.
    if (status.type() != fs::file_type::regular) refuse_kind(status.type() == fs::file_type::directory);
    const platform::OpenedFile opened = platform::open_for_reading(path);
    const FileHandle file(opened.file);
    if (!file) fail(path, fmt::format("cannot be opened: {}", std::strerror(errno)));
    if (opened.kind != platform::FileKind::Regular) refuse_kind(opened.kind == platform::FileKind::Folder);
    const uint64_t size = opened.size;
    if (size > max_bytes) fail(path, fmt::format("is {} bytes large; the limit here is {}", size, max_bytes));
    std::vector<std::byte> bytes(size);
    if (size != 0 && std::fread(bytes.data(), 1, size, file.get()) != size) fail(path, "could not be read to its end");
    return bytes;
}

std::string read_text_file(const fs::path& path, uint64_t max_bytes) {
    const std::vector<std::byte> bytes = read_file(path, max_bytes);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

void check_writable(const fs::path& path) {
    std::error_code ec;
    if (path.filename().empty() || fs::is_directory(path, ec)) fail(path, "is a folder; an output needs a file name");
    const fs::path folder = folder_of(path);
    if (!fs::is_directory(folder, ec)) fail(path, fmt::format("the folder '{}' does not exist", shown(folder)), "create it first");
    const fs::file_status status = fs::status(path, ec);
    if (fs::exists(status) && !fs::is_regular_file(status)) fail(path, "is not a regular file", "choose another output name");
    AtomicFile probe(path);
    probe.write({});
}

AtomicFile::AtomicFile(fs::path target) : target_(std::move(target)) {
    static std::atomic<uint32_t> serial = 0;
    remove_leftovers(target_);
    temporary_ = folder_of(target_) / fmt::format("{}{}-{}", temporary_prefix(target_), platform::process_id(), serial++);
}

AtomicFile::~AtomicFile() {
    std::error_code ignored;
    if (!committed_) fs::remove(temporary_, ignored);
}

void AtomicFile::write(std::span<const std::byte> bytes) { write_parts({&bytes, 1}); }

void AtomicFile::write_parts(std::span<const std::span<const std::byte>> parts) {
    FileHandle file(std::fopen(temporary_.c_str(), "wb"));
    if (!file) fail(target_, fmt::format("cannot be written: {}", std::strerror(errno)), "choose a folder that you may write to");
    for (const std::span<const std::byte> bytes : parts)
        if (!bytes.empty() && std::fwrite(bytes.data(), 1, bytes.size(), file.get()) != bytes.size())
            fail(target_, fmt::format("writing failed: {}", std::strerror(errno)), "free some space or choose another folder");
    if (std::fclose(file.release()) != 0) fail(target_, fmt::format("writing failed: {}", std::strerror(errno)), "free some space or choose another folder");
}

void AtomicFile::commit() {
    if (!platform::sync_file(temporary_)) fail(target_, fmt::format("writing failed: {}", std::strerror(errno)), "free some space or choose another folder");
    std::error_code ec;
    fs::rename(temporary_, target_, ec);
    if (ec) fail(target_, "cannot be replaced: " + ec.message());
    committed_ = true;
}

void write_file(const fs::path& path, std::span<const std::byte> bytes) {
    AtomicFile file(path);
    file.write(bytes);
    file.commit();
}

void write_text_file(const fs::path& path, std::string_view text) { write_file(path, std::as_bytes(std::span(text))); }

}  // namespace parhelion
