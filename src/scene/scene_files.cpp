#include "scene/scene_files.h"

#include <algorithm>
#include <array>
#include <limits>

#include "base/error.h"
#include "base/file.h"
#include "base/platform.h"

namespace parhelion {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void fail(std::string_view where, std::string what, std::string hint = {}) {
    throw Error(ErrorCode::Failed, std::move(what), std::string(where), std::move(hint));
}

int hex_digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

bool starts_with_ignoring_case(std::string_view text, std::string_view lower) {
    if (text.size() < lower.size()) return false;
    return std::equal(lower.begin(), lower.end(), text.begin(),
                      [](char a, char b) { return a == (b >= 'A' && b <= 'Z' ? b + ('a' - 'A') : b); });
}

// RFC 3986: a letter, then letters, digits, "+", "-", ".", up to a colon that comes before any slash.
bool has_protocol(std::string_view uri) {
    const size_t colon = uri.find(':');
    if (colon == std::string_view::npos || colon == 0) return false;
    const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
    if (!letter(uri[0])) return false;
    return std::all_of(uri.begin(), uri.begin() + static_cast<std::ptrdiff_t>(colon),
                       [&](char c) { return letter(c) || (c >= '0' && c <= '9') || c == '+' || c == '-' || c == '.'; });
}

bool lies_below(const fs::path& path, const fs::path& folder) {
    const auto [folder_end, path_at] = std::mismatch(folder.begin(), folder.end(), path.begin(), path.end());
    return folder_end == folder.end() && path_at != path.end();
}

constexpr size_t kMaxUriBytes = 4096;  // of a file's name

constexpr std::array<int8_t, 256> make_base64_table() {
    std::array<int8_t, 256> table{};
    for (int8_t& entry : table) entry = -1;
    constexpr std::string_view kAlphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < kAlphabet.size(); ++i) table[static_cast<unsigned char>(kAlphabet[i])] = static_cast<int8_t>(i);
    return table;
}

std::vector<std::byte> decode_base64(std::string_view text, std::string_view where) {
    static constexpr std::array<int8_t, 256> kTable = make_base64_table();
    for (int padding = 0; padding < 2 && !text.empty() && text.back() == '='; ++padding) text.remove_suffix(1);
    if (text.size() % 4 == 1) fail(where, "the base64 data of its URI ends in the middle of a byte");
    std::vector<std::byte> out;
    out.reserve(text.size() / 4 * 3 + 2);
    uint32_t bits = 0;
    int bit_count = 0;
    for (size_t i = 0; i < text.size(); ++i) {
        const int value = kTable[static_cast<unsigned char>(text[i])];
        if (value < 0) fail(where, fmt::format("the base64 data of its URI has a wrong character at {}", i));
        bits = bits << 6 | static_cast<uint32_t>(value);
        bit_count += 6;
        if (bit_count < 8) continue;
        bit_count -= 8;
        out.push_back(static_cast<std::byte>(bits >> bit_count & 0xFFu));
    }
    return out;
}

}  // namespace

bool is_data_uri(std::string_view uri) { return starts_with_ignoring_case(uri, "data:"); }

std::string percent_decode(std::string_view text) {
    std::string out;
    out.reserve(text.size());
    for (size_t i = 0; i < text.size(); ++i) {
        const int high = text[i] == '%' && i + 2 < text.size() ? hex_digit(text[i + 1]) : -1;
        const int low = high >= 0 ? hex_digit(text[i + 2]) : -1;
        if (low >= 0) {
            out.push_back(static_cast<char>(high * 16 + low));
            i += 2;
        } else {
            out.push_back(text[i]);
        }
    }
    return out;
}

std::vector<std::byte> decode_data_uri(std::string_view uri, std::string_view where) {
    const size_t comma = uri.find(',');
    if (comma == std::string_view::npos) fail(where, "is a data: URI without a comma");
    const std::string_view payload = uri.substr(comma + 1);
    constexpr std::string_view kBase64 = ";base64";
    const std::string_view head = uri.substr(0, comma);
    if (head.size() >= kBase64.size() && starts_with_ignoring_case(head.substr(head.size() - kBase64.size()), kBase64))
        return decode_base64(payload, where);
    const std::string text = percent_decode(payload);
    const auto* bytes = reinterpret_cast<const std::byte*>(text.data());
    return {bytes, bytes + text.size()};
}

SceneFiles::SceneFiles(fs::path root, const SceneFileLimits& limits) : limits_(limits) {
    std::error_code ec;
    if (!root.empty()) root_ = fs::canonical(root, ec);
    if (ec) fail(escape_name(root.string()), "the scene's folder cannot be found: " + ec.message());
}

uint64_t SceneFiles::budget_left() const {
    static const uint64_t machine = platform::physical_bytes();
    const uint64_t budget = std::min(machine, limits_.budget_base_bytes + limits_.budget_factor * std::min<uint64_t>(bytes_read_, 1ull << 50));
    const uint64_t used = charged_;
    return used < budget ? budget - used : 0;
}

void SceneFiles::charge(uint64_t bytes, std::string_view where) {
    if (bytes > budget_left())
        fail(where,
             fmt::format("would take {} MiB more memory; the budget for this scene has {} MiB left", bytes >> 20, budget_left() >> 20),
             "files of this size do not need that much: the file is damaged or hostile");
    charged_ += bytes;
}

SceneFiles::Bytes SceneFiles::read_counted(const fs::path& path, std::string_view where) {
    try {
        Bytes bytes = std::make_shared<const std::vector<std::byte>>(read_file(path, std::min(limits_.max_file_bytes, platform::physical_bytes())));
        bytes_read_ += bytes->size();
        charge(bytes->size(), where);
        return bytes;
    } catch (const std::bad_alloc&) {
        fail(where, "is larger than the memory of this machine");
    }
}

SceneFiles::Bytes SceneFiles::read_main(const fs::path& path) { return read_counted(path, escape_name(path.string())); }

fs::path SceneFiles::resolve(std::string_view uri, std::string_view where) const {
    const std::string shown = escape_name(uri, 100);
    if (root_.empty()) fail(where, fmt::format("names the file '{}', but a scene in memory has no folder", shown));
    if (has_protocol(uri))
        fail(where, fmt::format("the URI '{}' names a protocol; only files beside the scene are read", shown),
             "download the file and name it relatively");
    std::string decoded = percent_decode(uri);
    std::replace(decoded.begin(), decoded.end(), '\\', '/');
    if (decoded.empty()) fail(where, "has an empty URI");
    if (decoded.size() > kMaxUriBytes) fail(where, fmt::format("the URI '{}' is {} bytes long; the limit is {}", shown, decoded.size(), kMaxUriBytes));
    if (decoded.find('\0') != std::string::npos) fail(where, fmt::format("the URI '{}' holds a zero byte", shown));
    if (decoded.starts_with("//")) fail(where, fmt::format("the URI '{}' names another machine; only files beside the scene are read", shown));
    const fs::path relative(decoded);
    const auto require_inside = [&](const fs::path& path) {
        if (limits_.allow_external || lies_below(path, root_)) return;
        fail(where, fmt::format("the URI '{}' leads out of the scene's folder", shown), "--allow-external permits it");
    };
    // By its text first: an error must not tell what there is outside of the folder.
    require_inside((root_ / relative).lexically_normal());
    // Then with every link followed. The path must exist whole: what lies behind a folder that does not exist could be a link.
    std::error_code ec;
    const fs::path path = fs::canonical(root_ / relative, ec);
    if (ec == std::errc::no_such_file_or_directory) fail(where, fmt::format("'{}' there is no such file", shown));
    if (ec) fail(where, fmt::format("'{}' cannot be resolved: {}", shown, ec.message()));
    require_inside(path);
    return path;
}

SceneFiles::Bytes SceneFiles::read_uri(std::string_view uri, std::string_view where) {
    if (is_data_uri(uri)) {
        charge(uri.size(), where);
        return std::make_shared<const std::vector<std::byte>>(decode_data_uri(uri, where));
    }
    const fs::path path = resolve(uri, where);
    Bytes& cached = cache_[path];
    if (!cached) {
        try {
            cached = read_counted(path, where);
        } catch (const Error& error) {
            // The reader says what is wrong with the file; the place in the scene that names it is what the user can mend.
            fail(where, fmt::format("'{}' {}", escape_name(uri, 100), error.problem), error.hint);
        }
    }
    return cached;
}

}  // namespace parhelion
