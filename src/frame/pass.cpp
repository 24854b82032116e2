#include <algorithm>
#include <cstring>

#include <fmt/ranges.h>

#include "base/error.h"
#include "frame/frame.h"

namespace parhelion {

using gpu::Binding;
using gpu::BindingKind;
using gpu::Use;

namespace {

std::string or_nothing(const std::vector<std::string>& names) { return names.empty() ? "nothing" : fmt::format("{}", fmt::join(names, ", ")); }

const void* id_of(const std::variant<gpu::Buffer, gpu::Image>& resource) {
    return std::visit([](const auto& r) { return r.id(); }, resource);
}
const std::string& name_of(const std::variant<gpu::Buffer, gpu::Image>& resource) {
    return std::visit([](const auto& r) -> const std::string& { return r.name(); }, resource);
}

}  // namespace

Pass& Pass::bind(std::string_view name, std::variant<gpu::Buffer, gpu::Image> resource, bool reads, bool writes, const gpu::Sampler& sampler) {
    PARHELION_CHECK(id_of(resource) != nullptr, "pass {}: '{}' is bound to an empty resource", name_, name);
    bound_.push_back({std::string(name), std::move(resource), sampler, reads, writes});
    return *this;
}
Pass& Pass::read(std::string_view name, const gpu::Buffer& buffer) { return bind(name, buffer, true, false); }
Pass& Pass::write(std::string_view name, const gpu::Buffer& buffer) { return bind(name, buffer, false, true); }
Pass& Pass::read_write(std::string_view name, const gpu::Buffer& buffer) { return bind(name, buffer, true, true); }
Pass& Pass::untouched(std::string_view name, const gpu::Buffer& buffer) { return bind(name, buffer, false, false); }
Pass& Pass::read(std::string_view name, const gpu::Image& image) { return bind(name, image, true, false); }
Pass& Pass::write(std::string_view name, const gpu::Image& image) { return bind(name, image, false, true); }
Pass& Pass::read_write(std::string_view name, const gpu::Image& image) { return bind(name, image, true, true); }
Pass& Pass::sample(std::string_view name, const gpu::Image& image, const gpu::Sampler& sampler) { return bind(name, image, true, false, sampler); }

Pass& Pass::scene(const SceneBinding& scene) {
    scene_ = &scene;
    if (program_ && program_.code().has_constant) program_ = {};  // its constant may be another
    return *this;
}

Pass& Pass::reach(std::span<const gpu::Buffer> buffers) {
    reached_.insert(reached_.end(), buffers.begin(), buffers.end());
    return *this;
}

Pass& Pass::reach_written(std::span<const gpu::Buffer> buffers) {
    reached_written_.insert(reached_written_.end(), buffers.begin(), buffers.end());
    return *this;
}

const gpu::Program& Pass::program() {
    if (program_) return program_;
    if (kind_ == Kind::Raster) return program_ = raster_program();
    const Frame::ProgramKey key{name_, variant_, kind_ == Kind::Trace, scene_ ? scene_->bvh_variant : 0};
    program_ = gpu::Program::get(frame_.device_, *frame_.pack_, key.name, key.variant, key.ray_tracing, key.constant);
    frame_.programs_.insert(key);
    return program_;
}

const gpu::ShaderCode& Pass::code() { return kind_ == Kind::Raster ? raster_code_ : program().code(); }

Pass& Pass::push_bytes(const void* data, size_t bytes) {
    // C++ pads a struct with addresses to a multiple of 8 bytes at its end; scalar layout does not.
    const uint32_t declared = code().push_bytes;
    PARHELION_CHECK(bytes == declared || bytes == (declared + 7u) / 8u * 8u, "pass {} {}: the push constants are {} bytes, the shader declares {}",
                    name_, variant_, bytes, declared);
    push_.resize(declared);
    std::memcpy(push_.data(), data, declared);
    return *this;
}

Use Pass::use(bool reads, bool writes) const {
    if (kind_ == Kind::Raster) return Use::RasterRead;
    if (kind_ == Kind::Trace) return reads && writes ? Use::TraceReadWrite : writes ? Use::TraceWrite : Use::TraceRead;
    return reads && writes ? Use::ComputeReadWrite : writes ? Use::ComputeWrite : Use::ComputeRead;
}

Use Pass::sample_use() const { return kind_ == Kind::Raster ? Use::RasterSample : kind_ == Kind::Trace ? Use::TraceSample : Use::ComputeSample; }

// Matches what is bound against what the shader declares, both ways, names and access.
void Pass::resolve(std::vector<Binding>& bindings, std::vector<Access>& accesses) {
    const gpu::ShaderCode& code = program().code();
    std::vector<std::string> missing, access_errors;
    std::vector<bool> used(bound_.size(), false);
    const auto take = [&](const std::string& name, bool reads, bool writes, Bound*& bound) {
        bound = nullptr;
        for (size_t i = 0; i < bound_.size(); ++i)
            if (bound_[i].name == name && !used[i]) used[i] = true, bound = &bound_[i];
        if (!bound) missing.push_back(name);
        else if (is_touched(*bound) && (bound->reads != reads || bound->writes != writes))
            access_errors.push_back(fmt::format("{} (the shader {}{}{})", name, reads ? "reads" : "", reads && writes ? " and " : "", writes ? "writes" : ""));
        return bound != nullptr;
    };
    for (const gpu::ShaderBinding& declared : code.bindings) {
        Bound* bound = nullptr;
        if (declared.set != 1 || !take(declared.name, declared.reads, declared.writes, bound)) continue;
        Binding binding{declared.binding, declared.kind, {}, bound->sampler};
        std::visit([&](const auto& resource) { binding.resource = resource; }, bound->resource);
        bindings.push_back(std::move(binding));
        const bool sampled = declared.kind == BindingKind::SampledImage;
        if (is_touched(*bound)) accesses.push_back({id_of(bound->resource), sampled ? sample_use() : use(declared.reads, declared.writes), &name_of(bound->resource)});
    }
    for (const gpu::PushPointer& pointer : code.push_pointers) {
        Bound* bound = nullptr;
        if (!take(pointer.name, pointer.reads, pointer.writes, bound)) continue;
        const auto* buffer = std::get_if<gpu::Buffer>(&bound->resource);
        PARHELION_CHECK(buffer, "pass {}: '{}' is an address in the shader and needs a buffer", code.name, pointer.name);
        PARHELION_CHECK(push_.size() >= pointer.offset + sizeof(uint64_t), "pass {}: push() is missing", code.name);
        const uint64_t address = buffer->address();
        std::memcpy(push_.data() + pointer.offset, &address, sizeof(address));
        if (is_touched(*bound)) accesses.push_back({buffer->id(), use(pointer.reads, pointer.writes), &buffer->name()});
    }
    std::vector<std::string> unknown;
    for (size_t i = 0; i < bound_.size(); ++i)
        if (!used[i]) unknown.push_back(bound_[i].name);
    PARHELION_CHECK(missing.empty() && unknown.empty() && access_errors.empty(),
                    "pass {} {}: not bound: {}; bound but not declared in the shader: {}; bound with another access: {}", code.name, code.variant,
                    or_nothing(missing), or_nothing(unknown), or_nothing(access_errors));
    PARHELION_CHECK(push_.size() == code.push_bytes, "pass {}: push() is missing", code.name);
    PARHELION_CHECK(program_.uses_scene_set() == (scene_ != nullptr), "pass {} {}: {}", code.name, code.variant,
                    scene_ ? "scene() is given but the shader declares nothing in set 0" : "the shader sees the scene; scene() is missing");
}

void Pass::finish(std::string extent, std::function<void(gpu::CommandList&)> launch, std::vector<Access> accesses) {
    std::vector<Binding> bindings;
    resolve(bindings, accesses);
    Frame::Record record;
    record.info.name = name_;
    record.info.variant = variant_;
    record.info.extent = std::move(extent);
    for (const Bound& bound : bound_) {
        std::visit([&](const auto& r) { frame_.keep(r.data()); }, bound.resource);
        if (const auto* image = std::get_if<gpu::Image>(&bound.resource)) record.images.push_back(*image);
        if (bound.reads) record.info.reads.push_back(name_of(bound.resource));
        if (bound.writes) record.info.writes.push_back(name_of(bound.resource));
    }
    note_target(record, accesses);
    for (const gpu::Buffer& buffer : reached_) {
        record.info.reads.push_back(buffer.name());
        accesses.push_back({buffer.id(), use(true, false), &buffer.name()});
        frame_.keep(buffer.data());
    }
    for (const gpu::Buffer& buffer : reached_written_) {
        record.info.writes.push_back(buffer.name());
        accesses.push_back({buffer.id(), use(false, true), &buffer.name()});
        frame_.keep(buffer.data());
    }
    std::optional<gpu::SceneSet> set;
    if (scene_) {
        record.info.reads.push_back("scene");
        set = scene_->set;
        frame_.keep(set->data());
        for (const gpu::Buffer& buffer : scene_->buffers) accesses.push_back({buffer.id(), use(true, false), &buffer.name()}), frame_.keep(buffer.data());
        for (const gpu::Image& image : scene_->textures) accesses.push_back({image.id(), sample_use(), &image.name()}), frame_.keep(image.data());
        for (const gpu::AccelStruct& accel : kind_ == Kind::Raster ? std::vector<gpu::AccelStruct>{} : scene_->accels)
            accesses.push_back({accel.id(), kind_ == Kind::Trace ? Use::TraceAccel : Use::ComputeAccel, &accel.name()}), frame_.keep(accel.data());
    }
    frame_.keep(program_.data());
    record.accesses = std::move(accesses);
    record.launch = [program = program_, set, bindings = std::move(bindings), push = push_, launch = std::move(launch)](gpu::CommandList& commands) {
        commands.bind(program, set ? &*set : nullptr, bindings, push);
        launch(commands);
    };
    frame_.add(std::move(record));
}

void Pass::over(uint32_t width, uint32_t height, uint32_t depth) {
    PARHELION_CHECK(kind_ != Kind::Raster, "pass {} draws; it has no invocations of its own", name_);
    std::string extent = fmt::format("{}x{}", width, height) + (depth > 1 ? fmt::format("x{}", depth) : "");
    if (kind_ == Kind::Trace) return finish(std::move(extent), [=](gpu::CommandList& commands) { commands.trace(width, height, depth); }, {});
    const uint32_t* local = program().code().local_size;
    const uint32_t x = (width + local[0] - 1) / local[0], y = (height + local[1] - 1) / local[1], z = (depth + local[2] - 1) / local[2];
    finish(std::move(extent), [=](gpu::CommandList& commands) { commands.dispatch(x, y, z); }, {});
}

void Pass::over_all(uint64_t count) {
    constexpr uint64_t kRow = 1u << 20;
    over(static_cast<uint32_t>(std::min(count, kRow)), static_cast<uint32_t>((count + kRow - 1) / kRow));
}

void Pass::over_indirect(const gpu::Buffer& args, uint64_t offset) {
    PARHELION_CHECK(kind_ != Kind::Raster, "pass {} draws; it has no invocations of its own", name_);
    frame_.keep(args.data());
    finish("indirect",
           [args, offset, rays = kind_ == Kind::Trace](gpu::CommandList& commands) { rays ? commands.trace_indirect(args, offset) : commands.dispatch_indirect(args, offset); },
           {{args.id(), Use::IndirectRead, &args.name()}});
}

}  // namespace parhelion
