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

namespace parhelion::gpu {

enum class Stage : uint32_t { Compute, Raygen, Miss, ClosestHit, AnyHit };
enum class BindingKind : uint32_t { StorageBuffer, StorageImage, SampledImage, UniformBuffer, Accel, TextureTable };

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

    explicit operator bool() const { return data_ != nullptr; }
    const ShaderCode& code() const;  // of the compute shader or raygen
    bool uses_scene_set() const;     // declares anything in set 0
    const std::shared_ptr<Data>& data() const { return data_; }

private:
    std::shared_ptr<Data> data_;
};

}  // namespace parhelion::gpu
