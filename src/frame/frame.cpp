#include "frame/frame.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <utility>

#include "base/error.h"
#include "base/log.h"
#include "frame/listing.h"

namespace parhelion {

using gpu::Use;

namespace {

constexpr uint32_t kMaxTimedPasses = 1024;
constexpr UseMask kEveryUse = ~0u;

}  // namespace

Frame::Frame(gpu::DevicePtr device, const FrameOptions& options, const gpu::ShaderPack& pack)
    : device_(std::move(device)), options_(options), pack_(&pack) {
    if (options_.markers) marker_ = gpu::Buffer(device_, "frame/marker", 256, gpu::MemoryKind::Readback);
}

Frame::~Frame() {
    try {
        for (const InFlight& frame : in_flight_)
            if (frame.ticket != 0) gpu::wait(device_, frame.ticket);
    } catch (const std::exception& error) {
        log(LogLevel::Debug, "while ending a frame: {}", error.what());
    }
}

gpu::Image Frame::image(const std::string& name, gpu::Extent extent, gpu::Format format) {
    gpu::Image& slot = images_[name];
    if (!slot || slot.extent() != extent || slot.desc().format != format) slot = gpu::Image(device_, name, {.format = format, .extent = extent});
    return slot;
}

gpu::Buffer Frame::buffer(const std::string& name, uint64_t bytes) {
    gpu::Buffer& slot = buffers_[name];
    if (!slot || slot.bytes() != bytes) slot = gpu::Buffer(device_, name, bytes);
    return slot;
}

History<gpu::Image> Frame::history(const std::string& name, gpu::Extent extent, gpu::Format format) {
    const std::string now_name = fmt::format("{}.{}", name, serial_ % 2), before_name = fmt::format("{}.{}", name, 1 - serial_ % 2);
    const auto existing = images_.find(before_name);
    const bool same = existing != images_.end() && existing->second && existing->second.extent() == extent && existing->second.desc().format == format;
    const auto written = history_written_.find(name);
    const bool valid = same && written != history_written_.end() && written->second + 1 == serial_;
    history_written_[name] = serial_;
    return {image(now_name, extent, format), image(before_name, extent, format), valid};
}

void Frame::reset_history(std::string_view reason) {
    if (!history_written_.empty()) log(LogLevel::Debug, "history reset: {}", reason);
    history_written_.clear();
}

Pass Frame::compute(std::string_view name, std::string_view defines) {
    Pass pass(*this, std::string(name), std::string(defines), Pass::Kind::Compute);
    pass.program();  // complains here if there is no such shader
    return pass;
}

Pass Frame::trace(std::string_view name, gpu::TraceWay way, std::string_view defines) {
    const Pass::Kind kind = way == gpu::TraceWay::Pipeline ? Pass::Kind::Trace : Pass::Kind::Compute;
    return {*this, std::string(name), fmt::format("{}{}", gpu::trace_way_name(way), defines), kind};
}

std::vector<gpu::Image> Frame::written_images() const {
    std::vector<gpu::Image> images;
    for (const Record& record : records_)
        for (const gpu::Image& image : record.images) {
            const bool writes = std::ranges::find(record.info.writes, image.name()) != record.info.writes.end();
            const bool is_new = std::ranges::none_of(images, [&](const gpu::Image& known) { return known.id() == image.id(); });
            if (writes && is_new) images.push_back(image);
        }
    return images;
}

namespace {

bool takes_the_same(const gpu::ShaderCode& a, const gpu::ShaderCode& b) {
    const auto same_binding = [](const gpu::ShaderBinding& x, const gpu::ShaderBinding& y) {
        return x.name == y.name && x.set == y.set && x.kind == y.kind && x.reads == y.reads && x.writes == y.writes;
    };
    const auto same_pointer = [](const gpu::PushPointer& x, const gpu::PushPointer& y) { return x.name == y.name && x.offset == y.offset && x.reads == y.reads && x.writes == y.writes; };
    return a.push_bytes == b.push_bytes && std::ranges::equal(a.bindings, b.bindings, same_binding) && std::ranges::equal(a.push_pointers, b.push_pointers, same_pointer);
}

}  // namespace

void Frame::use_pack(const gpu::ShaderPack& pack) {
    PARHELION_CHECK(records_.empty(), "shaders change between two frames");
    std::vector<gpu::Program> replaced;
    const auto replace = [&](gpu::Program&& old, const gpu::Program& now) {
        if (old != now) replaced.push_back(std::move(old));
    };
    for (const ProgramKey& key : programs_) {
        const auto program_of = [&](const gpu::ShaderPack& from) { return gpu::Program::get(device_, from, key.name, key.variant, key.ray_tracing, key.constant); };
        gpu::Program old = program_of(*pack_);
        const gpu::Program now = program_of(pack);
        if (!takes_the_same(old.code(), now.code()))
            throw Error(ErrorCode::Failed, "it takes other resources than before", fmt::format("shader {} {}", key.name, key.variant), "build the program again, too");
        replace(std::move(old), now);
    }
    for (const auto& [name, make] : raster_programs_) replace(make(*pack_), make(pack));
    pack_ = &pack;
    for (gpu::Program& program : replaced) gpu::Program::forget(device_, std::move(program));
}

void Frame::add(Record record) {
    record.info.group = group_;
    records_.push_back(std::move(record));
}

void Frame::together(const std::function<void()>& record) {
    PARHELION_CHECK(group_ == 0, "a group of passes is recorded in another one");
    group_ = ++groups_;
    const auto end = [](uint32_t* group) { *group = 0; };
    const std::unique_ptr<uint32_t, decltype(end)> ends(&group_, end);
    record();
}

size_t Frame::end_of_group(size_t first) const {
    const uint32_t group = records_[first].info.group;
    size_t end = first + 1;
    while (group != 0 && !options_.full_barriers && end < records_.size() && records_[end].info.group == group) ++end;
    return end;
}

// Emits the barrier that a pass, or a group of them, needs, if any, and notes their accesses.
void Frame::order(std::span<const Record> records, gpu::CommandList& commands) {
    UseMask before = 0, after = 0;
    std::vector<Access> accesses;
    for (const Record& record : records) {
        for (const gpu::Image& image : record.images) commands.initialise_layout(image);
        for (const Access& access : record.accesses) {
            const Hazard hazard = tracker_.find(access);
            before |= hazard.before;
            if (hazard.exists()) after |= use_bit(access.use);
            accesses.push_back(access);
        }
    }
    if (options_.full_barriers) {
        commands.full_barrier();
        tracker_.add_barrier(kEveryUse, kEveryUse);
    } else if (before != 0 && static_cast<int>(barrier_count_++) != options_.skip_barrier) {
        gpu::BarrierScope scope;
        for (uint32_t u = 0; u < 32; ++u) {
            if (before >> u & 1) scope.before.push_back(static_cast<Use>(u));
            if (after >> u & 1) scope.after.push_back(static_cast<Use>(u));
        }
        commands.barrier(scope);
        tracker_.add_barrier(before, after);
    }
    for (const Record& record : records)
        for (const Access& access : record.accesses)
            if (tracker_.find(access).exists())
                complaints_.push_back(fmt::format("{}: {} of {} is not ordered after an earlier access", record.info.name, gpu::use_name(access.use), *access.name));
    tracker_.add_accesses(accesses);
}

uint64_t Frame::record(gpu::CommandList& commands) {
    InFlight frame{.serial = serial_};
    barrier_count_ = 0;
    const bool times = options_.timers != Timers::None && device_->caps().timestamp_period_ns > 0 && !records_.empty();
    const uint32_t timed = times && options_.timers == Timers::Passes ? std::min<uint32_t>(static_cast<uint32_t>(records_.size()), kMaxTimedPasses) : 0;
    if (times) {
        frame.timers = gpu::TimerPool(device_, std::max(2 * timed, 2u));
        commands.reset_timers(frame.timers);
    }
    listing_.clear();
    gpu_ms_ = 0;
    if (times && timed == 0) commands.write_timer(frame.timers, 0);
    size_t ordered = 0;  // records whose barriers are there
    for (uint32_t i = 0; i < records_.size(); ++i) {
        const Record& record = records_[i];
        commands.begin_label(record.info.name);
        if (i == ordered) {
            ordered = end_of_group(i);
            order(std::span(records_).subspan(i, ordered - i), commands);
        }
        if (i < timed) commands.write_timer(frame.timers, 2 * i);
        record.launch(commands);
        if (i < timed) commands.write_timer(frame.timers, 2 * i + 1);
        if (marker_) commands.write_marker(marker_, i + 1);
        commands.end_label();
        listing_.push_back(record.info);
    }
    if (times && timed == 0) commands.write_timer(frame.timers, 1);
    tracker_.compact();
    // Each object once, so that whoever retires the frame sees which of them nobody else holds.
    std::sort(kept_.begin(), kept_.end());
    kept_.erase(std::unique(kept_.begin(), kept_.end()), kept_.end());
    frame.kept = std::move(kept_);
    kept_.clear();
    staging_ = {};
    upload_ = {};
    records_.clear();
    in_flight_.push_back(std::move(frame));
    recorded_serial_ = serial_;
    return serial_++;
}

void Frame::retire(uint64_t serial) {
    std::erase_if(in_flight_, [&](InFlight& frame) {
        if (frame.serial > serial) return false;
        for (const std::shared_ptr<void>& object : frame.kept)
            if (object.use_count() == 1) tracker_.forget(object.get());
        return true;
    });
}

gpu::Ticket Frame::submit() {
    if (marker_) *marker_.mapped_as<uint32_t>().data() = 0;
    gpu::CommandList commands(device_);
    record(commands);
    try {
        return in_flight_.back().ticket = gpu::submit(device_, std::move(commands), std::exchange(window_, nullptr));
    } catch (const Error& error) {
        report_loss(error);
    }
}

void Frame::wait(gpu::Ticket ticket) {
    try {
        if (!gpu::wait(device_, ticket)) throw Error(ErrorCode::Failed, "the device did not finish a frame within ten minutes", device_->caps().name);
    } catch (const Error& error) {
        report_loss(error);
    }
    for (const InFlight& frame : in_flight_) {
        if (frame.ticket != ticket) continue;
        if (frame.serial == recorded_serial_) read_timers(frame);
        const uint64_t serial = frame.serial;
        retire(serial);
        return;
    }
}

void Frame::read_timers(const InFlight& frame) {
    if (!frame.timers) return;
    const std::vector<double> times = frame.timers.read_ms(frame.timers.count());
    gpu_ms_ = times.empty() ? 0 : times.back();
    if (options_.timers != Timers::Passes) return;
    for (size_t i = 0; 2 * i + 1 < times.size(); ++i) listing_[i].gpu_ms = times[2 * i + 1] - times[2 * i];
}

void Frame::report_loss(const std::exception& cause) {
    const uint32_t completed = marker_ ? *marker_.mapped_as<uint32_t>().data() : 0;
    std::string where = completed == 0 ? "before its first pass" : completed <= listing_.size() ? "after pass " + listing_[completed - 1].name : "after its last pass";
    for (InFlight& frame : in_flight_) frame.ticket = 0;
    const auto* error = dynamic_cast<const Error*>(&cause);
    throw DeviceLost(fmt::format("{}; the frame had come to {}", error ? error->problem : cause.what(), where), device_->caps().name);
}

std::string Frame::listing(bool with_times) const { return list_passes(listing_, with_times); }

}  // namespace parhelion
