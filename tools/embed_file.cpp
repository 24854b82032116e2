// embed_file INPUT OUTPUT.cpp NAME [zstd]: the bytes of a file as parhelion::embedded::NAME and NAME_size; with zstd packed, a frame that
// knows its size.
// A string literal compiles far faster than a list of numbers.
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>

#include <zstd.h>

int main(int argc, char** argv) {
    if (argc != 4 && !(argc == 5 && std::string(argv[4]) == "zstd")) return std::fprintf(stderr, "usage: embed_file INPUT OUTPUT.cpp NAME [zstd]\n"), 2;
    std::ifstream in(argv[1], std::ios::binary);
    std::string bytes((std::istreambuf_iterator<char>(in)), {});
    if (!in) return std::fprintf(stderr, "embed_file: %s cannot be read\n", argv[1]), 1;
    if (argc == 5) {
        std::string packed(ZSTD_compressBound(bytes.size()), '\0');
        const size_t size = ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), 12);
        if (ZSTD_isError(size)) return std::fprintf(stderr, "embed_file: %s\n", ZSTD_getErrorName(size)), 1;
        packed.resize(size);
        bytes = std::move(packed);
    }
    std::ofstream out(argv[2], std::ios::binary);
    const std::string name = argv[3];
    out << "#include <cstddef>\nnamespace parhelion::embedded {\nextern const size_t " << name << "_size;\nconst size_t " << name
        << "_size = " << bytes.size() << ";\nextern const unsigned char " << name << "[];\nalignas(8) const unsigned char " << name << "[] =\n";
    static const char digits[] = "01234567";
    for (size_t i = 0; i < bytes.size(); i += 64) {
        std::string line = "\"";
        for (size_t k = i; k < bytes.size() && k < i + 64; ++k) {
            const unsigned char c = static_cast<unsigned char>(bytes[k]);
            line += {'\\', digits[c >> 6], digits[(c >> 3) & 7], digits[c & 7]};
        }
        out << line << "\"\n";
    }
    out << ";\n}\n";
    return out ? 0 : 1;
}
