#pragma once
// Recording of GPU commands. Nothing here tracks hazards: Frame does, and calls barrier(). Also submission, set 0 and timers.
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <variant>
#include <vector>

#include "gpu/program.h"
#include "gpu/resources.h"

namespace parhelion::gpu {

class Swapchain;
using Ticket = uint64_t;  // of a submission

// Descriptor set 0, equal for every program that sees the scene: binding 0 top level now, 1 top level before (both only on
// devices with acceleration structures), 2 scene header (storage buffer), 3 textures[] (combined image samplers).
class SceneSet {
public:
    SceneSet() = default;
    SceneSet(const DevicePtr& device, std::string name, uint32_t max_textures);
    explicit operator bool() const { return data_ != nullptr; }
    // The set must not be in use by the GPU; the caller alternates two sets per frame where the scene changes.
    void set_accel(const AccelStruct& now, const AccelStruct& before);
    void set_header(const Buffer& header);
    void set_texture(uint32_t slot, const Image& image, const Sampler& sampler);
    uint32_t max_textures() const;
    struct Data;
    const std::shared_ptr<Data>& data() const { return data_; }

private:
    std::shared_ptr<Data> data_;
};

// One resource bound to a name of set 1.
struct Binding {
    uint32_t binding = 0;
    BindingKind kind = BindingKind::StorageBuffer;
    std::variant<Buffer, Image, AccelStruct> resource;
    Sampler sampler;  // SampledImage only
};

// A set of (producer use -> consumer use) pairs that one memory barrier covers.
struct BarrierScope {
    std::vector<Use> before, after;
};

// A bottom level to build, from these geometries. With `refit_from`, a built one of the deforming class like `blas`, only positions may
// differ from what that one was built from; its tree is kept and fitted to them.
struct BlasBuild {
    AccelStruct blas;
    std::vector<BlasGeometry> geometries;
    AccelStruct refit_from;
};

// Timestamps of one frame; two per pass.
class TimerPool {
public:
    TimerPool() = default;
    TimerPool(const DevicePtr& device, uint32_t count);
    explicit operator bool() const { return data_ != nullptr; }
    uint32_t count() const;
    std::vector<double> read_ms(uint32_t count) const;  // milliseconds since the first; call after completion
    struct Data;
    const std::shared_ptr<Data>& data() const { return data_; }

private:
    std::shared_ptr<Data> data_;
};

// What an attachment holds before anything is drawn: four floats or four integers, as its format has them.
struct ClearColor {
    std::array<uint32_t, 4> bits{};
    static ClearColor floats(float r, float g, float b, float a);
    static ClearColor uints(uint32_t r, uint32_t g, uint32_t b, uint32_t a) { return {{r, g, b, a}}; }
};
// The images that a raster program draws into, all of one extent. Without a clear value an image keeps what it holds.
struct RenderTarget {
    struct Color {
        Image image;
        std::optional<ClearColor> clear;
    };
    std::vector<Color> colors;  // by location
    Image depth;                // may be empty
    std::optional<float> depth_clear;
    Extent extent() const { return colors.empty() ? depth.extent() : colors.front().image.extent(); }
};
// Pixels [x, x + width) x [y, y + height) of the target.
struct Rect {
    uint32_t x = 0, y = 0, width = 0, height = 0;
    friend bool operator==(const Rect&, const Rect&) = default;
};
// Three vertices a triangle. The shader sees first_vertex + 0, 1, ... and first_instance + 0, 1, ...
struct Draw {
    uint32_t vertex_count = 0, instance_count = 1, first_vertex = 0, first_instance = 0;
};
static_assert(sizeof(Draw) == 16);  // VkDrawIndirectCommand

class CommandList {
public:
    explicit CommandList(const DevicePtr& device);              // an own command buffer, begun
    CommandList(const DevicePtr& device, VkCommandBuffer host);  // records into a host program's (already begun)
    ~CommandList();
    CommandList(CommandList&&) noexcept;
    CommandList& operator=(CommandList&&) noexcept;

    void begin_label(std::string_view name);
    void end_label();
    void barrier(const BarrierScope& scope);
    void full_barrier();                                // everything waits for everything
    void initialise_layout(const Image& image);         // UNDEFINED -> GENERAL; nothing happens after the first time

    void bind(const Program& program, const SceneSet* scene, std::span<const Binding> bindings, std::span<const std::byte> push);
    void dispatch(uint32_t groups_x, uint32_t groups_y, uint32_t groups_z);  // checked against the device's limits
    void dispatch_indirect(const Buffer& args, uint64_t offset);
    void trace(uint32_t width, uint32_t height, uint32_t depth);
    void trace_indirect(const Buffer& args, uint64_t offset);

    // Draws of the bound raster program lie between these two; the viewport is the whole target, and so is the scissor at first.
    void begin_rendering(const RenderTarget& target);
    void end_rendering();
    void set_scissor(const Rect& rect);  // the part of it that lies in the target
    void draw(const Draw& draw);
    // `count` draws (struct Draw) from `offset` of a buffer on.
    void draw_indirect(const Buffer& draws, uint64_t offset, uint32_t count);
    // As many as the word at `count_offset` of `count` says, at most `most`; where the device cannot read that, all `most` of them, so that
    // those after the last must be empty (vertex_count 0).
    void draw_indirect_count(const Buffer& draws, uint64_t offset, const Buffer& count, uint64_t count_offset, uint32_t most);

    void copy(const Buffer& from, uint64_t from_offset, const Buffer& to, uint64_t to_offset, uint64_t bytes);
    void copy_to_image(const Buffer& from, uint64_t offset, const Image& to, uint32_t mip, uint32_t first_row, uint32_t rows);  // tightly packed
    void copy_from_image(const Image& from, const Buffer& to, uint64_t offset);
    void fill(const Buffer& buffer, uint64_t offset, uint64_t bytes, uint32_t value);
    void blit_mip(const Image& image, uint32_t from_mip);  // linear filter into from_mip + 1
    void scale(const Image& from, const Image& to);        // the whole of it, linear filter where sizes differ; formats are converted
    // Into the image that the window has taken (gpu/swapchain.h), scaled to its size; ready to be shown.
    void copy_to_window(const Image& from, const Swapchain& to);

    // They may run side by side, each in its own part of `scratch`, which follow one another from offset 0.
    void build_blas(std::span<const BlasBuild> builds, const Buffer& scratch);
    void measure_blas(std::span<const AccelStruct> blases, const AccelSizes& sizes);  // built; as many as sizes.count()
    void compact_blas(const AccelStruct& from, const AccelStruct& to);                // `to` as AccelStruct::compacted made it
    void build_tlas(const AccelStruct& tlas, const Buffer& instances, uint64_t offset, uint32_t count, const Buffer& scratch, uint64_t scratch_offset);

    void reset_timers(const TimerPool& pool);
    void write_timer(const TimerPool& pool, uint32_t index);
    // Writes `value` to a mapped buffer once all earlier commands are done: tells the last completed pass after a device loss.
    void write_marker(const Buffer& readback, uint32_t value);

    struct Impl;
    Impl& impl() { return *impl_; }

private:
    std::unique_ptr<Impl> impl_;
};

// Submits an own command list; the returned ticket tells when it is done. Resources referenced by the list must live until
// then (Frame keeps them). Throws Error on device loss.
// With a window it waits for the image that the window has taken, which the list fills, and shows it when it is done.
Ticket submit(const DevicePtr& device, CommandList&& commands, Swapchain* window = nullptr);
bool is_done(const DevicePtr& device, Ticket ticket);
// Waits for completion, at most timeout_seconds (then false). Throws Error on device loss.
bool wait(const DevicePtr& device, Ticket ticket, double timeout_seconds = 600.0);

}  // namespace parhelion::gpu
