#include "scene/gltf/document.h"

#include <array>
#include <cstring>

#include "base/error.h"
#include "scene/gltf/extensions.h"
#include "scene/gltf/meshopt.h"

namespace parhelion {

namespace {

constexpr uint32_t kGlbMagic = 0x46546C67u, kJsonChunk = 0x4E4F534Au, kBinaryChunk = 0x004E4942u;

uint32_t read_u32(std::span<const std::byte> bytes, size_t offset) {
    std::array<uint8_t, 4> b{};
    std::memcpy(b.data(), bytes.data() + offset, 4);
    return uint32_t(b[0]) | uint32_t(b[1]) << 8 | uint32_t(b[2]) << 16 | uint32_t(b[3]) << 24;
}

std::string_view as_text(std::span<const std::byte> bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

std::vector<std::string> string_list(const JsonRef& root, std::string_view key) {
    std::vector<std::string> out;
    if (const std::optional<JsonRef> list = root.find_array(key))
        for (size_t i = 0; i < list->size(); ++i) out.emplace_back((*list)[i].as_string());
    return out;
}

bool contains(const std::vector<std::string>& list, std::string_view name) { return std::find(list.begin(), list.end(), name) != list.end(); }

}  // namespace

GltfDocument::GltfDocument(SceneFiles& files, std::span<const std::byte> file, std::string name) : files_(files), name_(std::move(name)) {
    const std::string_view text = read_container(file);
    const JsonLimits limits{.max_values = files_.budget_left() / JsonLimits::kBytesPerValue};
    json_ = std::make_unique<JsonDocument>(text, name_, limits);
    files_.charge(json_->shape().values * JsonLimits::kBytesPerValue + text.size(), name_);
    check_version();
    check_extensions();
}

// glTF 2.0, 4: a header of 12 bytes, then chunks of {length, type, data}; the first is JSON, the second may be binary.
std::string_view GltfDocument::read_container(std::span<const std::byte> file) {
    const auto fail = [&](std::string what, std::string hint = {}) {
        throw Error(ErrorCode::Failed, std::move(what), name_, std::move(hint));
    };
    if (file.size() < 4) fail("is too short to be a glTF file");
    if (read_u32(file, 0) != kGlbMagic) {
        const std::string_view text = as_text(file);
        const size_t first = text.find_first_not_of("\xEF\xBB\xBF \t\r\n");  // a byte order mark is allowed
        if (first == std::string_view::npos || text[first] != '{') fail("is no glTF: it is neither GLB nor a JSON object", "SCENE is a .gltf or .glb file, or builtin:NAME");
        return text;
    }
    const std::string cut = "the file is cut off or damaged: copy it again";
    if (file.size() < 20) fail("its GLB header is cut off", cut);
    if (const uint32_t version = read_u32(file, 4); version != 2)
        fail(fmt::format("is a GLB of version {}; only version 2 is read", version));
    const uint64_t length = read_u32(file, 8);
    if (length > file.size()) fail(fmt::format("its GLB header promises {} bytes, the file has {}", length, file.size()), cut);
    if (length < file.size()) warn(fmt::format("{} bytes follow the end of the GLB data", file.size() - length));
    std::optional<std::string_view> text;
    size_t chunk_index = 0;
    for (uint64_t at = 12; at < length; ++chunk_index) {
        if (length - at < 8) fail("its last GLB chunk header is cut off", cut);
        const uint64_t size = read_u32(file, at);
        const uint32_t type = read_u32(file, at + 4);
        if (size > length - at - 8)
            fail(fmt::format("GLB chunk {} has {} bytes, the file ends after {}", chunk_index, size, length - at - 8), cut);
        const std::span<const std::byte> data = file.subspan(at + 8, size);
        if (chunk_index == 0 && type != kJsonChunk) fail("its first GLB chunk is not JSON");
        if (chunk_index == 0) text = as_text(data);
        if (chunk_index == 1 && type == kBinaryChunk) binary_chunk_ = data;
        at += 8 + size;
    }
    if (!text) fail("is a GLB without a JSON chunk");
    return *text;
}

void GltfDocument::check_version() const {
    const JsonRef asset = root().at("asset");
    const auto major = [](const JsonRef& version) {
        const std::string_view text = version.as_string();
        const bool good = text.size() >= 3 && text[0] >= '0' && text[0] <= '9' && text[1] == '.';
        if (!good) version.fail(fmt::format("'{}' is not a version", escape_name(text, 20)), "glTF 2.0 is read");
        return text[0] - '0';
    };
    const JsonRef version = asset.at("version");
    if (const int number = major(version); number != 2)
        version.fail(fmt::format("is glTF {}; only glTF 2 is read", escape_name(version.as_string(), 20)), "export it as glTF 2.0");
    const std::optional<JsonRef> minimum = asset.find("minVersion");
    if (minimum && (major(*minimum) != 2 || minimum->as_string() != "2.0"))
        minimum->fail(fmt::format("asks for glTF {}; glTF 2.0 is read", escape_name(minimum->as_string(), 20)));
}

void GltfDocument::check_extensions() {
    used_ = string_list(root(), "extensionsUsed");
    required_ = string_list(root(), "extensionsRequired");
    for (const std::string& name : required_)
        if (extension_use(name) == ExtensionUse::Unknown)
            root()
                .at("extensionsRequired")
                .fail(fmt::format("needs the extension {}, which is not supported", escape_name(name)), "export the scene without it");
    for (const std::string& name : required_)
        if (!contains(used_, name)) warn(fmt::format("the extension {} is required, but not among those used", escape_name(name)));
    std::set<std::string_view> seen;
    for (const std::string& name : used_) {
        const ExtensionUse use = extension_use(name);
        if (use != ExtensionUse::Unknown || !seen.insert(name).second) continue;
        not_drawn_.push_back(name);
        warn(fmt::format("the extension {} is unknown and ignored", escape_name(name)));
    }
}

void GltfDocument::warn(std::string text) {
    constexpr size_t kMostWarnings = 100;
    if (warnings_.size() >= kMostWarnings || !warned_.insert(text).second) return;
    warnings_.push_back(std::move(text));
}

void GltfDocument::leave_out(std::string_view extension) {
    if (!contains(not_drawn_, std::string(extension))) not_drawn_.emplace_back(extension);
}

void GltfDocument::warn(const JsonRef& place, std::string_view text) { warn(fmt::format("{}: {}", place.path(), text)); }

std::span<const std::byte> GltfDocument::buffer(uint32_t index) {
    const JsonRef json = root().at("buffers")[index];
    const uint64_t length = json.at("byteLength").as_uint(1ull << 53);
    const std::optional<JsonRef> uri = json.find("uri");
    std::span<const std::byte> bytes;
    if (uri) {
        SceneFiles::Bytes& kept = buffers_[index];
        if (!kept) kept = files_.read_uri(uri->as_string(), uri->where());
        bytes = *kept;
    } else {
        if (index != 0 || !binary_chunk_) json.fail("has no uri, and the file has no binary chunk for it");
        bytes = *binary_chunk_;
    }
    if (bytes.size() < length)
        json.fail(fmt::format("is {} bytes long, but its data has only {}", length, bytes.size()), "the file is cut off");
    return bytes.first(length);
}

// The part of a buffer that a buffer view, or its compression, names.
std::span<const std::byte> GltfDocument::slice(const JsonRef& json) {
    const uint64_t offset = json.uint("byteOffset", 0, 1ull << 53), length = json.at("byteLength").as_uint(1ull << 53);
    const std::span<const std::byte> bytes = buffer(json.at("buffer").as_index_of("buffers"));
    if (offset > bytes.size() || length > bytes.size() - offset)
        json.fail(fmt::format("bytes {} to {} lie outside its buffer of {}", offset, offset + length, bytes.size()));
    return bytes.subspan(offset, length);
}

GltfDocument::View GltfDocument::view(const JsonRef& ref) {
    const JsonRef json = entry("bufferViews", ref);
    View out;
    if (const std::optional<JsonRef> compression = meshopt_compression_of(json)) {
        const uint32_t index = ref.as_index_of("bufferViews");
        auto found = decompressed_views_.find(index);
        if (found == decompressed_views_.end())
            found = decompressed_views_.emplace(index, decode_meshopt(files_, json, *compression, slice(*compression))).first;
        out.bytes = found->second;
    } else {
        out.bytes = slice(json);
    }
    if (const std::optional<JsonRef> stride = json.find("byteStride")) {
        out.stride = static_cast<uint32_t>(stride->as_uint(252));
        if (out.stride < 4) stride->fail(fmt::format("is {}, expected 4 to 252", out.stride));
    }
    return out;
}

}  // namespace parhelion
