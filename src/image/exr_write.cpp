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

// One channel: values row by row.
struct ChannelPlane {
    std::string_view channel;
    Imf::PixelType type;
    const void* data;
};

// Planes of `type` one after the other at `data`.
template <class T>
std::vector<ChannelPlane> make_planes(const std::vector<std::string>& channels, Imf::PixelType type, const std::vector<T>& data) {
    std::vector<ChannelPlane> planes;
    for (size_t c = 0; c < channels.size(); ++c) planes.push_back({channels[c], type, data.data() + c * (data.size() / channels.size())});
    return planes;
}

std::vector<std::byte> encode_planes(uint32_t width, uint32_t height, const Attributes& attributes, const std::vector<ChannelPlane>& planes) {
    PARHELION_CHECK(!planes.empty() && width > 0 && height > 0, "an EXR of {}x{} pixels with {} channels", width, height, planes.size());
    Imf::Header header(static_cast<int>(width), static_cast<int>(height));
    header.compression() = Imf::ZIP_COMPRESSION;
    for (const auto& [key, value] : attributes) header.insert(key, Imf::StringAttribute(value));
    Imf::FrameBuffer frame;
    for (const ChannelPlane& plane : planes) {
        const size_t size = plane.type == Imf::HALF ? sizeof(half) : sizeof(uint32_t);
        auto* data = static_cast<char*>(const_cast<void*>(plane.data));  // a frame buffer serves reading and writing
        header.channels().insert(std::string(plane.channel), Imf::Channel(plane.type));
        frame.insert(std::string(plane.channel), Imf::Slice(plane.type, data, size, size * width));
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
    const auto encode = [&](std::vector<ChannelPlane> planes) {
        for (const ExactLayer& layer : image.exact) {
            PARHELION_CHECK(layer.words.size() == image.pixel_count(), "a layer of {} values for {} pixels", layer.words.size(), image.pixel_count());
            planes.push_back({layer.channel, layer.whole ? Imf::UINT : Imf::FLOAT, layer.words.data()});
        }
        return encode_planes(image.width, image.height, image.attributes, planes);
    };
    if (precision == ExrPrecision::Float) return {encode(make_planes(image.channels, Imf::FLOAT, image.data))};
    EncodedExr out;
    std::vector<half> halves(image.data.size());
    for (size_t i = 0; i < halves.size(); ++i) {
        // A finite value must not become infinite; infinities and NaN stay visible.
        const float value = image.data[i], limited = std::isfinite(value) ? std::clamp(value, -kHalfMax, kHalfMax) : value;
        if (std::isfinite(value) && limited != value) ++out.clamped;
        halves[i] = half(limited);
    }
    out.bytes = encode(make_planes(image.channels, Imf::HALF, halves));
    return out;
}

std::vector<std::byte> encode_uint_exr(const UintImage& image) {
    PARHELION_CHECK(image.data.size() == image.channels.size() * image.width * image.height, "an image of {}x{} with {} channels and {} values",
                    image.width, image.height, image.channels.size(), image.data.size());
    return encode_planes(image.width, image.height, image.attributes, make_planes(image.channels, Imf::UINT, image.data));
}

uint64_t write_exr(const std::filesystem::path& path, const ImageF& image, ExrPrecision precision) {
    const EncodedExr encoded = encode_exr(image, precision);
    write_file(path, encoded.bytes);
    return encoded.clamped;
}

}  // namespace parhelion::image
