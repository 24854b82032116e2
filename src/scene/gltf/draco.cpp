#include "scene/gltf/draco.h"

#include <algorithm>
#include <array>

#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/varint_decoding.h>

#include "base/error.h"
#include "scene/gltf/accessors.h"
#include "scene/gltf/draco_attributes.h"

namespace parhelion {

namespace {

// The attributes that primitives are read for.
constexpr std::array<std::string_view, 14> kAttributes = {"POSITION",  "NORMAL",    "TANGENT",   "TEXCOORD_0", "TEXCOORD_1",
                                                          "COLOR_0",   "JOINTS_0",  "JOINTS_1",  "JOINTS_2",   "JOINTS_3",
                                                          "WEIGHTS_0", "WEIGHTS_1", "WEIGHTS_2", "WEIGHTS_3"};

// What the file's accessors leave room for, and the memory at hand.
struct Limits {
    uint64_t faces, points, bytes;
    std::string problem = {};  // what went beyond

    bool take(uint64_t amount, std::string_view what) {
        if (amount > bytes) {
            problem =
                fmt::format("{} would take {} MiB more memory; the budget for this scene has {} MiB left", what, amount >> 20, bytes >> 20);
            return false;
        }
        bytes -= amount;
        return true;
    }
    bool allow(uint64_t count, uint64_t most, std::string_view what) {
        if (count > most) problem = fmt::format("holds {} {}, but its accessors are for {}", count, what, most);
        return count <= most;
    }
};

// Draco believes the counts in its data and allocates before it reads on (seen in 1.5.5). This decoder looks at them first.
// Draco bitstream 2.2, 3.2 and 3.6: counts are variable-length integers.
template <class Base>
class LimitedDecoder : public Base {
public:
    explicit LimitedDecoder(Limits& limits) : limits_(limits) {}

protected:
    bool DecodeConnectivity() override {
        if (this->bitstream_version() < DRACO_BITSTREAM_VERSION(2, 2)) {
            limits_.problem = fmt::format("is of version {}.{} of the Draco bitstream; glTF needs 2.2", this->bitstream_version() >> 8,
                                          this->bitstream_version() & 255);
            return false;
        }
        draco::DecoderBuffer ahead = *this->buffer();  // reads on without moving the decoder
        uint32_t faces = 0, points = 0;
        uint8_t seams = 0;  // attributes with a connectivity of their own
        constexpr bool kEdgebreaker = std::is_same_v<Base, draco::MeshEdgebreakerDecoder>;
        if (!draco::DecodeVarint(kEdgebreaker ? &points : &faces, &ahead) || !draco::DecodeVarint(kEdgebreaker ? &faces : &points, &ahead))
            return false;
        if (kEdgebreaker && !ahead.Decode(&seams)) return false;
        // Edgebreaker counts the vertices before seams part them: there are at most as many as points.
        if (!limits_.allow(faces, limits_.faces, "triangles") || !limits_.allow(points, limits_.points, "vertices")) return false;
        constexpr uint64_t kBytesPerFace = 80, kBytesPerSeamFace = 24;  // corner tables, traversal, faces
        if (!limits_.take(uint64_t(faces) * (kBytesPerFace + kBytesPerSeamFace * seams), "its triangles")) return false;
        return Base::DecodeConnectivity() && limits_.allow(this->mesh()->num_points(), limits_.points, "vertices");
    }

    bool CreateAttributesDecoder(int32_t id) override {
        if (!Base::CreateAttributesDecoder(id)) return false;
        auto& made = const_cast<draco::AttributesDecoderInterface&>(*this->attributes_decoder(id));  // ours to change: it is given out const
        return this->SetAttributesDecoder(id, limited_attributes_decoder(made, uint64_t{3} * this->mesh()->num_faces(), limits_.problem));
    }

    // By now the attributes are known, and have no memory yet.
    bool DecodeAllAttributes() override {
        uint64_t bytes = 0;
        for (int32_t i = 0; i < this->point_cloud()->num_attributes(); ++i) {
            const draco::PointAttribute& attribute = *this->point_cloud()->attribute(i);
            // The values, the integers that they are made of, their entropy-coded form, and the map from points to values.
            constexpr uint64_t kBytesPerComponent = 12, kBytesPerPoint = 8;
            bytes += this->mesh()->num_points() *
                     (uint64_t(attribute.byte_stride()) + kBytesPerComponent * attribute.num_components() + kBytesPerPoint);
        }
        return limits_.take(bytes, "its attributes") && Base::DecodeAllAttributes();
    }

private:
    Limits& limits_;
};

std::unique_ptr<draco::MeshDecoder> make_decoder(const draco::DecoderBuffer& data, Limits& limits) {
    draco::DecoderBuffer ahead = data;
    draco::DracoHeader header;
    if (!draco::PointCloudDecoder::DecodeHeader(&ahead, &header).ok()) return nullptr;
    if (header.encoder_type != draco::TRIANGULAR_MESH) {
        limits.problem = "holds points, not a mesh";
        return nullptr;
    }
    if (header.encoder_method == draco::MESH_EDGEBREAKER_ENCODING)
        return std::make_unique<LimitedDecoder<draco::MeshEdgebreakerDecoder>>(limits);
    if (header.encoder_method == draco::MESH_SEQUENTIAL_ENCODING)
        return std::make_unique<LimitedDecoder<draco::MeshSequentialDecoder>>(limits);
    return nullptr;
}

std::unique_ptr<draco::Mesh> decode_mesh(const JsonRef& extension, std::span<const std::byte> bytes, Limits& limits) {
    draco::DecoderBuffer data;
    data.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    auto mesh = std::make_unique<draco::Mesh>();
    std::string reason;
    try {
        const draco::DecoderOptions options;
        const std::unique_ptr<draco::MeshDecoder> decoder = make_decoder(data, limits);
        if (decoder) {
            const draco::Status status = decoder->Decode(options, &data, mesh.get());
            if (status.ok()) return mesh;
            reason = status.error_msg_string();
        }
    } catch (const std::exception& error) {  // bad_alloc and length_error of Draco's containers
        reason = error.what();
    }
    if (limits.problem.empty())
        limits.problem = fmt::format("its Draco data are damaged{}", reason.empty() ? "" : fmt::format(" ({})", escape_name(reason, 80)));
    extension.fail(limits.problem, "the file is damaged: export it again");
}

// The attribute's value at every point, as elements of `components` numbers of type T.
template <class T>
bool pack(const draco::PointAttribute& attribute, uint32_t points, uint32_t components, std::byte* out) {
    std::array<T, 4> element{};
    for (uint32_t p = 0; p < points; ++p, out += components * sizeof(T)) {
        const draco::AttributeValueIndex value = attribute.mapped_index(draco::PointIndex(p));
        if (value.value() >= attribute.size()) return false;
        if (!attribute.ConvertValue<T>(value, static_cast<int8_t>(components), element.data())) return false;
        std::memcpy(out, element.data(), components * sizeof(T));
    }
    return true;
}

void add_accessor(GltfDocument& document, const draco::Mesh& mesh, const JsonRef& id, const JsonRef& use, DracoGeometry& out) {
    const uint64_t unique_id = id.as_uint(0xFFFFFFFFull);
    const draco::PointAttribute* attribute = mesh.GetAttributeByUniqueId(static_cast<uint32_t>(unique_id));
    if (attribute == nullptr) id.fail(fmt::format("the compressed data have no attribute {}", unique_id));
    const AccessorShape shape = accessor_shape(document, use);
    if (attribute->num_components() != static_cast<int>(shape.components))
        id.fail(fmt::format("attribute {} has {} components, but its accessor has {}", unique_id, attribute->num_components(),
                            shape.components));
    const uint32_t points = mesh.num_points();
    if (points > shape.count) use.fail(fmt::format("is for {} elements, but the compressed data have {}", shape.count, points));
    std::vector<std::byte> bytes(shape.count * shape.element_bytes());  // elements beyond the compressed ones stay zero: nothing names them
    if (!with_component(shape.type, [&](auto tag) { return pack<decltype(tag)>(*attribute, points, shape.components, bytes.data()); }))
        id.fail(fmt::format("attribute {} does not fit the type of its accessor", unique_id));
    out.accessors[use.as_index_of("accessors")] = std::move(bytes);
}

// A Draco mesh is a list of triangles, whatever the mode says; a strip of n indices stands for at most n - 2 of them.
uint64_t most_faces(GltfDocument& document, const JsonRef& primitive, uint64_t points) {
    const std::optional<JsonRef> indices = primitive.find("indices");
    const uint64_t mode = primitive.uint("mode", 4, 6), corners = indices ? accessor_shape(document, *indices).count : points;
    if (mode != 4 && mode != 5)
        primitive.fail(fmt::format("is compressed, but of mode {}", mode), "only triangles (4) and strips (5) can be");
    return mode == 4 ? corners / 3 : corners;
}

}  // namespace

DracoGeometry decode_draco(GltfDocument& document, const JsonRef& primitive, const JsonRef& extension) {
    const JsonRef attributes = primitive.at("attributes"), ids = extension.at("attributes");
    const uint64_t points = accessor_shape(document, attributes.at("POSITION")).count;
    Limits limits{.faces = most_faces(document, primitive, points), .points = points, .bytes = document.files().budget_left()};
    std::vector<std::string_view> present;
    for (const std::string_view name : kAttributes) {
        if (!ids.find(name) || !attributes.find(name)) continue;
        present.push_back(name);
        const AccessorShape shape = accessor_shape(document, attributes.at(name));
        if (!limits.take(shape.count * shape.element_bytes(), name)) extension.fail(limits.problem, "the file is damaged: export it again");
    }
    const std::unique_ptr<draco::Mesh> mesh = decode_mesh(extension, document.view(extension.at("bufferView")).bytes, limits);

    DracoGeometry out;
    for (const std::string_view name : present) add_accessor(document, *mesh, ids.at(name), attributes.at(name), out);
    document.files().charge(uint64_t(mesh->num_faces()) * sizeof(glm::uvec3), extension.where());
    out.triangles.reserve(mesh->num_faces());
    for (uint32_t f = 0; f < mesh->num_faces(); ++f) {
        const draco::Mesh::Face& face = mesh->face(draco::FaceIndex(f));
        const glm::uvec3 t(face[0].value(), face[1].value(), face[2].value());
        if (std::max({t.x, t.y, t.z}) >= mesh->num_points()) extension.fail(fmt::format("triangle {} names a vertex that is not there", f));
        if (t.x != t.y && t.y != t.z && t.z != t.x) out.triangles.push_back(t);
    }
    return out;
}

}  // namespace parhelion
