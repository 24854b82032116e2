#include "scene/gltf/write.h"

#include <algorithm>
#include <cstring>
#include <memory>

#include "base/error.h"
#include "base/file.h"
#include "scene/gltf/write_parts.h"

namespace parhelion {

namespace fs = std::filesystem;
using gltf::Json;

namespace gltf {

void Writer::warn(std::string text) {
    if (std::ranges::find(warnings, text) == warnings.end()) warnings.push_back(std::move(text));
}

std::string percent_encode(std::string_view name) {
    std::string out;
    for (const char c : name) {
        const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || std::strchr("-._~", c) != nullptr;
        out += plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
    }
    return out;
}

}  // namespace gltf

namespace {

std::string extension_of(const fs::path& path) {
    std::string extension = path.extension().string();
    std::ranges::transform(extension, extension.begin(), [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    return extension;
}

void write_tables(gltf::Writer& writer) {
    gltf::write_images(writer);
    gltf::write_textures(writer);
    gltf::write_materials(writer);
    gltf::write_meshes(writer);
    gltf::write_nodes(writer);
    gltf::write_skins(writer);
    gltf::write_animations(writer);
    if (!writer.scene.environment().black()) writer.warn("the environment is left out: glTF has none (--env F.hdr lights the file)");
}

// The whole JSON, its members in the order in which a reader wants them.
Json assemble(gltf::Writer& writer, const GltfWriteOptions& options, const std::string& buffer_uri) {
    Json out{{"asset", {{"version", "2.0"}, {"generator", options.generator}}}};
    if (const std::string& copyright = writer.scene.source().copyright; !copyright.empty()) out["asset"]["copyright"] = copyright;
    if (!writer.used.empty()) out["extensionsUsed"] = writer.used;
    if (!writer.required.empty()) out["extensionsRequired"] = writer.required;
    for (const char* key : {"extensions", "scene", "scenes", "nodes", "cameras", "meshes", "skins", "animations", "materials", "textures", "images", "samplers"})
        if (const auto found = writer.root.find(key); found != writer.root.end()) out[key] = std::move(*found);
    const auto add = [&](const char* key, const Json& table) {
        if (!table.empty()) out[key] = table;
    };
    add("accessors", writer.buffer.accessors());
    add("bufferViews", writer.buffer.views());
    if (writer.buffer.size() != 0) {
        Json buffer{{"byteLength", writer.buffer.size()}};
        if (!buffer_uri.empty()) buffer["uri"] = gltf::percent_encode(buffer_uri);
        out["buffers"] = Json::array({std::move(buffer)});
    }
    return out;
}

std::string text_of(const Json& json, int indent) { return json.dump(indent, ' ', false, Json::error_handler_t::replace); }

// Header, JSON chunk padded with spaces, binary chunk padded with zeros (4.4).
struct Glb {
    std::string text;
    uint32_t head[5] = {}, binary_head[2] = {};
    std::vector<std::span<const std::byte>> parts;
    uint64_t size = 0;
};

void make_glb(Glb& glb, const gltf::Writer& writer, const GltfWriteOptions& options) {
    glb.text.append((4 - glb.text.size() % 4) % 4, ' ');
    const uint64_t binary = writer.buffer.size();
    glb.size = sizeof(glb.head) + glb.text.size() + (binary != 0 ? sizeof(glb.binary_head) + binary : 0);
    if (glb.size > options.max_glb_bytes)
        throw Error(ErrorCode::Failed, fmt::format("needs {} bytes, but a .glb ends at {}", glb.size, options.max_glb_bytes), {},
                    "name the output .gltf: its buffer is a file of its own");
    const uint32_t head[5] = {0x46546C67, 2, static_cast<uint32_t>(glb.size), static_cast<uint32_t>(glb.text.size()), 0x4E4F534A};
    std::ranges::copy(head, glb.head);
    glb.parts = {std::as_bytes(std::span(glb.head)), std::as_bytes(std::span(glb.text))};
    if (binary == 0) return;
    glb.binary_head[0] = static_cast<uint32_t>(binary);
    glb.binary_head[1] = 0x004E4942;
    glb.parts.push_back(std::as_bytes(std::span(glb.binary_head)));
    glb.parts.insert(glb.parts.end(), writer.buffer.parts().begin(), writer.buffer.parts().end());
}

// Files that appear together: all are written before the first is renamed.
class FileSet {
public:
    explicit FileSet(const fs::path& main) : main_(main), replaces_(fs::exists(main)) {}

    void add(const fs::path& path, std::span<const std::span<const std::byte>> parts) {
        check_writable(path);
        if (path != main_ && fs::exists(path) && !replaces_)
            throw Error(ErrorCode::Failed, fmt::format("is there already and is no part of '{}'", escape_name(main_.filename().string())),
                        escape_name(path.string()), "choose another name or folder");
        files_.push_back(std::make_unique<AtomicFile>(path));
        files_.back()->write_parts(parts);
        written_.files.push_back(path);
        for (const std::span<const std::byte> part : parts) written_.bytes += part.size();
    }
    GltfWritten commit() {
        for (const std::unique_ptr<AtomicFile>& file : files_) file->commit();
        return std::move(written_);
    }

private:
    fs::path main_;
    bool replaces_;
    std::vector<std::unique_ptr<AtomicFile>> files_;
    GltfWritten written_;
};

}  // namespace

bool is_gltf_name(const fs::path& path) { return extension_of(path) == ".glb" || extension_of(path) == ".gltf"; }

std::vector<std::byte> write_glb(const Scene& scene, const GltfWriteOptions& options, std::vector<std::string>* warnings) {
    gltf::Writer writer{.scene = scene, .stem = {}};
    write_tables(writer);
    Glb glb{.text = text_of(assemble(writer, options, {}), -1)};
    make_glb(glb, writer, options);
    std::vector<std::byte> out;
    out.reserve(glb.size);
    for (const std::span<const std::byte> part : glb.parts) out.insert(out.end(), part.begin(), part.end());
    if (warnings != nullptr) *warnings = std::move(writer.warnings);
    return out;
}

GltfWritten write_gltf(const Scene& scene, const fs::path& path, const GltfWriteOptions& options) {
    if (!is_gltf_name(path)) throw Error(ErrorCode::Usage, "is neither .glb nor .gltf", escape_name(path.string()), "the extension chooses the form");
    const bool binary = extension_of(path) == ".glb";
    gltf::Writer writer{.scene = scene, .stem = binary ? std::string{} : path.stem().string()};
    write_tables(writer);
    FileSet files(path);
    try {
        if (binary) {
            Glb glb{.text = text_of(assemble(writer, options, {}), -1)};
            make_glb(glb, writer, options);
            files.add(path, glb.parts);
        } else {
            const std::string buffer_name = writer.stem + ".bin", text = text_of(assemble(writer, options, buffer_name), 2) + "\n";
            if (writer.buffer.size() != 0) files.add(path.parent_path() / buffer_name, writer.buffer.parts());
            for (const gltf::SideFile& image : writer.side_files) files.add(path.parent_path() / image.name, {&image.bytes, 1});
            const std::span<const std::byte> bytes = std::as_bytes(std::span(text));
            files.add(path, {&bytes, 1});
        }
    } catch (const Error& error) {
        if (!error.where.empty()) throw;
        throw Error(error.code, error.problem, escape_name(path.string()), error.hint);
    }
    GltfWritten written = files.commit();
    written.warnings = std::move(writer.warnings);
    return written;
}

}  // namespace parhelion
