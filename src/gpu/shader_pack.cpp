// Reads the shader pack, the file that tools/shader_pack.cpp writes. Little endian; str = u32 length and bytes:
//   "PHSPACK1", u32 shaders x { str name, str variant, u32 stage, u32 local_size[3], u32 push_bytes,
//     u32 n x { str name, u32 set, binding, kind, reads, writes, format }, u32 n x { str name, u32 offset, reads, writes },
//     u32 n x { str name, u32 bytes, u32 m x { str name, u32 offset, bytes } }, u32 words, words }
#include <bit>
#include <cstring>

#include "base/error.h"
#include "base/hash.h"
#include "gpu/program.h"

namespace parhelion::gpu {

namespace {

static_assert(std::endian::native == std::endian::little);
constexpr std::string_view kMagic = "PHSPACK1";
constexpr uint32_t kSpirvMagic = 0x07230203;

class Reader {
public:
    explicit Reader(std::span<const std::byte> bytes) : rest_(bytes) {}

    std::span<const std::byte> take(size_t bytes) {
        if (bytes > rest_.size()) fail("it ends too early");
        const auto out = rest_.first(bytes);
        rest_ = rest_.subspan(bytes);
        return out;
    }
    uint32_t u32() {
        uint32_t value = 0;
        std::memcpy(&value, take(sizeof(value)).data(), sizeof(value));
        return value;
    }
    uint32_t u32_below(uint32_t limit, const char* what) {
        const uint32_t value = u32();
        if (value >= limit) fail(fmt::format("{} {} does not exist", what, value));
        return value;
    }
    bool flag() { return u32_below(2, "flag") != 0; }
    std::string text() {
        const auto bytes = take(u32());
        return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    }
    // A count of entries of at least `entry_bytes` each, so that a wrong count never makes a huge vector.
    uint32_t count(size_t entry_bytes) {
        const uint32_t value = u32();
        if (value > rest_.size() / entry_bytes) fail("it ends too early");
        return value;
    }
    bool at_end() const { return rest_.empty(); }
    [[noreturn]] static void fail(const std::string& what) {
        throw Error(ErrorCode::Failed, "this is not a shader pack of this version: " + what, "shaders.pack", "build it again");
    }

private:
    std::span<const std::byte> rest_;
};

// Whether an OpDecorate gives something a SpecId. Decorations come before the types.
bool declares_constant(std::span<const uint32_t> words) {
    constexpr uint32_t kOpDecorate = 71, kOpTypeVoid = 19, kSpecId = 1, kHeaderWords = 5;
    for (size_t i = kHeaderWords; i < words.size();) {
        const uint32_t op = words[i] & 0xFFFFu, length = words[i] >> 16;
        if (op == kOpTypeVoid || length == 0) return false;
        if (op == kOpDecorate && length >= 4 && i + 2 < words.size() && words[i + 2] == kSpecId) return true;
        i += length;
    }
    return false;
}

ShaderBinding read_binding(Reader& in) {
    ShaderBinding out;
    out.name = in.text();
    out.set = in.u32();
    out.binding = in.u32();
    out.kind = static_cast<BindingKind>(in.u32_below(static_cast<uint32_t>(BindingKind::ColorOutput) + 1, "binding kind"));
    out.reads = in.flag();
    out.writes = in.flag();
    out.format = in.u32();
    return out;
}

ShaderStruct read_struct(Reader& in) {
    ShaderStruct out;
    out.name = in.text();
    out.bytes = in.u32();
    out.members.resize(in.count(12));
    for (ShaderStructMember& member : out.members) {
        member.name = in.text();
        member.offset = in.u32();
        member.bytes = in.u32();
    }
    return out;
}

ShaderCode read_shader(Reader& in) {
    ShaderCode out;
    out.name = in.text();
    out.variant = in.text();
    out.stage = static_cast<Stage>(in.u32_below(static_cast<uint32_t>(Stage::Fragment) + 1, "stage"));
    for (uint32_t& size : out.local_size) size = in.u32();
    out.push_bytes = in.u32();
    for (uint32_t n = in.count(28); n > 0; --n) out.bindings.push_back(read_binding(in));
    for (uint32_t n = in.count(16); n > 0; --n) {
        PushPointer pointer;
        pointer.name = in.text();
        pointer.offset = in.u32();
        pointer.reads = in.flag();
        pointer.writes = in.flag();
        if (out.push_bytes < 8 || pointer.offset > out.push_bytes - 8) Reader::fail("a pointer lies outside the push constants");
        out.push_pointers.push_back(std::move(pointer));
    }
    for (uint32_t n = in.count(12); n > 0; --n) out.structs.push_back(read_struct(in));
    const auto words = in.take(size_t(in.count(4)) * 4);
    if (words.empty()) Reader::fail("a shader is empty");
    out.words.resize(words.size() / 4);
    std::memcpy(out.words.data(), words.data(), words.size());
    if (out.words[0] != kSpirvMagic) Reader::fail("a shader is not SPIR-V");
    out.hash = hash_bytes(words.data(), words.size());
    out.has_constant = declares_constant(out.words);
    return out;
}

}  // namespace

ShaderPack::ShaderPack(std::span<const std::byte> bytes) {
    Reader in(bytes);
    const auto magic = in.take(kMagic.size());
    if (std::memcmp(magic.data(), kMagic.data(), kMagic.size()) != 0) Reader::fail("it begins otherwise");
    for (uint32_t n = in.count(48); n > 0; --n) shaders_.push_back(read_shader(in));
    if (!in.at_end()) Reader::fail("there is more after its end");
}

const ShaderCode* ShaderPack::find(std::string_view name, std::string_view variant, Stage stage) const {
    for (const ShaderCode& shader : shaders_)
        if (shader.stage == stage && shader.name == name && shader.variant == variant) return &shader;
    return nullptr;
}

}  // namespace parhelion::gpu
