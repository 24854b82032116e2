#pragma once
// A frame is a list of passes. A pass is recorded by name with its resources bound by name; Frame checks the names against the
// shader's reflection in both directions, finds the barriers, keeps resources alive while the GPU uses them, measures and lists.
//
//     gpu::Image ldr = frame.image("post/tonemap.ldr", hdr.extent(), gpu::Format::Rgba8Unorm);
//     frame.compute("post/tonemap").read("hdr", hdr).write("ldr", ldr).push(TonemapPush{scale}).over(ldr.extent());
//
// Passes run in call order. Nothing reaches the GPU before record() or submit().
#include <array>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "frame/hazard.h"
#include "gpu/command_list.h"

namespace parhelion {

class Frame;

// What is timed on the GPU. Timers keep passes apart that would run side by side.
enum class Timers { None, Frame, Passes };

struct FrameOptions {
    bool full_barriers = false;  // everything waits for everything: pictures must not change
    int skip_barrier = -1;       // leaves the n-th barrier of a frame out (tests of the hazard tracker)
    Timers timers = Timers::Passes;
    bool markers = true;         // remembers the last completed pass, reported when the device is lost
};

// One row of the recorded frame.
struct PassInfo {
    std::string name;     // shader path, debug label, timing row, listing row
    std::string variant;  // way to trace and defines
    std::vector<std::string> reads, writes;
    std::string extent;  // "1280x720", "indirect", "" for copies
    uint32_t group = 0;  // neighbours of one group run beside each other (Frame::together); 0: alone
    double gpu_ms = 0;   // after completion
};

// Set 0 with everything that shaders reach through it.
struct SceneBinding {
    gpu::SceneSet set;
    std::vector<gpu::Buffer> buffers;
    std::vector<gpu::Image> textures;
    std::vector<gpu::AccelStruct> accels;
    uint32_t bvh_variant = 0;  // layout of our own nodes and loop of their traversal: constant 0 of the programs that trace them
};

// A resource that outlives the frame: this frame's and last frame's instance.
template <class T>
struct History {
    T now, before;
    bool valid = false;  // `before` holds data
};

// A draw of a raster pass; without a scissor it may touch all of the target.
struct DrawCall {
    gpu::Draw draw;
    std::optional<gpu::Rect> scissor = {};
};

// A pass as the Frame keeps it until it is recorded.
struct FrameRecord {
    PassInfo info;
    std::vector<Access> accesses;
    std::vector<gpu::Image> images = {};  // that may need their first layout
    std::function<void(gpu::CommandList&)> launch;
};

// The builder of one pass. over(), over_indirect(), or the draws of a raster pass end it.
class Pass {
public:
    Pass& read(std::string_view name, const gpu::Buffer& buffer);
    Pass& write(std::string_view name, const gpu::Buffer& buffer);
    Pass& read_write(std::string_view name, const gpu::Buffer& buffer);
    // The buffer that the shader has under this name, which it does not touch in this launch: nothing waits for it.
    Pass& untouched(std::string_view name, const gpu::Buffer& buffer);
    Pass& read(std::string_view name, const gpu::Image& image);
    Pass& write(std::string_view name, const gpu::Image& image);
    Pass& read_write(std::string_view name, const gpu::Image& image);
    Pass& sample(std::string_view name, const gpu::Image& image, const gpu::Sampler& sampler);
    Pass& scene(const SceneBinding& scene);
    // Buffers that the shader reads through addresses in other buffers.
    Pass& reach(std::span<const gpu::Buffer> buffers);
    Pass& reach_written(std::span<const gpu::Buffer> buffers);  // that it writes so
    // The push constant block, a struct of shaders/shared. Members that are buffer references are filled in by the bindings.
    template <class T>
    Pass& push(const T& block) {
        return push_bytes(&block, sizeof(T));
    }
    void over(uint32_t width, uint32_t height = 1, uint32_t depth = 1);  // invocations; divided by the local size
    void over(gpu::Extent extent) { over(extent.width, extent.height, extent.depth); }
    // So many invocations, in rows where there may be more than devices take work groups in one (wavefront/linear.glsl counts along them).
    void over_all(uint64_t count);
    void over_indirect(const gpu::Buffer& args, uint64_t offset);

    // Raster passes. What is drawn into: the fragment shader's outputs by name, and the depth buffer. Without a clear value an image keeps
    // what it holds. All have one extent.
    Pass& color(std::string_view name, const gpu::Image& image, const std::optional<gpu::ClearColor>& clear = {});
    Pass& depth(const gpu::Image& image, std::optional<float> clear = {});
    void draw(std::vector<DrawCall> draws);  // in this order; none: only clears
    // gpu::Draw[] in a buffer, from `offset` bytes on: as many as the word at `count_offset` of `count` says, at most `most`. Those behind must
    // be empty (vertex_count 0) where DeviceCaps::draw_indirect_count is missing: there all `most` are drawn.
    void draw_indirect(const gpu::Buffer& draws, uint64_t offset, const gpu::Buffer& count, uint64_t count_offset, uint32_t most);

private:
    friend class Frame;
    struct Bound {
        std::string name;
        std::variant<gpu::Buffer, gpu::Image> resource;
        gpu::Sampler sampler;
        bool reads, writes;  // neither: the launch does not touch it
    };
    static bool is_touched(const Bound& bound) { return bound.reads || bound.writes; }
    enum class Kind { Compute, Trace, Raster };
    Pass(Frame& frame, std::string name, std::string variant, Kind kind) : frame_(frame), name_(std::move(name)), variant_(std::move(variant)), kind_(kind) {}
    const gpu::Program& program();  // made when it is first needed: the scene's layout of nodes is a constant in it
    gpu::Program raster_program() const;
    const gpu::ShaderCode& code();  // of a raster pass: known before its program, which depends on what it draws into
    Pass& bind(std::string_view name, std::variant<gpu::Buffer, gpu::Image> resource, bool reads, bool writes, const gpu::Sampler& sampler = {});
    Pass& push_bytes(const void* data, size_t bytes);
    gpu::Use use(bool reads, bool writes) const;
    gpu::Use sample_use() const;
    void check_outputs();
    void note_target(FrameRecord& record, std::vector<Access>& accesses) const;
    void draw_into_target(std::function<void(gpu::CommandList&)> draws);
    void resolve(std::vector<gpu::Binding>& bindings, std::vector<Access>& accesses);
    void finish(std::string extent, std::function<void(gpu::CommandList&)> launch, std::vector<Access> accesses);

    Frame& frame_;
    std::string name_, variant_;
    Kind kind_;
    gpu::Program program_;
    gpu::RasterState raster_state_;
    gpu::ShaderCode raster_code_;
    gpu::RenderTarget target_;               // colours in order of location, once check_outputs() has sorted them
    std::vector<std::string> output_names_;  // of the colours
    std::vector<gpu::Buffer> draw_lists_;    // that draws are read from
    std::vector<Bound> bound_;
    std::vector<gpu::Buffer> reached_, reached_written_;
    std::vector<std::byte> push_;
    const SceneBinding* scene_ = nullptr;
};

class Frame {
public:
    explicit Frame(gpu::DevicePtr device, const FrameOptions& options = {}, const gpu::ShaderPack& pack = gpu::ShaderPack::builtin());
    ~Frame();
    Frame(const Frame&) = delete;
    Frame& operator=(const Frame&) = delete;

    const gpu::DevicePtr& device() const { return device_; }

    // Resources of this Frame by name: the same call gives the same object until extent, format or size change.
    gpu::Image image(const std::string& name, gpu::Extent extent, gpu::Format format);
    gpu::Buffer buffer(const std::string& name, uint64_t bytes);
    // Two instances that change places every frame. Changed extents and reset_history() make `before` invalid.
    History<gpu::Image> history(const std::string& name, gpu::Extent extent, gpu::Format format);
    void reset_history(std::string_view reason);

    // A compute pass; a tracing pass in one of the three ways. `defines`: "+DEFINE" for a declared variant.
    Pass compute(std::string_view name, std::string_view defines = {});
    Pass trace(std::string_view name, gpu::TraceWay way, std::string_view defines = {});
    // Triangles through a vertex and a fragment shader, which read vertices by address; on devices with DeviceCaps::raster.
    Pass raster(std::string_view name, const gpu::RasterState& state, std::string_view defines = {});

    // The passes that `record` records run beside each other: no barrier lies between them. The caller knows that they may: what two of them touch they
    // touch by atomics, or each its own part.
    void together(const std::function<void()>& record);

    // Transfers and builds are passes too.
    void upload(const gpu::Buffer& to, uint64_t offset, std::span<const std::byte> bytes);
    // The first `mips` mips, finest first, with tightly packed rows.
    void upload_image(const gpu::Image& to, std::span<const std::byte> texels, uint32_t mips = 1);
    // The same without a copy of the data on the host: writes the mapped memory returned, before anything else is asked of the Frame.
    std::span<std::byte> upload_in_place(const gpu::Buffer& to, uint64_t offset, uint64_t bytes);
    // Rows [first_row, first_row + rows) of one level, tightly packed.
    std::span<std::byte> upload_rows_in_place(const gpu::Image& to, uint32_t mip, uint32_t first_row, uint32_t rows);
    void make_mips(const gpu::Image& image);
    void scale(const gpu::Image& from, const gpu::Image& to);  // the whole of it, linear filter where sizes differ
    // Into the image that the window has taken, which submit() then shows: the last pass of a frame that is submitted.
    void show(const gpu::Image& from, gpu::Swapchain& window);
    void fill(const gpu::Buffer& buffer, uint32_t value);
    void copy(const gpu::Buffer& from, uint64_t from_offset, const gpu::Buffer& to, uint64_t to_offset, uint64_t bytes);
    gpu::Buffer read_back(const gpu::Buffer& from);  // mapped copy, valid after completion
    gpu::Buffer read_back(const gpu::Image& from);
    // Bottom levels that may be built side by side, or all be refitted (gpu::BlasBuild::refit_from), out of these buffers.
    void build_blas(std::vector<gpu::BlasBuild> builds, const std::vector<gpu::Buffer>& inputs);
    // The sizes that they would have compacted: sizes.read() once the frame is done.
    void measure_blas(std::vector<gpu::AccelStruct> blases, const gpu::AccelSizes& sizes);
    void compact_blas(const gpu::AccelStruct& from, const gpu::AccelStruct& to);
    void build_tlas(const gpu::AccelStruct& tlas, const gpu::Buffer& instances, uint32_t count, std::span<const gpu::AccelStruct> bottoms);

    // Images that passes recorded so far in this frame write, each once, in order: to look at.
    std::vector<gpu::Image> written_images() const;
    // Shaders of the passes from now on, which must outlive this; between two frames. Makes the programs of the passes recorded so far out of
    // them at once, and frees those that they replace. Throws Error, and keeps the old ones, if one cannot be made or takes other resources than
    // before. The frames before have run to their end.
    void use_pack(const gpu::ShaderPack& pack);

    // Ends the frame by recording it into `commands`, in order, with barriers. The caller submits, and says with
    // retire(serial) that the GPU has finished the frame; until then its resources are kept. Returns the frame's serial.
    uint64_t record(gpu::CommandList& commands);
    void retire(uint64_t serial);
    // Ends the frame: records and submits on the device's queue, does not wait.
    gpu::Ticket submit();
    // Waits, retires, reads the timers. Device loss: the Error names the last completed pass.
    void wait(gpu::Ticket ticket);
    void run() { wait(submit()); }

    // The last recorded frame; times are there after wait().
    const std::vector<PassInfo>& passes() const { return listing_; }
    double gpu_ms() const { return gpu_ms_; }  // from its first pass's begin to its last's end, what lies between them included; 0: no timers
    std::string listing(bool with_times = false) const;  // as `render --list-frame` prints it (frame/listing.h)
    uint32_t barrier_count() const { return barrier_count_; }
    const std::vector<std::string>& complaints() const { return complaints_; }  // unordered accesses that were recorded

private:
    friend class Pass;
    using Record = FrameRecord;
    struct InFlight {
        uint64_t serial = 0;
        gpu::Ticket ticket = 0;
        std::vector<std::shared_ptr<void>> kept;
        gpu::TimerPool timers;
    };
    // Mapped memory of this frame, freed when it is retired.
    struct Staging {
        gpu::Buffer buffer;
        uint64_t offset = 0;
    };
    Staging stage(uint64_t bytes);
    // Uploads that follow one another into rising places of one buffer are one pass.
    struct Upload {
        gpu::Buffer from, to;
        std::vector<std::array<uint64_t, 3>> regions;  // from, to, bytes
    };
    void add(Record record);
    void keep(std::shared_ptr<void> object) { kept_.push_back(std::move(object)); }
    void order(std::span<const Record> records, gpu::CommandList& commands);
    size_t end_of_group(size_t first) const;
    void read_timers(const InFlight& frame);
    [[noreturn]] void report_loss(const std::exception& cause);

    gpu::DevicePtr device_;
    FrameOptions options_;
    const gpu::ShaderPack* pack_;
    HazardTracker tracker_;
    std::vector<Record> records_;
    uint32_t group_ = 0, groups_ = 0;  // of the passes that are recorded now, and how many there were
    std::vector<std::shared_ptr<void>> kept_;
    Staging staging_;  // what is left of it: from the offset on
    std::shared_ptr<Upload> upload_;  // of the last record, if that is one
    size_t upload_end_ = 0;           // records until then
    std::vector<InFlight> in_flight_;
    // What Program::get was asked for.
    struct ProgramKey {
        std::string name, variant;
        bool ray_tracing = false;
        uint32_t constant = 0;
        auto operator<=>(const ProgramKey&) const = default;
    };
    std::set<ProgramKey> programs_;
    std::map<std::string, std::function<gpu::Program(const gpu::ShaderPack&)>> raster_programs_;  // by name and variant: makes them out of another pack
    std::map<std::string, gpu::Image> images_;
    std::map<std::string, gpu::Buffer> buffers_;
    std::map<std::string, uint64_t> history_written_;  // frame serial that last wrote each history
    std::vector<PassInfo> listing_;
    double gpu_ms_ = 0;
    std::vector<std::string> complaints_;
    gpu::Buffer marker_;
    gpu::Swapchain* window_ = nullptr;  // that this frame is shown in
    uint32_t barrier_count_ = 0;
    uint64_t serial_ = 1, recorded_serial_ = 0;
};

}  // namespace parhelion
