// shader_pack MANIFEST.tsv OUTPUT.pack: joins compiled shaders with their reflection (SPIRV-Cross) into one file that
// src/gpu/shader_pack.cpp reads. Manifest lines: name <tab> variant <tab> glslc stage <tab> path of the .spv.
// Binding resources and push constant pointers by name happens on this table, so the renderer needs no reflection library.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <spirv_cross_c.h>

namespace {

[[noreturn]] void fail(const std::string& text) {
    std::fprintf(stderr, "shader_pack: %s\n", text.c_str());
    std::exit(1);
}

struct Writer {
    std::string out;
    void u32(uint32_t v) { out.append(reinterpret_cast<const char*>(&v), 4); }
    void text(const std::string& s) {
        u32(static_cast<uint32_t>(s.size()));
        out += s;
    }
};

// The numbers of gpu::Stage, gpu::BindingKind and gpu::Format.
const std::map<std::string, uint32_t> kStages = {{"compute", 0}, {"rgen", 1}, {"rmiss", 2}, {"rchit", 3}, {"rahit", 4}, {"vert", 5}, {"frag", 6}};
enum Kind : uint32_t { kStorageBuffer, kStorageImage, kSampledImage, kUniformBuffer, kAccel, kTextureTable, kColorOutput };
constexpr uint32_t kOutputSet = 2;  // gpu::kOutputSet
const std::map<SpvImageFormat, uint32_t> kFormats = {
    {SpvImageFormatUnknown, 0}, {SpvImageFormatR8, 1},       {SpvImageFormatRg8, 2},       {SpvImageFormatRgba8, 3},
    {SpvImageFormatR16f, 5},    {SpvImageFormatRg16f, 6},    {SpvImageFormatRgba16f, 7},   {SpvImageFormatR32f, 8},
    {SpvImageFormatRg32f, 9},   {SpvImageFormatRgba32f, 10}, {SpvImageFormatR32ui, 11},    {SpvImageFormatRgba32ui, 12}};

struct Reflector {
    spvc_context context = nullptr;
    spvc_compiler compiler = nullptr;
    spvc_resources resources = nullptr;

    explicit Reflector(const std::vector<uint32_t>& words) {
        spvc_parsed_ir ir = nullptr;
        spvc_context_create(&context);
        if (spvc_context_parse_spirv(context, reinterpret_cast<const SpvId*>(words.data()), words.size(), &ir) != SPVC_SUCCESS ||
            spvc_context_create_compiler(context, SPVC_BACKEND_NONE, ir, SPVC_CAPTURE_MODE_TAKE_OWNERSHIP, &compiler) != SPVC_SUCCESS ||
            spvc_compiler_create_shader_resources(compiler, &resources) != SPVC_SUCCESS)
            fail(spvc_context_get_last_error_string(context));
    }
    ~Reflector() { spvc_context_destroy(context); }

    std::vector<spvc_reflected_resource> list(spvc_resource_type type) const {
        const spvc_reflected_resource* data = nullptr;
        size_t count = 0;
        spvc_resources_get_resource_list_for_type(resources, type, &data, &count);
        return {data, data + count};
    }
    // The instance name; blocks without one go by their block name.
    std::string name(const spvc_reflected_resource& r) const {
        const std::string own = spvc_compiler_get_name(compiler, r.id);
        return own.empty() ? r.name : own;
    }
    bool decorated(spvc_variable_id id, SpvDecoration d) const { return spvc_compiler_has_decoration(compiler, id, d); }

    // A block is read-only (write-only) if it or each of its members is.
    bool block_has(const spvc_reflected_resource& r, SpvDecoration d) const { return decorated(r.id, d) || members_have(r.base_type_id, d); }
    bool members_have(spvc_type_id id, SpvDecoration d) const {
        const spvc_type type = spvc_compiler_get_type_handle(compiler, id);
        const unsigned count = spvc_type_get_num_member_types(type);
        for (unsigned m = 0; m < count; ++m)
            if (!spvc_compiler_has_member_decoration(compiler, id, m, d)) return false;
        return count != 0;
    }
};

void write_bindings(const Reflector& r, bool fragment, Writer& w) {
    Writer rows;
    uint32_t count = 0;
    const auto add = [&](const spvc_reflected_resource& res, uint32_t kind, bool reads, bool writes, uint32_t format) {
        rows.text(r.name(res));
        const bool output = kind == kColorOutput;
        rows.u32(output ? kOutputSet : spvc_compiler_get_decoration(r.compiler, res.id, SpvDecorationDescriptorSet));
        rows.u32(spvc_compiler_get_decoration(r.compiler, res.id, output ? SpvDecorationLocation : SpvDecorationBinding));
        rows.u32(kind);
        rows.u32(reads);
        rows.u32(writes);
        rows.u32(format);
        ++count;
    };
    for (const auto& res : r.list(SPVC_RESOURCE_TYPE_STORAGE_BUFFER))
        add(res, kStorageBuffer, !r.block_has(res, SpvDecorationNonReadable), !r.block_has(res, SpvDecorationNonWritable), 0);
    for (const auto& res : r.list(SPVC_RESOURCE_TYPE_UNIFORM_BUFFER)) add(res, kUniformBuffer, true, false, 0);
    for (const auto& res : r.list(SPVC_RESOURCE_TYPE_STORAGE_IMAGE)) {
        const SpvImageFormat format = spvc_type_get_image_storage_format(spvc_compiler_get_type_handle(r.compiler, res.type_id));
        if (!kFormats.count(format)) fail(fmt::format("image {} has an unknown format", r.name(res)));
        add(res, kStorageImage, !r.decorated(res.id, SpvDecorationNonReadable), !r.decorated(res.id, SpvDecorationNonWritable), kFormats.at(format));
    }
    for (const auto& res : r.list(SPVC_RESOURCE_TYPE_SAMPLED_IMAGE)) {
        const bool table = spvc_type_get_num_array_dimensions(spvc_compiler_get_type_handle(r.compiler, res.type_id)) != 0;
        add(res, table ? kTextureTable : kSampledImage, true, false, 0);
    }
    for (const auto& res : r.list(SPVC_RESOURCE_TYPE_ACCELERATION_STRUCTURE)) add(res, kAccel, true, false, 0);
    if (fragment)
        for (const auto& res : r.list(SPVC_RESOURCE_TYPE_STAGE_OUTPUT)) add(res, kColorOutput, false, true, 0);
    w.u32(count);
    w.out += rows.out;
}

// Push constant size, and its members that are buffer references.
void write_push(const Reflector& r, Writer& size_out, Writer& w) {
    Writer rows;
    uint32_t count = 0;
    size_t bytes = 0;
    for (const auto& res : r.list(SPVC_RESOURCE_TYPE_PUSH_CONSTANT)) {
        const spvc_type type = spvc_compiler_get_type_handle(r.compiler, res.base_type_id);
        spvc_compiler_get_declared_struct_size(r.compiler, type, &bytes);
        for (unsigned m = 0; m < spvc_type_get_num_member_types(type); ++m) {
            const spvc_type_id member_id = spvc_type_get_member_type(type, m);
            const spvc_type member = spvc_compiler_get_type_handle(r.compiler, member_id);
            if (spvc_type_get_storage_class(member) != SpvStorageClassPhysicalStorageBuffer) continue;
            const spvc_type_id pointee = spvc_type_get_base_type_id(member);
            unsigned offset = 0;
            spvc_compiler_type_struct_member_offset(r.compiler, type, m, &offset);
            rows.text(spvc_compiler_get_member_name(r.compiler, res.base_type_id, m));
            rows.u32(offset);
            rows.u32(!r.members_have(pointee, SpvDecorationNonReadable));
            rows.u32(!r.members_have(pointee, SpvDecorationNonWritable));
            ++count;
        }
    }
    size_out.u32(static_cast<uint32_t>(bytes));
    w.u32(count);
    w.out += rows.out;
}

// Layouts of the structs inside storage buffers, for the test that holds shared headers against C++.
void write_structs(const Reflector& r, Writer& w) {
    Writer rows;
    uint32_t count = 0;
    const auto add_struct = [&](spvc_type_id id, size_t stride) {
        const spvc_type type = spvc_compiler_get_type_handle(r.compiler, id);
        const char* name = spvc_compiler_get_name(r.compiler, id);
        const unsigned members = spvc_type_get_num_member_types(type);
        if (members == 0 || !name || !*name) return;
        rows.text(name);
        rows.u32(static_cast<uint32_t>(stride));
        rows.u32(members);
        for (unsigned m = 0; m < members; ++m) {
            unsigned offset = 0;
            size_t bytes = 0;
            spvc_compiler_type_struct_member_offset(r.compiler, type, m, &offset);
            spvc_compiler_get_declared_struct_member_size(r.compiler, type, m, &bytes);
            rows.text(spvc_compiler_get_member_name(r.compiler, id, m));
            rows.u32(offset);
            rows.u32(static_cast<uint32_t>(bytes));
        }
        ++count;
    };
    for (const auto& res : r.list(SPVC_RESOURCE_TYPE_STORAGE_BUFFER)) {
        const spvc_type block = spvc_compiler_get_type_handle(r.compiler, res.base_type_id);
        for (unsigned m = 0; m < spvc_type_get_num_member_types(block); ++m) {
            const spvc_type_id member_id = spvc_type_get_member_type(block, m);
            const spvc_type member = spvc_compiler_get_type_handle(r.compiler, member_id);
            if (spvc_type_get_basetype(member) != SPVC_BASETYPE_STRUCT) continue;
            unsigned stride = 0;
            if (spvc_type_get_num_array_dimensions(member) != 0)
                spvc_compiler_type_struct_member_array_stride(r.compiler, block, m, &stride);
            add_struct(spvc_type_get_base_type_id(member), stride);
        }
    }
    w.u32(count);
    w.out += rows.out;
}

void write_shader(const std::string& name, const std::string& variant, const std::string& stage, const std::string& path, Writer& w) {
    std::ifstream in(path, std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(in)), {});
    if (!in || bytes.size() % 4 != 0 || bytes.empty()) fail(path + " cannot be read");
    const std::vector<uint32_t> words(reinterpret_cast<const uint32_t*>(bytes.data()), reinterpret_cast<const uint32_t*>(bytes.data() + bytes.size()));
    const Reflector r(words);
    w.text(name);
    w.text(variant);
    w.u32(kStages.at(stage));
    for (unsigned axis = 0; axis < 3; ++axis)
        w.u32(stage == "compute" ? spvc_compiler_get_execution_mode_argument_by_index(r.compiler, SpvExecutionModeLocalSize, axis) : 1);
    Writer push_pointers, bindings;
    write_push(r, w, push_pointers);
    write_bindings(r, stage == "frag", bindings);
    w.out += bindings.out + push_pointers.out;
    write_structs(r, w);
    w.u32(static_cast<uint32_t>(words.size()));
    w.out += bytes;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 3) fail("usage: shader_pack MANIFEST.tsv OUTPUT.pack");
    std::ifstream manifest(argv[1]);
    if (!manifest) fail(std::string(argv[1]) + " cannot be read");
    Writer body;
    uint32_t count = 0;
    for (std::string line; std::getline(manifest, line);) {
        std::vector<std::string> cells(1);
        for (const char c : line)
            if (c == '\t') cells.emplace_back();
            else cells.back() += c;
        if (cells.size() != 4) continue;
        write_shader(cells[0], cells[1], cells[2], cells[3], body);
        ++count;
    }
    Writer file;
    file.out = "PHSPACK1";
    file.u32(count);
    file.out += body.out;
    std::ofstream out(argv[2], std::ios::binary);
    out << file.out;
    out.close();
    if (!out) fail(std::string(argv[2]) + " cannot be written");
}
