#pragma once
// A glTF or GLB file as its parts: the JSON and the buffers, both checked, nothing interpreted yet.
#include <algorithm>
#include <cstddef>
#include <map>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "scene/gltf/json.h"
#include "scene/scene_files.h"

namespace parhelion {

class GltfDocument {
public:
    // `file`: the bytes of a .gltf or .glb (told apart by their first four bytes); must outlive the document. `name`: for errors.
    // Throws Error for a broken container, JSON, version, or a required extension that is not supported.
    GltfDocument(SceneFiles& files, std::span<const std::byte> file, std::string name);

    JsonRef root() const { return json_->root(); }
    SceneFiles& files() { return files_; }
    // An element of a root array; `ref` is the number that names it.
    JsonRef entry(std::string_view table, const JsonRef& ref) const { return root().at(table)[ref.as_index_of(table)]; }

    // The bytes of a buffer view, `ref` being its number; read from file on first use, bounds checked, meshopt compression undone
    // (once a view; its fallback buffer is never read).
    struct View {
        std::span<const std::byte> bytes;
        uint32_t stride = 0;  // 0: tightly packed
    };
    View view(const JsonRef& ref);

    // Accessors whose data come from the primitive that is being read (KHR_draco_mesh_compression) and not from their buffer view:
    // elements without gaps, by the accessor's number. Set before the primitive is read, emptied after.
    using DecodedAccessors = std::map<uint32_t, std::vector<std::byte>>;
    void set_decoded(DecodedAccessors accessors) { decoded_accessors_ = std::move(accessors); }
    const std::vector<std::byte>* decoded(uint32_t accessor) const {
        const auto found = decoded_accessors_.find(accessor);
        return found == decoded_accessors_.end() ? nullptr : &found->second;
    }

    // The picture is still right, or as right as can be: kept for the user, each text once.
    void warn(std::string text);
    void warn(const JsonRef& place, std::string_view text);
    // Something that this extension says is not in the picture.
    void leave_out(std::string_view extension);
    std::vector<std::string> take_warnings() { return std::move(warnings_); }

    const std::vector<std::string>& extensions_used() const { return used_; }
    bool uses(std::string_view extension) const {  // used or required
        const auto in = [&](const std::vector<std::string>& list) { return std::find(list.begin(), list.end(), extension) != list.end(); };
        return in(used_) || in(required_);
    }
    const std::vector<std::string>& extensions_required() const { return required_; }
    const std::vector<std::string>& extensions_not_drawn() const { return not_drawn_; }

private:
    std::string_view read_container(std::span<const std::byte> file);
    void check_version() const;
    void check_extensions();
    std::span<const std::byte> buffer(uint32_t index);
    std::span<const std::byte> slice(const JsonRef& json);

    SceneFiles& files_;
    std::string name_;
    std::unique_ptr<JsonDocument> json_;
    std::optional<std::span<const std::byte>> binary_chunk_;
    std::map<uint32_t, SceneFiles::Bytes> buffers_;
    std::map<uint32_t, std::vector<std::byte>> decompressed_views_;
    DecodedAccessors decoded_accessors_;
    std::vector<std::string> used_, required_, not_drawn_, warnings_;
    std::set<std::string> warned_;
};

}  // namespace parhelion
