#pragma once
// Writes shader packs (the format of src/gpu/shader_pack.cpp), for tests of the reader and for packs put together by tests.
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "gpu/program.h"

namespace parhelion::testing {

class PackWriter {
public:
    std::vector<std::byte> write(std::span<const gpu::ShaderCode> shaders) {
        raw("PHSPACK1", 8);
        list(shaders, [&](const gpu::ShaderCode& s) { shader(s); });
        return std::move(out_);
    }

private:
    void raw(const void* data, size_t bytes) {
        const size_t at = out_.size();
        out_.resize(at + bytes);
        if (bytes != 0) std::memcpy(out_.data() + at, data, bytes);
    }
    void u32(uint32_t value) { raw(&value, sizeof(value)); }
    void text(const std::string& value) {
        u32(static_cast<uint32_t>(value.size()));
        raw(value.data(), value.size());
    }
    template <class Items, class Function>
    void list(const Items& items, Function each) {
        u32(static_cast<uint32_t>(items.size()));
        for (const auto& item : items) each(item);
    }
    void shader(const gpu::ShaderCode& s) {
        text(s.name);
        text(s.variant);
        u32(static_cast<uint32_t>(s.stage));
        for (const uint32_t size : s.local_size) u32(size);
        u32(s.push_bytes);
        list(s.bindings, [&](const gpu::ShaderBinding& b) {
            text(b.name);
            for (const uint32_t value : {b.set, b.binding, static_cast<uint32_t>(b.kind), uint32_t(b.reads), uint32_t(b.writes), b.format}) u32(value);
        });
        list(s.push_pointers, [&](const gpu::PushPointer& p) {
            text(p.name);
            for (const uint32_t value : {p.offset, uint32_t(p.reads), uint32_t(p.writes)}) u32(value);
        });
        list(s.structs, [&](const gpu::ShaderStruct& t) {
            text(t.name);
            u32(t.bytes);
            list(t.members, [&](const gpu::ShaderStructMember& m) {
                text(m.name);
                u32(m.offset);
                u32(m.bytes);
            });
        });
        list(s.words, [&](uint32_t word) { u32(word); });
    }
    std::vector<std::byte> out_;
};

}  // namespace parhelion::testing
