// PNG through libpng. Its errors are longjmps: each setjmp sits in a function of its own without C++ objects on its stack; all
// that needs freeing is owned by the caller's frame.
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <new>

#include <png.h>

#include "base/file.h"
#include "image/encode.h"
#include "image/limits.h"

namespace parhelion::image {

namespace {

// A deflate stream grows by at most 1032 times (zlib's technical notes).
constexpr uint64_t kMaxDeflateRatio = 1032;

struct PngJob {
    png_structp png = nullptr;
    png_infop info = nullptr;
    char message[128] = "damaged";
    std::span<const std::byte> input;  // reading
    std::vector<std::byte> output;     // writing

    PngJob() = default;
    PngJob(const PngJob&) = delete;
    PngJob& operator=(const PngJob&) = delete;
};

struct PngReader : PngJob {
    ~PngReader() { png_destroy_read_struct(&png, &info, nullptr); }
};
struct PngWriter : PngJob {
    ~PngWriter() { png_destroy_write_struct(&png, &info); }
};

void on_error(png_structp png, png_const_charp message) {
    auto* job = static_cast<PngJob*>(png_get_error_ptr(png));
    std::snprintf(job->message, sizeof(job->message), "%s", message);
    png_longjmp(png, 1);
}

void on_warning(png_structp, png_const_charp) {}

void read_bytes(png_structp png, png_bytep out, size_t size) {
    auto* job = static_cast<PngJob*>(png_get_io_ptr(png));
    if (size > job->input.size()) png_error(png, "the file ends early");
    std::memcpy(out, job->input.data(), size);
    job->input = job->input.subspan(size);
}

void write_bytes(png_structp png, png_bytep bytes, size_t size) {
    auto* job = static_cast<PngJob*>(png_get_io_ptr(png));
    bool stored = true;
    try {
        const auto* begin = reinterpret_cast<const std::byte*>(bytes);
        job->output.insert(job->output.end(), begin, begin + size);
    } catch (const std::bad_alloc&) {
        stored = false;
    }
    if (!stored) png_error(png, "out of memory");
}

void flush_bytes(png_structp) {}

bool read_header(PngJob& job) {
    if (setjmp(png_jmpbuf(job.png))) return false;
    png_set_read_fn(job.png, &job, read_bytes);
    png_set_user_limits(job.png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);  // ours are stricter and say more
    png_read_info(job.png, job.info);
    return true;
}

bool ask_for_rgba8(PngJob& job) {
    if (setjmp(png_jmpbuf(job.png))) return false;
    const int color = png_get_color_type(job.png, job.info);
    const bool has_alpha = (color & PNG_COLOR_MASK_ALPHA) != 0 || png_get_valid(job.png, job.info, PNG_INFO_tRNS) != 0;
    png_set_expand(job.png);
    png_set_scale_16(job.png);
    if ((color & PNG_COLOR_MASK_COLOR) == 0) png_set_gray_to_rgb(job.png);
    if (!has_alpha) png_set_add_alpha(job.png, 0xFF, PNG_FILLER_AFTER);
    png_set_interlace_handling(job.png);
    png_read_update_info(job.png, job.info);
    return true;
}

bool read_rows(PngJob& job, png_bytepp rows) {
    if (setjmp(png_jmpbuf(job.png))) return false;
    png_read_image(job.png, rows);
    png_read_end(job.png, nullptr);
    return true;
}

bool write_all(PngJob& job, uint32_t width, uint32_t height, bool with_alpha, std::span<const png_text> texts, png_bytepp rows) {
    if (setjmp(png_jmpbuf(job.png))) return false;
    png_set_write_fn(job.png, &job, write_bytes, flush_bytes);
    png_set_user_limits(job.png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
    png_set_IHDR(job.png, job.info, width, height, 8, with_alpha ? PNG_COLOR_TYPE_RGB_ALPHA : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    if (!with_alpha) png_set_sRGB(job.png, job.info, PNG_sRGB_INTENT_RELATIVE);
    if (!texts.empty()) png_set_text(job.png, job.info, texts.data(), static_cast<int>(texts.size()));
    png_write_info(job.png, job.info);
    png_write_image(job.png, rows);
    png_write_end(job.png, nullptr);
    return true;
}

// libpng reads what these point to.
std::vector<png_text> text_chunks(const Attributes& attributes) {
    std::vector<png_text> texts;
    for (const auto& [name, value] : attributes) {
        png_text text{};
        text.compression = PNG_TEXT_COMPRESSION_NONE;
        text.key = const_cast<char*>(name.c_str());
        text.text = const_cast<char*>(value.c_str());
        text.text_length = value.size();
        texts.push_back(text);
    }
    return texts;
}

Attributes read_attributes(const PngJob& job) {
    png_textp texts = nullptr;
    const int count = png_get_text(job.png, job.info, &texts, nullptr);
    Attributes attributes;
    for (int i = 0; i < count; ++i)
        if (texts[i].compression == PNG_TEXT_COMPRESSION_NONE && texts[i].text) attributes[texts[i].key] = texts[i].text;
    return attributes;
}

std::vector<std::byte> encode(uint32_t width, uint32_t height, bool with_alpha, const Attributes& attributes, const std::vector<uint8_t>& pixels) {
    const size_t row_bytes = (with_alpha ? size_t{4} : size_t{3}) * width;
    PARHELION_CHECK(pixels.size() == row_bytes * height && !pixels.empty(), "a picture of {}x{} with {} bytes", width, height, pixels.size());
    PngWriter writer;
    writer.png = png_create_write_struct(PNG_LIBPNG_VER_STRING, static_cast<PngJob*>(&writer), on_error, on_warning);
    if (writer.png) writer.info = png_create_info_struct(writer.png);
    if (!writer.info) throw Error(ErrorCode::Failed, "the PNG cannot be encoded: out of memory");
    std::vector<png_bytep> rows(height);
    for (size_t y = 0; y < rows.size(); ++y) rows[y] = const_cast<png_bytep>(pixels.data() + y * row_bytes);
    const std::vector<png_text> texts = text_chunks(attributes);
    if (!write_all(writer, width, height, with_alpha, texts, rows.data()))
        throw Error(ErrorCode::Failed, fmt::format("the PNG cannot be encoded: {}", writer.message));
    return std::move(writer.output);
}

}  // namespace

Texture8 decode_png(std::span<const std::byte> bytes, const DecodeLimits& limits, std::string_view where) {
    PngReader reader;
    reader.input = bytes;
    reader.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, static_cast<PngJob*>(&reader), on_error, on_warning);
    if (reader.png) reader.info = png_create_info_struct(reader.png);
    if (!reader.info) refuse_image(where, "cannot be decoded: out of memory");
    const auto refuse = [&] { refuse_image(where, fmt::format("is a damaged PNG: {}", escape_name(reader.message))); };
    if (!read_header(reader)) refuse();

    Texture8 out{.width = png_get_image_width(reader.png, reader.info), .height = png_get_image_height(reader.png, reader.info)};
    check_limits(out.width, out.height, 4, limits, where);
    if (uint64_t{png_get_rowbytes(reader.png, reader.info)} * out.height > (bytes.size() + 64) * kMaxDeflateRatio)
        refuse_image(where, "is a damaged PNG: the file is too small for its size in pixels");
    if (!ask_for_rgba8(reader)) refuse();
    const size_t row_bytes = size_t{4} * out.width;
    PARHELION_CHECK(png_get_rowbytes(reader.png, reader.info) == row_bytes, "libpng rows are not RGBA8");

    out.rgba.resize(row_bytes * out.height);
    std::vector<png_bytep> rows(out.height);
    for (size_t y = 0; y < rows.size(); ++y) rows[y] = out.rgba.data() + y * row_bytes;
    if (!read_rows(reader, rows.data())) refuse();
    out.attributes = read_attributes(reader);
    return out;
}

std::vector<std::byte> encode_png(const Picture8& picture) { return encode(picture.width, picture.height, false, picture.attributes, picture.rgb); }
std::vector<std::byte> encode_png(const Texture8& texture) { return encode(texture.width, texture.height, true, {}, texture.rgba); }

void write_png(const std::filesystem::path& path, const Picture8& picture) { write_file(path, encode_png(picture)); }

}  // namespace parhelion::image
