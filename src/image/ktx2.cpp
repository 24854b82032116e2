// KTX 2.0 files (Khronos KTX File Format Specification 2.0): plain eight-bit formats and BC blocks, two-dimensional, with their
// levels, as they are or compressed with Zstandard.
#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <optional>
#include <vector>

#include <zstd.h>

#include "image/limits.h"

namespace parhelion::image {

namespace {

constexpr uint64_t kHeaderBytes = 80, kLevelEntryBytes = 24;  // 3.1 to 3.10
constexpr uint32_t kNone = 0, kBasisLz = 1, kZstd = 2, kZlib = 3;
constexpr uint32_t kModelRgb = 1, kModelUastc = 166;  // colour models of Khronos Data Format 1.3, 5.6

// A format that is read, by its number in Vulkan.
struct Row {
    uint32_t format;
    TexelFormat texels;
    uint32_t stored_bytes;  // of a texel (plain) or a block
    uint32_t model;         // colour model that the data format descriptor must state
    bool blue_first = false;
};
constexpr std::array<Row, 22> kRows = {{
    {9, TexelFormat::Rgba8, 1, kModelRgb},          // R8_UNORM
    {15, TexelFormat::Rgba8, 1, kModelRgb},         // R8_SRGB
    {16, TexelFormat::Rgba8, 2, kModelRgb},         // R8G8_UNORM
    {22, TexelFormat::Rgba8, 2, kModelRgb},         // R8G8_SRGB
    {23, TexelFormat::Rgba8, 3, kModelRgb},         // R8G8B8_UNORM
    {29, TexelFormat::Rgba8, 3, kModelRgb},         // R8G8B8_SRGB
    {30, TexelFormat::Rgba8, 3, kModelRgb, true},   // B8G8R8_UNORM
    {36, TexelFormat::Rgba8, 3, kModelRgb, true},   // B8G8R8_SRGB
    {37, TexelFormat::Rgba8, 4, kModelRgb},         // R8G8B8A8_UNORM
    {43, TexelFormat::Rgba8, 4, kModelRgb},         // R8G8B8A8_SRGB
    {44, TexelFormat::Rgba8, 4, kModelRgb, true},   // B8G8R8A8_UNORM
    {50, TexelFormat::Rgba8, 4, kModelRgb, true},   // B8G8R8A8_SRGB
    {131, TexelFormat::Bc1Rgb, 8, 128},             // BC1_RGB_UNORM_BLOCK
    {132, TexelFormat::Bc1Rgb, 8, 128},             // BC1_RGB_SRGB_BLOCK
    {133, TexelFormat::Bc1, 8, 128},                // BC1_RGBA_UNORM_BLOCK
    {134, TexelFormat::Bc1, 8, 128},                // BC1_RGBA_SRGB_BLOCK
    {137, TexelFormat::Bc3, 16, 130},               // BC3_UNORM_BLOCK
    {138, TexelFormat::Bc3, 16, 130},               // BC3_SRGB_BLOCK
    {139, TexelFormat::Bc4, 8, 131},                // BC4_UNORM_BLOCK
    {141, TexelFormat::Bc5, 16, 132},               // BC5_UNORM_BLOCK
    {145, TexelFormat::Bc7, 16, 134},               // BC7_UNORM_BLOCK
    {146, TexelFormat::Bc7, 16, 134},               // BC7_SRGB_BLOCK
}};

const Row* find_row(uint32_t format) {
    const auto found = std::find_if(kRows.begin(), kRows.end(), [&](const Row& row) { return row.format == format && format != 0; });
    return found == kRows.end() ? nullptr : &*found;
}

// What stands for a format that is not read, in the words of its users.
std::string unread_format(uint32_t format) {
    if (format == 135 || format == 136) return "BC2";
    if (format == 140 || format == 142) return "signed BC4 or BC5";
    if (format == 143 || format == 144) return "BC6H";
    if (format >= 147 && format <= 156) return "ETC2 or EAC";
    if (format >= 157 && format <= 184) return "ASTC";
    return fmt::format("VkFormat {}", format);
}

struct Section {
    uint64_t offset = 0, bytes = 0;
    const char* name = "";
};

struct Level {
    Section stored;
    uint64_t unpacked_bytes = 0;
};

struct Header {
    uint32_t format = 0, type_size = 0, width = 0, height = 0, depth = 0, layers = 0, faces = 0, levels = 0, scheme = 0;
    uint32_t model = 0;  // of the data format descriptor
    bool premultiplied = false;
    Section descriptor, key_values, global_data;
    std::vector<Level> level_index;  // finest first
};

class Ktx2 {
public:
    Ktx2(std::span<const std::byte> bytes, std::string_view where) : bytes_(bytes), where_(where) {}

    // Everything but the texels, checked: what it says lies in the file and nothing lies twice.
    Header read_header() const {
        if (bytes_.size() < kHeaderBytes || detect_format(bytes_) != Format::Ktx2) damaged("its header is cut off", kCut);
        Header h;
        uint64_t at = 12;
        for (uint32_t* field : {&h.format, &h.type_size, &h.width, &h.height, &h.depth, &h.layers, &h.faces, &h.levels, &h.scheme}) {
            *field = u32(at);
            at += 4;
        }
        h.descriptor = {u32(48), u32(52), "data format descriptor"};
        h.key_values = {u32(56), u32(60), "key/value data"};
        h.global_data = {u64(64), u64(72), "supercompression data"};
        check_shape(h);
        read_level_index(h);
        check_sections(h);
        read_descriptor(h);
        return h;
    }

    // Texels with a length that is right for their level; `out` is as long as the level.
    void unpack_level(const Header& h, size_t index, std::span<uint8_t> out) const {
        const std::span<const std::byte> stored = bytes_.subspan(h.level_index[index].stored.offset, h.level_index[index].stored.bytes);
        if (h.scheme == kNone) {
            std::memcpy(out.data(), stored.data(), out.size());
            return;
        }
        const size_t size = ZSTD_decompress(out.data(), out.size(), stored.data(), stored.size());
        if (ZSTD_isError(size)) damaged(fmt::format("level {} cannot be unpacked ({})", index, ZSTD_getErrorName(size)));
        if (size != out.size()) damaged(fmt::format("level {} unpacks to {} bytes, expected {}", index, size, out.size()));
    }

    // 5.2 and 5.3: rows must run from the top and channels stand where they belong.
    void check_key_values(const Header& h, uint32_t channels) const {
        if (h.key_values.bytes == 0) return;
        const std::span<const std::byte> all = bytes_.subspan(h.key_values.offset, h.key_values.bytes);
        for (uint64_t at = 0; at < all.size();) {
            if (all.size() - at < 4) damaged("its key/value data end within an entry");
            const uint64_t length = u32(h.key_values.offset + at);
            if (length > all.size() - at - 4) damaged("its key/value data end within an entry");
            const std::string_view entry(reinterpret_cast<const char*>(all.data()) + at + 4, length);
            const size_t end = entry.find('\0');
            if (end == 0 || end == std::string_view::npos) damaged("its key/value data have an entry without a key");
            check_key(entry.substr(0, end), entry.substr(end + 1), channels);
            at += 4 + (length + 3) / 4 * 4;
        }
    }

    [[noreturn]] void damaged(std::string_view what, std::string hint = {}) const {
        refuse_image(where_, fmt::format("is a damaged KTX2: {}", what), std::move(hint));
    }

private:
    static constexpr const char* kCut = "the file is cut off";

    uint32_t u32(uint64_t offset) const {
        uint32_t value = 0;
        for (uint64_t i = 0; i < 4; ++i) value |= std::to_integer<uint32_t>(bytes_[offset + i]) << (8 * i);
        return value;
    }
    uint64_t u64(uint64_t offset) const { return u32(offset) | uint64_t{u32(offset + 4)} << 32; }

    void check_shape(const Header& h) const {
        if (h.width == 0) damaged("it is 0 pixels wide");
        const char* what = h.height == 0  ? "a one-dimensional KTX2"
                           : h.depth != 0 ? "a three-dimensional KTX2"
                           : h.layers != 0 ? "a KTX2 with array layers"
                           : h.faces == 6 ? "a KTX2 cube map"
                                          : nullptr;
        if (what != nullptr) refuse_image(where_, fmt::format("is {}, which textures here cannot be", what), "save each picture as a file of its own");
        if (h.faces != 1) damaged(fmt::format("it has {} faces", h.faces));
        if (h.levels > static_cast<uint32_t>(std::bit_width(std::max(h.width, h.height))))
            damaged(fmt::format("it has {} levels, too many for {}x{} pixels", h.levels, h.width, h.height));
        if (h.scheme > kZlib) refuse_image(where_, fmt::format("is a KTX2 with the unknown supercompression {}", h.scheme), "save it with zstd or without");
    }

    void read_level_index(Header& h) const {
        const uint64_t count = std::max(1u, h.levels);
        if (bytes_.size() - kHeaderBytes < count * kLevelEntryBytes) damaged("its level index is cut off", kCut);
        for (uint64_t i = 0; i < count; ++i) {
            const uint64_t at = kHeaderBytes + i * kLevelEntryBytes;
            h.level_index.push_back({{u64(at), u64(at + 8), "level"}, u64(at + 16)});
            if (h.level_index.back().stored.bytes == 0) damaged(fmt::format("level {} has no bytes", i));
        }
    }

    void check_sections(const Header& h) const {
        std::vector<Section> sections = {{0, kHeaderBytes + h.level_index.size() * kLevelEntryBytes, "header"}, h.descriptor, h.key_values, h.global_data};
        for (const Level& level : h.level_index) sections.push_back(level.stored);
        std::erase_if(sections, [](const Section& s) { return s.bytes == 0; });
        for (const Section& s : sections)
            if (s.offset > bytes_.size() || s.bytes > bytes_.size() - s.offset)
                damaged(fmt::format("its {} has {} bytes from {} on; the file has {}", s.name, s.bytes, s.offset, bytes_.size()), kCut);
        std::sort(sections.begin(), sections.end(), [](const Section& a, const Section& b) { return a.offset < b.offset; });
        for (size_t i = 1; i < sections.size(); ++i)
            if (sections[i - 1].offset + sections[i - 1].bytes > sections[i].offset)
                damaged(fmt::format("its {} lies over its {}", sections[i].name, sections[i - 1].name));
    }

    // Khronos Data Format 1.3, 5: the total size, then the basic block with model, primaries, transfer function and flags.
    void read_descriptor(Header& h) const {
        if (h.descriptor.bytes < 4 + 24 || u32(h.descriptor.offset) != h.descriptor.bytes) damaged("its data format descriptor has a wrong size");
        const uint32_t word = u32(h.descriptor.offset + 12);
        h.model = word & 0xFF;
        h.premultiplied = (word >> 24 & 1) != 0;
    }

    void check_key(std::string_view key, std::string_view value, uint32_t channels) const {
        value = value.substr(0, value.find('\0'));
        if (key == "KTXorientation" && value != "rd")
            refuse_image(where_, fmt::format("is a KTX2 whose rows or columns run the other way (KTXorientation '{}')", escape_name(value, 20)), "save it with the orientation 'rd'");
        if (key != "KTXswizzle") return;
        bool plain = value.size() == 4;
        for (size_t i = 0; plain && i < 4; ++i) plain = value[i] == "rgba"[i] || (i >= channels && value[i] == "0001"[i]);
        if (!plain) refuse_image(where_, fmt::format("is a KTX2 that exchanges channels (KTXswizzle '{}')", escape_name(value, 20)), "save it with its channels in place");
    }

    std::span<const std::byte> bytes_;
    std::string_view where_;
};

std::optional<std::string> obstacle(const Header& h) {
    if (h.scheme == kBasisLz || (h.format == 0 && h.model == kModelUastc)) return "Basis Universal texels";
    if (h.format == 0) return fmt::format("texels of an undefined format (colour model {})", h.model);
    if (find_row(h.format) == nullptr) return unread_format(h.format) + " texels";
    if (h.scheme == kZlib) return "zlib supercompression";
    return std::nullopt;
}

uint32_t channel_count(const Row& row) {
    if (row.texels == TexelFormat::Rgba8) return row.stored_bytes;
    return row.texels == TexelFormat::Bc4 ? 1 : row.texels == TexelFormat::Bc5 ? 2 : row.texels == TexelFormat::Bc1Rgb ? 3 : 4;
}

// What a plain format lacks is as Vulkan gives it: 0, and alpha 1.
void widen(const Row& row, std::span<const uint8_t> stored, std::span<uint8_t> rgba) {
    const size_t width = row.stored_bytes;
    for (size_t i = 0; i < rgba.size() / 4; ++i) {
        std::array<uint8_t, 4> texel = {0, 0, 0, 255};
        std::memcpy(texel.data(), stored.data() + i * width, width);
        if (row.blue_first) std::swap(texel[0], texel[2]);
        std::memcpy(rgba.data() + 4 * i, texel.data(), 4);
    }
}

uint32_t side(uint32_t finest, size_t level) { return std::max(1u, finest >> level); }

// Sizes as the format asks for them, before memory is taken.
void check_levels(const Ktx2& file, const Header& h, const Row& row, const DecodeLimits& limits, std::string_view where) {
    check_limits(h.width, h.height, 1, limits, where);
    const uint64_t total = image_bytes(row.texels, h.width, h.height, static_cast<uint32_t>(h.level_index.size()));
    if (total > limits.max_bytes) refuse_image(where, fmt::format("needs {} bytes; the limit is {}", total, limits.max_bytes));
    // A block of Zstandard takes at least 4 bytes and unpacks to at most 128 KiB (RFC 8878, 3.1.1.2).
    constexpr uint64_t kBlockBytes = 4, kBlockUnpacked = 128 << 10;
    for (size_t i = 0; i < h.level_index.size(); ++i) {
        const uint32_t w = side(h.width, i), height = side(h.height, i);
        const uint64_t expected = row.texels == TexelFormat::Rgba8 ? uint64_t{w} * height * row.stored_bytes : level_bytes(row.texels, w, height);
        const uint64_t stored = h.level_index[i].stored.bytes, unpacked = h.level_index[i].unpacked_bytes;
        if (unpacked != expected || (h.scheme == kNone && stored != expected))
            file.damaged(fmt::format("level {} has {} bytes ({} unpacked), expected {}", i, stored, unpacked, expected));
        if (h.scheme == kZstd && expected > (stored / kBlockBytes + 1) * kBlockUnpacked) file.damaged(fmt::format("level {} is too small for its size", i));
    }
}

Texels unpack(const Ktx2& file, const Header& h, const Row& row) {
    const auto levels = static_cast<uint32_t>(h.level_index.size());
    Texels out{.width = h.width, .height = h.height, .format = row.texels, .level_count = levels};
    out.bytes.resize(image_bytes(row.texels, h.width, h.height, levels));
    std::vector<uint8_t> narrow;
    uint64_t at = 0;
    for (size_t i = 0; i < levels; ++i) {
        const std::span<uint8_t> level = std::span(out.bytes).subspan(at, level_bytes(row.texels, side(h.width, i), side(h.height, i)));
        at += level.size();
        if (row.texels != TexelFormat::Rgba8) {
            file.unpack_level(h, i, level);
            continue;
        }
        narrow.resize(h.level_index[i].unpacked_bytes);
        file.unpack_level(h, i, narrow);
        widen(row, narrow, level);
    }
    return out;
}

}  // namespace

std::optional<std::string> ktx2_obstacle(std::span<const std::byte> bytes, std::string_view where) { return obstacle(Ktx2(bytes, where).read_header()); }

Texels decode_ktx2(std::span<const std::byte> bytes, const DecodeLimits& limits, std::string_view where) {
    const Ktx2 file(bytes, where);
    const Header h = file.read_header();
    if (const std::optional<std::string> what = obstacle(h))
        refuse_image(where, fmt::format("is a KTX2 with {}, which is not supported", *what), "encode it again as KTX2 with BC7, or as PNG");
    const Row& row = *find_row(h.format);
    if (h.model != row.model) file.damaged(fmt::format("its format is VkFormat {}, its data format descriptor has colour model {}", h.format, h.model));
    if (h.type_size != 1) file.damaged(fmt::format("its type size is {}, expected 1", h.type_size));
    if (h.premultiplied) refuse_image(where, "is a KTX2 with colours multiplied by alpha, which is not supported", "save it with straight alpha");
    if (h.global_data.bytes != 0) file.damaged("it has supercompression data that its supercompression does not use");
    file.check_key_values(h, channel_count(row));

    check_levels(file, h, row, limits, where);
    return unpack(file, h, row);
}

}  // namespace parhelion::image
