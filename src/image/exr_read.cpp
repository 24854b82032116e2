// EXR files to memory. The header is read and held against the limits before OpenEXR's own reader, which allocates by it,
// sees the file.
#include <algorithm>
#include <cstring>
#include <functional>
#include <map>
#include <optional>
#include <string_view>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfIO.h>
#include <ImfPartType.h>
#include <ImfStringAttribute.h>
#include <ImfTileDescription.h>
#include <ImfVersion.h>
#include <Iex.h>

#include "image/limits.h"

namespace parhelion::image {

namespace {

class MemoryInput final : public Imf::IStream {
public:
    explicit MemoryInput(std::span<const std::byte> bytes) : IStream("image"), bytes_(bytes) {}

    bool read(char out[], int size) override {
        if (size < 0 || static_cast<uint64_t>(size) > bytes_.size() - position_) throw Iex::InputExc("the file ends early");
        std::memcpy(out, bytes_.data() + position_, static_cast<size_t>(size));
        position_ += static_cast<uint64_t>(size);
        return position_ < bytes_.size();
    }
    uint64_t tellg() override { return position_; }
    void seekg(uint64_t position) override {
        if (position > bytes_.size()) throw Iex::InputExc("the file ends early");
        position_ = position;
    }
    void clear() override {}

private:
    std::span<const std::byte> bytes_;
    uint64_t position_ = 0;
};

struct Size {
    uint64_t width = 0, height = 0;
};

Size data_size(const Imf::Header& header) {
    const Imath::Box2i& box = header.dataWindow();
    if (box.max.x < box.min.x || box.max.y < box.min.y) return {};
    return {static_cast<uint64_t>(int64_t{box.max.x} - box.min.x) + 1, static_cast<uint64_t>(int64_t{box.max.y} - box.min.y) + 1};
}

uint64_t channel_count(const Imf::Header& header) {
    uint64_t count = 0;
    for (auto c = header.channels().begin(); c != header.channels().end(); ++c) ++count;
    return count;
}

// A 32-bit number of the file; EXR is little-endian.
uint32_t read_number(MemoryInput& input) {
    unsigned char bytes[4];
    input.read(reinterpret_cast<char*>(bytes), sizeof(bytes));
    return bytes[0] | (uint32_t{bytes[1]} << 8) | (uint32_t{bytes[2]} << 16) | (uint32_t{bytes[3]} << 24);
}

std::string read_name(MemoryInput& input) {
    std::string name;
    for (char c = 0; name.size() < 256; name += c) {
        input.read(&c, 1);
        if (c == 0) return name;
    }
    throw Iex::InputExc("a name in the header has no end");
}

// Bytes that OpenEXR reads for an attribute of a type, whatever size the file gives it; none for types that go by that size.
std::optional<uint64_t> bytes_of_type(std::string_view type) {
    static const std::map<std::string_view, uint64_t> kBytes = {
        {"box2f", 16}, {"box2i", 16},    {"chromaticities", 32}, {"compression", 1}, {"deepImageState", 1}, {"double", 8}, {"envmap", 1},
        {"float", 4},  {"int", 4},       {"keycode", 28},        {"lineOrder", 1},   {"m33d", 72},          {"m33f", 36},  {"m44d", 128},
        {"m44f", 64},  {"rational", 8},  {"tiledesc", 9},        {"timecode", 8},    {"v2d", 16},           {"v2f", 8},    {"v2i", 8},
        {"v3d", 24},   {"v3f", 12},      {"v3i", 12},
    };
    const auto found = kBytes.find(type);
    return found == kBytes.end() ? std::nullopt : std::optional(found->second);
}

// Walks over one header: OpenEXR 3.1 allocates what an attribute's size says before it looks whether the file holds as much. It also reads
// most types without regard for that size, so that another walk than this one would see other attributes: sizes must be those of the types.
void check_attribute_sizes(MemoryInput& input, uint64_t file_size) {
    const auto skip = [&](uint64_t bytes) { input.seekg(input.tellg() + bytes); };
    while (!read_name(input).empty()) {
        const std::string type = read_name(input);
        const uint64_t size = read_number(input), begin = input.tellg(), end = begin + size;
        if (end > file_size) throw Iex::InputExc("an attribute in the header is larger than the file");
        if (type == "stringvector") {
            while (input.tellg() < end) skip(read_number(input));
        } else if (type == "chlist") {
            while (!read_name(input).empty()) skip(16);
        } else if (type == "preview") {
            const uint64_t width = read_number(input), height = read_number(input);
            if (width * height > file_size) throw Iex::InputExc("an attribute in the header is larger than the file");
            skip(4 * width * height);
        } else {
            skip(bytes_of_type(type).value_or(type == "floatvector" ? size / 4 * 4 : size));
        }
        if (input.tellg() != end) throw Iex::InputExc("an attribute in the header has a wrong size");
    }
}

void check_header(const Imf::Header& header, const DecodeLimits& limits, std::string_view where) {
    const Size size = data_size(header);
    check_limits(size.width, size.height, sizeof(float) * std::max<uint64_t>(1, channel_count(header)), limits, where);
    if (header.hasTileDescription()) check_limits(header.tileDescription().xSize, header.tileDescription().ySize, 1, limits, where);
    for (auto c = header.channels().begin(); c != header.channels().end(); ++c)
        if (c.channel().xSampling != 1 || c.channel().ySampling != 1)
            refuse_image(where, "is an EXR with subsampled channels, which are not supported", "save it as RGB");
}

// All parts' headers, for OpenEXR allocates tables for each.
void check_headers(std::span<const std::byte> bytes, const DecodeLimits& limits, std::string_view where) {
    MemoryInput input(bytes);
    read_number(input);  // the magic, checked by the reader
    int version = static_cast<int>(read_number(input));
    if (Imf::getVersion(version) != Imf::EXR_VERSION || !Imf::supportsFlags(Imf::getFlags(version)))
        refuse_image(where, "is an OpenEXR file of a version that is not supported");
    if (Imf::isNonImage(version)) refuse_image(where, "is an EXR with deep data, which is not supported");
    for (bool more = true; more;) {
        const uint64_t begin = input.tellg();
        check_attribute_sizes(input, bytes.size());
        input.seekg(begin);
        Imf::Header header;
        header.readFrom(input, version);
        check_header(header, limits, where);
        if (!Imf::isMultiPart(version)) break;
        // In a multi-part file the headers end with an empty one.
        char next = 0;
        input.read(&next, 1);
        more = next != 0;
        input.seekg(input.tellg() - 1);
    }
}

struct Opened {
    uint32_t width, height;
    std::vector<std::string> channels = {};
    Attributes attributes = {};
};

// Reads all channels as `type` into the memory that `allocate` returns for a count of four-byte values.
Opened read_channels(std::span<const std::byte> bytes, const DecodeLimits& limits, std::string_view where, Imf::PixelType type,
                     const std::function<char*(size_t)>& allocate) {
    check_headers(bytes, limits, where);
    MemoryInput input(bytes);
    Imf::InputFile file(input);
    const Imf::Header& header = file.header();
    const Size size = data_size(header);
    Opened out{.width = static_cast<uint32_t>(size.width), .height = static_cast<uint32_t>(size.height)};
    for (auto c = header.channels().begin(); c != header.channels().end(); ++c) {
        if (type == Imf::UINT && c.channel().type != Imf::UINT)
            refuse_image(where, fmt::format("its channel {} is not of type UINT", escape_name(c.name())));
        out.channels.emplace_back(c.name());
    }
    if (out.channels.empty()) refuse_image(where, "is an EXR without channels");
    for (auto a = header.begin(); a != header.end(); ++a)
        if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&a.attribute())) out.attributes[a.name()] = text->value();

    const uint64_t pixels = size.width * size.height;
    char* data = allocate(out.channels.size() * pixels);
    Imf::FrameBuffer frame;
    const Imath::Box2i& box = header.dataWindow();
    for (size_t c = 0; c < out.channels.size(); ++c)
        frame.insert(out.channels[c], Imf::Slice::Make(type, data + 4 * c * pixels, box, 4, 4 * size.width));
    file.setFrameBuffer(frame);
    file.readPixels(box.min.y, box.max.y);
    return out;
}

// Runs `decode`, turning OpenEXR's exceptions into ours.
template <class Decode>
Opened guard(std::string_view where, const Decode& decode) {
    try {
        return decode();
    } catch (const Error&) {
        throw;
    } catch (const std::bad_alloc&) {
        refuse_image(where, "cannot be decoded: out of memory");
    } catch (const std::exception& e) {
        refuse_image(where, fmt::format("is a damaged EXR: {}", escape_name(e.what())));
    }
}

// Into an ImageF or a UintImage.
template <class T>
T decode_as(Imf::PixelType type, std::span<const std::byte> bytes, const DecodeLimits& limits, std::string_view where) {
    T image;
    Opened opened = guard(where, [&] {
        return read_channels(bytes, limits, where, type, [&](size_t count) {
            image.data.resize(count);
            return reinterpret_cast<char*>(image.data.data());
        });
    });
    image.width = opened.width;
    image.height = opened.height;
    image.channels = std::move(opened.channels);
    image.attributes = std::move(opened.attributes);
    return image;
}

}  // namespace

ImageF decode_exr(std::span<const std::byte> bytes, const DecodeLimits& limits, std::string_view where) {
    return decode_as<ImageF>(Imf::FLOAT, bytes, limits, where);
}

UintImage decode_uint_exr(std::span<const std::byte> bytes, const DecodeLimits& limits, std::string_view where) {
    return decode_as<UintImage>(Imf::UINT, bytes, limits, where);
}

}  // namespace parhelion::image
