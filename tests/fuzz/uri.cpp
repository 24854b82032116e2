// URIs against a folder: whatever they say, a file outside of it is never read. The folder holds a file, a folder and links, one of them
// leading out.
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string_view>

#include <unistd.h>

#include "base/error.h"
#include "base/file.h"
#include "scene/scene_files.h"

namespace {

namespace fs = std::filesystem;

struct Folder {
    fs::path top = fs::temp_directory_path() / ("parhelion-fuzz-uri-" + std::to_string(getpid())), root = top / "in";
    Folder() {
        fs::create_directories(root / "sub");
        parhelion::write_text_file(top / "out.bin", "outside");
        parhelion::write_text_file(root / "a.bin", "inside");
        fs::create_symlink("../out.bin", root / "link");
        fs::create_symlink("..", root / "up");
        fs::create_symlink("../a.bin", root / "sub" / "back");
    }
    ~Folder() {
        std::error_code ignored;
        fs::remove_all(top, ignored);
    }
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    static const Folder folder;
    const std::string_view uri(reinterpret_cast<const char*>(data), size);
    try {
        parhelion::SceneFiles files(folder.root);
        const parhelion::SceneFiles::Bytes bytes = files.read_uri(uri, "fuzz");
        if (!parhelion::is_data_uri(uri) && (bytes->size() != 6 || static_cast<char>(bytes->front()) != 'i')) std::abort();
    } catch (const parhelion::Error&) {
        // The answer to a URI that leads nowhere, or out.
    }
    return 0;
}
