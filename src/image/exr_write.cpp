// EXR files from memory. OpenEXR writes into a buffer here and AtomicFile to the disk, so that a full disk is found in one place.
#include <algorithm>
#include <cmath>
#include <cstring>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfOutputFile.h>
#include <ImfStringAttribute.h>
#include <half.h>

#include "base/error.h"
#include "base/file.h"
#include "image/encode.h"

namespace parhelion::image {

namespace {

constexpr float kHalfMax = 65504.0f;

class MemoryOutput final : public Imf::OStream {
public:
    MemoryOutput() : OStream("image") {}
    void write(const char bytes[], int size) override {
        const auto count = static_cast<size_t>(size);
        if (position_ + count > bytes_.size()) bytes_.resize(position_ + count);
        std::memcpy(bytes_.data() + position_, bytes, count);
        position_ += count;
    }
    uint64_t tellp() override { return position_; }
    void seekp(uint64_t position) override { position_ = static_cast<size_t>(position); }
    std::vector<std::byte> take() { return std::move(bytes_); }

private:
    std::vector<std::byte> bytes_;
    size_t position_ = 0;
};

// Planes of `type`, `size` bytes a value, one after the other at `data`.
std::vector<std::byte> encode_planes(uint32_t width, uint32_t height, const std::vector<std::string>& channels, const Attributes& attributes,
                                     Imf::PixelType type, size_t size, const void* data) {
    PARHELION_CHECK(!channels.empty() && width > 0 && height > 0, "an EXR of {}x{} pixels with {} channels", width, height, channels.size());
    Imf::Header header(static_cast<int>(width), static_cast<int>(height));
    header.compression() = Imf::ZIP_COMPRESSION;
    for (const auto& [key, value] : attributes) header.insert(key, Imf::StringAttribute(value));
    Imf::FrameBuffer frame;
    const size_t row = size * width, plane = row * height;
    auto* base = static_cast<char*>(const_cast<void*>(data));  // a frame buffer serves reading and writing
    for (size_t c = 0; c < channels.size(); ++c) {
        header.channels().insert(channels[c], Imf::Channel(type));
        frame.insert(channels[c], Imf::Slice(type, base + c * plane, size, row));
    }
    MemoryOutput output;
    try {
        Imf::OutputFile file(output, header);
        file.setFrameBuffer(frame);
        file.writePixels(static_cast<int>(height));
    } catch (const std::exception& e) {
        throw Error(ErrorCode::Failed, fmt::format("the EXR cannot be encoded: {}", e.what()));
    }
    return output.take();
}

}  // namespace

EncodedExr encode_exr(const ImageF& image, ExrPrecision precision) {
    PARHELION_CHECK(image.data.size() == image.channels.size() * image.pixel_count(), "an image of {}x{} with {} channels and {} values", image.width,
                    image.height, image.channels.size(), image.data.size());
    if (precision == ExrPrecision::Float)
        return {encode_planes(image.width, image.height, image.channels, image.attributes, Imf::FLOAT, sizeof(float), image.data.data())};
    EncodedExr out;
    std::vector<half> halves(image.data.size());
    for (size_t i = 0; i < halves.size(); ++i) {
        // A finite value must not become infinite; infinities and NaN stay visible.
        const float value = image.data[i], limited = std::isfinite(value) ? std::clamp(value, -kHalfMax, kHalfMax) : value;
        if (std::isfinite(value) && limited != value) ++out.clamped;
        halves[i] = half(limited);
    }
    out.bytes = encode_planes(image.width, image.height, image.channels, image.attributes, Imf::HALF, sizeof(half), halves.data());
    return out;
}

std::vector<std::byte> encode_uint_exr(const UintImage& image) {
    PARHELION_CHECK(image.data.size() == image.channels.size() * image.width * image.height, "an image of {}x{} with {} channels and {} values",
                    image.width, image.height, image.channels.size(), image.data.size());
    return encode_planes(image.width, image.height, image.channels, image.attributes, Imf::UINT, sizeof(uint32_t), image.data.data());
}

uint64_t write_exr(const std::filesystem::path& path, const ImageF& image, ExrPrecision precision) {
    const EncodedExr encoded = encode_exr(image, precision);
    write_file(path, encoded.bytes);
    return encoded.clamped;
}

}  // namespace parhelion::image
