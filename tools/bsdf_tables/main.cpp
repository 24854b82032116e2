// Writes the tables of directional albedos that shaders/shared/bsdf_tables.h describes, one file a section:
//     g++ -std=c++20 -O2 -Ishaders tools/bsdf_tables/*.cpp -o make_bsdf_tables && ./make_bsdf_tables src/scene_gpu [SECTION...]
// By deterministic quadrature in double precision; some minutes.
#include <bit>
#include <cstdio>
#include <fstream>
#include <string>

#include "shared/bsdf_tables.h"
#include "tables.h"

namespace {

struct Section {
    const char* name;
    tables::Words (*make)();
    size_t words;
};
constexpr Section kSections[] = {
    {"ggx", tables::make_ggx, parhelion::shared::kGgxWords},
    {"layers", tables::make_layers, parhelion::shared::kLayersWords},
    {"glass", tables::make_glass, parhelion::shared::kGlassWords},
    {"coated_glass", tables::make_coated_glass, parhelion::shared::kCoatedGlassWords},
};

bool write(const Section& section) {
    const tables::Words words = section.make();
    if (words.size() != section.words) return std::fprintf(stderr, "%s: %zu words, %zu are declared\n", section.name, words.size(), section.words), false;
    std::ofstream out(tables::folder + "/bsdf_" + section.name + ".bin", std::ios::binary);
    for (const uint32_t word : words)
        for (int shift = 0; shift < 32; shift += 8) out.put(static_cast<char>(word >> shift));
    return static_cast<bool>(out.flush());
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2) return std::fprintf(stderr, "usage: make_bsdf_tables FOLDER [SECTION...]\n"), 2;
    tables::folder = argv[1];
    for (const Section& section : kSections) {
        bool wanted = argc == 2;
        for (int k = 2; k < argc; ++k) wanted |= std::string(argv[k]) == section.name;
        if (wanted && !write(section)) return 1;
    }
    return 0;
}
