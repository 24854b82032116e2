// Radiance RGBE pictures. Format: Ward, "Real Pixels", Graphics Gems II, 1991, and the Radiance file format notes ("Radiance
// Picture Format", filefmts.pdf): a text header, a resolution line, scanlines that are flat or run-length coded in either way.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "image/limits.h"

namespace parhelion::image {

namespace {

using Rgbe = std::array<uint8_t, 4>;

class Input {
public:
    Input(std::span<const std::byte> bytes, std::string_view where) : bytes_(bytes), where_(where) {}

    [[noreturn]] void fail(std::string_view what) const { refuse_image(where_, fmt::format("is a damaged Radiance HDR: {}", what)); }

    uint8_t next() {
        if (position_ >= bytes_.size()) fail("the file ends early");
        return std::to_integer<uint8_t>(bytes_[position_++]);
    }
    Rgbe next_pixel() { return {next(), next(), next(), next()}; }
    // Up to the line feed, which is swallowed.
    std::string next_line() {
        std::string line;
        for (uint8_t c = next(); c != '\n'; c = next()) {
            line += static_cast<char>(c);
            if (line.size() > 4096) fail("a header line without end");
        }
        return line;
    }
    // The next four bytes, without moving on; zeros where the file ends.
    Rgbe peek() const {
        Rgbe out{};
        for (size_t i = 0; i < 4 && position_ + i < bytes_.size(); ++i) out[i] = std::to_integer<uint8_t>(bytes_[position_ + i]);
        return out;
    }

private:
    std::span<const std::byte> bytes_;
    std::string_view where_;
    size_t position_ = 0;
};

// One axis of the resolution line: "-Y 512" counts 512 rows downwards.
struct Axis {
    char name;  // X or Y
    bool decreasing;
    uint32_t length;
};

Axis read_axis(Input& input, std::string_view sign_and_name, std::string_view number) {
    if (sign_and_name.size() != 2 || (sign_and_name[0] != '-' && sign_and_name[0] != '+') || (sign_and_name[1] != 'X' && sign_and_name[1] != 'Y'))
        input.fail("the resolution line is not of the form -Y HEIGHT +X WIDTH");
    Axis axis{sign_and_name[1], sign_and_name[0] == '-', 0};
    const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), axis.length);
    if (error != std::errc() || end != number.data() + number.size()) input.fail("the resolution line holds a bad number");
    return axis;
}

std::array<Axis, 2> read_resolution(Input& input) {
    const std::string line = input.next_line();
    std::array<std::string_view, 4> words;
    std::string_view rest = line;
    for (std::string_view& word : words) {
        rest.remove_prefix(std::min(rest.find_first_not_of(' '), rest.size()));
        word = rest.substr(0, rest.find(' '));
        rest.remove_prefix(word.size());
    }
    const std::array<Axis, 2> axes = {read_axis(input, words[0], words[1]), read_axis(input, words[2], words[3])};
    if (axes[0].name == axes[1].name) input.fail("the resolution line names one axis twice");
    return axes;
}

// Returns the EXPOSURE lines' product as text, empty if there is none.
std::string read_header(Input& input, std::string_view where) {
    std::string exposure;
    double product = 1.0;
    input.next_line();  // the magic
    for (std::string line = input.next_line(); !line.empty(); line = input.next_line()) {
        if (line.starts_with("FORMAT=") && line != "FORMAT=32-bit_rle_rgbe")
            refuse_image(where, fmt::format("is a Radiance HDR with {}, which is not supported", escape_name(line)), "convert it to 32-bit_rle_rgbe");
        if (!line.starts_with("EXPOSURE=")) continue;
        const size_t digits = std::min(line.find_first_not_of(' ', 9), line.size());
        double value = 0;
        if (std::from_chars(line.data() + digits, line.data() + line.size(), value).ec != std::errc()) continue;
        product *= value;
        exposure = fmt::format("{}", product);
    }
    return exposure;
}

// The coding of 1991: a pixel (1, 1, 1, n) repeats the one before n times; consecutive ones are higher bytes of one count.
void read_old_scanline(Input& input, std::span<Rgbe> line) {
    unsigned shift = 0;
    for (size_t i = 0; i < line.size();) {
        const Rgbe pixel = input.next_pixel();
        if (pixel[0] != 1 || pixel[1] != 1 || pixel[2] != 1) {
            line[i++] = pixel;
            shift = 0;
            continue;
        }
        const uint64_t count = shift < 32 ? uint64_t{pixel[3]} << shift : line.size() + 1;
        if (i == 0 || count > line.size() - i) input.fail("a run leaves its scanline");
        for (uint64_t k = 0; k < count; ++k, ++i) line[i] = line[i - 1];
        shift += 8;
    }
}

// The coding since 1991: the four components one after the other, each in runs (> 128) and literal stretches.
void read_new_scanline(Input& input, std::span<Rgbe> line) {
    for (size_t component = 0; component < 4; ++component) {
        for (size_t i = 0; i < line.size();) {
            const uint8_t code = input.next();
            const size_t count = code > 128 ? code - 128u : code;
            if (count == 0 || count > line.size() - i) input.fail("a run leaves its scanline");
            uint8_t value = code > 128 ? input.next() : uint8_t{0};
            for (size_t k = 0; k < count; ++k) {
                if (code <= 128) value = input.next();
                line[i++][component] = value;
            }
        }
    }
}

void read_scanline(Input& input, std::span<Rgbe> line) {
    const Rgbe start = input.peek();
    const bool is_new = line.size() >= 8 && line.size() <= 0x7FFF && start[0] == 2 && start[1] == 2 && start[2] < 128;
    if (!is_new) return read_old_scanline(input, line);
    input.next_pixel();
    if (((size_t{start[2]} << 8) | start[3]) != line.size()) input.fail("a scanline of another length than the image");
    read_new_scanline(input, line);
}

}  // namespace

ImageF decode_hdr(std::span<const std::byte> bytes, const DecodeLimits& limits, std::string_view where) {
    Input input(bytes, where);
    const std::string exposure = read_header(input, where);
    const auto [outer, inner] = read_resolution(input);
    const uint32_t width = outer.name == 'X' ? outer.length : inner.length, height = outer.name == 'Y' ? outer.length : inner.length;
    check_limits(width, height, 3 * sizeof(float), limits, where);

    ImageF image = make_image(width, height, {"R", "G", "B"});
    if (!exposure.empty()) image.attributes["EXPOSURE"] = exposure;
    std::vector<Rgbe> line(inner.length);
    const auto coordinate = [](const Axis& axis, uint32_t i) {
        // Y grows upwards in the file's terms, rows grow downwards here: "-Y" and "+X" are the natural order.
        const bool natural = axis.name == 'Y' ? axis.decreasing : !axis.decreasing;
        return natural ? i : axis.length - 1 - i;
    };
    for (uint32_t o = 0; o < outer.length; ++o) {
        read_scanline(input, line);
        for (uint32_t i = 0; i < inner.length; ++i) {
            const uint32_t x = outer.name == 'X' ? coordinate(outer, o) : coordinate(inner, i);
            const uint32_t y = outer.name == 'Y' ? coordinate(outer, o) : coordinate(inner, i);
            const float scale = line[i][3] == 0 ? 0.0f : std::ldexp(1.0f, line[i][3] - 136);
            for (size_t c = 0; c < 3; ++c) image.data[c * image.pixel_count() + size_t{y} * width + x] = static_cast<float>(line[i][c]) * scale;
        }
    }
    return image;
}

}  // namespace parhelion::image
