// JPEG through libjpeg-turbo. Its errors are longjmps: each setjmp sits in a function of its own without C++ objects on its
// stack.
#include <algorithm>
#include <csetjmp>
#include <cstdio>
#include <cstring>

#include <jpeglib.h>
// After jpeglib.h, which it needs.
#include <jerror.h>

#include "image/limits.h"

namespace parhelion::image {

namespace {

// A progressive file may hold thousands of scans of a large image in few bytes; encoders write about ten.
constexpr int kMaxScans = 200;

struct JpegReader {
    jpeg_decompress_struct info{};
    jpeg_error_mgr errors{};
    jpeg_progress_mgr progress{};
    std::jmp_buf jump;
    char message[JMSG_LENGTH_MAX] = "damaged";

    JpegReader() = default;
    JpegReader(const JpegReader&) = delete;
    JpegReader& operator=(const JpegReader&) = delete;
    ~JpegReader() { jpeg_destroy_decompress(&info); }
};

[[noreturn]] void fail(j_common_ptr info) {
    auto* reader = static_cast<JpegReader*>(info->client_data);
    info->err->format_message(info, reader->message);
    std::longjmp(reader->jump, 1);
}

// Warnings are survivable by the library's opinion; missing data is not by ours.
void on_message(j_common_ptr info, int level) {
    if (level >= 0) return;
    switch (info->err->msg_code) {
        case JWRN_JPEG_EOF:
        case JWRN_HIT_MARKER:
        case JWRN_HUFF_BAD_CODE:
        case JWRN_ARITH_BAD_CODE:
        case JWRN_MUST_RESYNC: fail(info);
        default: break;
    }
}

void on_progress(j_common_ptr info) {
    auto* reader = static_cast<JpegReader*>(info->client_data);
    if (reader->info.input_scan_number <= kMaxScans) return;
    std::snprintf(reader->message, sizeof(reader->message), "more than %d scans", kMaxScans);
    std::longjmp(reader->jump, 1);
}

bool read_header(JpegReader& reader, const unsigned char* bytes, unsigned long size) {
    reader.info.err = jpeg_std_error(&reader.errors);
    reader.errors.error_exit = fail;
    reader.errors.emit_message = on_message;
    reader.info.client_data = &reader;
    if (setjmp(reader.jump)) return false;
    jpeg_create_decompress(&reader.info);
    reader.progress.progress_monitor = on_progress;
    reader.info.progress = &reader.progress;
    jpeg_mem_src(&reader.info, bytes, size);
    jpeg_read_header(&reader.info, TRUE);
    return true;
}

bool read_rows(JpegReader& reader, uint8_t* out) {
    if (setjmp(reader.jump)) return false;
    jpeg_start_decompress(&reader.info);
    const size_t row_bytes = size_t{4} * reader.info.output_width;
    while (reader.info.output_scanline < reader.info.output_height) {
        JSAMPROW row = out + reader.info.output_scanline * row_bytes;
        jpeg_read_scanlines(&reader.info, &row, 1);
    }
    jpeg_finish_decompress(&reader.info);
    return true;
}

}  // namespace

Texture8 decode_jpeg(std::span<const std::byte> bytes, const DecodeLimits& limits, std::string_view where) {
    JpegReader reader;
    const auto refuse = [&] { refuse_image(where, fmt::format("is a damaged JPEG: {}", escape_name(reader.message))); };
    if (!read_header(reader, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size())) refuse();

    Texture8 out{.width = reader.info.image_width, .height = reader.info.image_height};
    // A file of several scans keeps all coefficients until the last, 2 bytes each.
    const uint64_t coefficient_bytes = jpeg_has_multiple_scans(&reader.info) ? uint64_t{2} * static_cast<uint64_t>(reader.info.num_components) : 0;
    check_limits(out.width, out.height, 4 + coefficient_bytes, limits, where);
    if (reader.info.jpeg_color_space == JCS_CMYK || reader.info.jpeg_color_space == JCS_YCCK)
        refuse_image(where, "is a CMYK JPEG, which is not supported", "save it as RGB");
    reader.info.out_color_space = JCS_EXT_RGBA;
    // Beyond this the library fails by itself.
    reader.info.mem->max_memory_to_use = static_cast<long>(std::min<uint64_t>(4 * limits.max_bytes, uint64_t{1} << 40));
    out.rgba.resize(size_t{4} * out.width * out.height);
    if (!read_rows(reader, out.rgba.data())) refuse();
    return out;
}

}  // namespace parhelion::image
