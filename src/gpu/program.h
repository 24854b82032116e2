#pragma once
// Shader programs: SPIR-V with its reflection, made into pipelines. Shaders are compiled at build time into one pack
// (tools/shader_pack.cpp) that is embedded; PARHELION_SHADER_DIR names a folder with a `shaders.pack` to use instead.
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "gpu/device.h"
#include "gpu/resources.h"

namespace parhelion::gpu {

enum class Stage : uint32_t { Compute, Raygen, Miss, ClosestHit, AnyHit, Vertex, Fragment };
// ColorOutput: what a fragment shader writes, in set kOutputSet; its binding is the location.
enum class BindingKind : uint32_t { StorageBuffer, StorageImage, SampledImage, UniformBuffer, Accel, TextureTable, ColorOutput };
constexpr uint32_t kOutputSet = 2;

// One resource that a shader declares, by its GLSL instance name.
struct ShaderBinding {
    std::string name;
    uint32_t set = 0, binding = 0;
    BindingKind kind = BindingKind::StorageBuffer;
    bool reads = true, writes = false;  // from readonly / writeonly
    uint32_t format = 0;                // Format of a storage image, 0 if it declares none
};
// A member of the push constant block that is a buffer reference: bound by name like a binding, Frame fills in the address.
struct PushPointer {
    std::string name;
    uint32_t offset = 0;
    bool reads = true, writes = false;
};
// Layout of a struct as the shader compiler sees it, for the test that holds shared headers against C++.
struct ShaderStructMember {
    std::string name;
    uint32_t offset = 0, bytes = 0;
};
struct ShaderStruct {
    std::string name;
    uint32_t bytes = 0;
    std::vector<ShaderStructMember> members;
};

struct ShaderCode {
    std::string name;     // "reference/path_trace": path of the source below its root without extension
    std::string variant;  // "" | "query" | "compute" | "pipeline", then "+DEFINE" for each define in order
    Stage stage = Stage::Compute;
    uint32_t local_size[3] = {1, 1, 1};
    uint32_t push_bytes = 0;
    std::vector<ShaderBinding> bindings;
    std::vector<PushPointer> push_pointers;
    std::vector<ShaderStruct> structs;
    std::vector<uint32_t> words;
    uint64_t hash = 0;  // of the words
    bool has_constant = false;  // declares a specialization constant; the only one that is set is number 0, a uint
};

// The parsed pack. Throws Error for a pack that is not one of ours.
class ShaderPack {
public:
    explicit ShaderPack(std::span<const std::byte> bytes);
    static const ShaderPack& builtin();  // embedded, or from PARHELION_SHADER_DIR
    const ShaderCode* find(std::string_view name, std::string_view variant, Stage stage) const;  // nullptr: no such shader
    std::span<const ShaderCode> all() const { return shaders_; }

private:
    std::vector<ShaderCode> shaders_;
};

// How triangles of a raster program meet the attachments. Depth is reversed: 1 is near, 0 infinitely far.
enum class Cull : uint32_t { None, Back };  // front: corners run counter-clockwise on the picture
enum class Blend : uint32_t { None, Alpha, Premultiplied };  // over what is there; alpha: straight, and its coverage is added up
enum class DepthTest : uint32_t { None, Nearer };
struct RasterState {
    Cull cull = Cull::None;
    Blend blend = Blend::None;
    DepthTest depth_test = DepthTest::None;
    bool depth_write = true;  // where there is a test
    friend auto operator<=>(const RasterState&, const RasterState&) = default;
};
// Formats of the attachments: of the colour outputs by location, and of the depth buffer (Undefined: none).
struct RasterTarget {
    std::vector<Format> colors;
    Format depth = Format::Undefined;
};

// A pipeline with its layout. Compute: one shader. Ray tracing: raygen of that name plus the scene's miss, shadow miss, closest
// hit and any hit ("scene/hit"), in the raygen's variant where they are declared in it, else plain; recursion depth 1, its shader
// binding table aligned by the stricter of the device's and 64 bytes (gpu/shader_table.h).
class Program {
public:
    struct Data;
    Program() = default;
    // Cached per device by (pack, name, variant, constant). Throws Error if the pack lacks it or its declared set 1 is not push-descriptor
    // compatible. `way` picks the stage: Pipeline makes a ray tracing pipeline. `constant`: value of specialization constant 0, for
    // compute shaders that declare it.
    static Program get(const DevicePtr& device, const ShaderPack& pack, std::string_view name, std::string_view variant, bool ray_tracing, uint32_t constant = 0);

    // Vertex and fragment shader of that name, which draw triangle lists without vertex input: vertices are read by address. The vertex
    // shader is the plain one where there is none in the variant. Viewport and scissor are set by the command list. Their code is that of both:
    // all bindings, addresses, and the colour outputs, which must be as many as the target has. They only read.
    static Program get_raster(const DevicePtr& device, const ShaderPack& pack, std::string_view name, std::string_view variant, const RasterState& state,
                              const RasterTarget& target);
    // Frees the program where no other handle of it is left; the next get() makes it anew. The device must be done with it.
    static void forget(const DevicePtr& device, Program&& program);
    // What the two shaders declare, without words.
    static ShaderCode raster_code(const ShaderPack& pack, std::string_view name, std::string_view variant);

    explicit operator bool() const { return data_ != nullptr; }
    const ShaderCode& code() const;  // of the compute shader or raygen, of vertex and fragment shader together
    bool uses_scene_set() const;     // declares anything in set 0
    const std::shared_ptr<Data>& data() const { return data_; }
    friend bool operator==(const Program& a, const Program& b) { return a.data_.get() == b.data_.get(); }

private:
    std::shared_ptr<Data> data_;
};

}  // namespace parhelion::gpu
