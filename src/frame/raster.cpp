// Raster passes: what they draw into, and their draws.
#include <algorithm>

#include "base/error.h"
#include "frame/frame.h"

namespace parhelion {

using gpu::Use;

Pass Frame::raster(std::string_view name, const gpu::RasterState& state, std::string_view defines) {
    Pass pass(*this, std::string(name), std::string(defines), Pass::Kind::Raster);
    pass.raster_state_ = state;
    pass.raster_code_ = gpu::Program::raster_code(*pack_, name, defines);
    return pass;
}

Pass& Pass::color(std::string_view name, const gpu::Image& image, const std::optional<gpu::ClearColor>& clear) {
    PARHELION_CHECK(kind_ == Kind::Raster && image, "pass {}: output '{}' is {}", name_, name, image ? "of a pass that does not draw" : "an empty image");
    output_names_.emplace_back(name);
    target_.colors.push_back({image, clear});
    return *this;
}

Pass& Pass::depth(const gpu::Image& image, std::optional<float> clear) {
    PARHELION_CHECK(kind_ == Kind::Raster && image, "pass {}: the depth buffer is {}", name_, image ? "of a pass that does not draw" : "an empty image");
    target_.depth = image;
    target_.depth_clear = clear;
    return *this;
}

// Matches the colours against the shader's outputs, both ways, and sorts them by location.
void Pass::check_outputs() {
    std::vector<gpu::ShaderBinding> outputs;
    std::copy_if(raster_code_.bindings.begin(), raster_code_.bindings.end(), std::back_inserter(outputs),
                 [](const gpu::ShaderBinding& b) { return b.kind == gpu::BindingKind::ColorOutput; });
    std::sort(outputs.begin(), outputs.end(), [](const auto& a, const auto& b) { return a.binding < b.binding; });
    std::vector<gpu::RenderTarget::Color> sorted;
    std::string declared;
    for (const gpu::ShaderBinding& output : outputs) {
        declared += (declared.empty() ? "" : ", ") + output.name;
        const auto at = std::find(output_names_.begin(), output_names_.end(), output.name);
        if (at != output_names_.end()) sorted.push_back(target_.colors[static_cast<size_t>(at - output_names_.begin())]);
    }
    PARHELION_CHECK(sorted.size() == outputs.size() && sorted.size() == target_.colors.size(), "pass {} {}: the shader's outputs are {}; each needs one color()", name_,
                    variant_, declared.empty() ? "nothing" : declared);
    PARHELION_CHECK(!sorted.empty() || target_.depth, "pass {}: it draws into nothing", name_);
    PARHELION_CHECK(target_.depth || raster_state_.depth_test == gpu::DepthTest::None, "pass {}: a depth test needs depth()", name_);
    target_.colors = std::move(sorted);
}

gpu::Program Pass::raster_program() const {
    gpu::RasterTarget formats;
    for (const gpu::RenderTarget::Color& color : target_.colors) formats.colors.push_back(color.image.desc().format);
    if (target_.depth) formats.depth = target_.depth.desc().format;
    const auto make = [device = frame_.device_, name = name_, variant = variant_, state = raster_state_, formats](const gpu::ShaderPack& pack) {
        return gpu::Program::get_raster(device, pack, name, variant, state, formats);
    };
    frame_.raster_programs_[name_ + variant_] = make;
    return make(*frame_.pack_);
}

// Draws from buffers, and attachments, which are read as well unless they are cleared. The depth buffer counts as written whatever the state says.
void Pass::note_target(FrameRecord& record, std::vector<Access>& accesses) const {
    for (const gpu::Buffer& list : draw_lists_) {
        record.info.reads.push_back(list.name());
        accesses.push_back({list.id(), Use::IndirectRead, &list.name()});
        frame_.keep(list.data());
    }
    const auto note = [&](const gpu::Image& image, Use use, bool cleared) {
        record.images.push_back(image);
        if (!cleared) record.info.reads.push_back(image.name());
        record.info.writes.push_back(image.name());
        accesses.push_back({image.id(), use, &image.name()});
        frame_.keep(image.data());
    };
    for (const gpu::RenderTarget::Color& color : target_.colors) note(color.image, Use::ColorAttachment, color.clear.has_value());
    if (target_.depth) note(target_.depth, Use::DepthAttachment, target_.depth_clear.has_value());
}

void Pass::draw_into_target(std::function<void(gpu::CommandList&)> draws) {
    PARHELION_CHECK(kind_ == Kind::Raster, "pass {} does not draw", name_);
    check_outputs();
    const gpu::Extent extent = target_.extent();
    finish(fmt::format("{}x{}", extent.width, extent.height),
           [target = target_, draws = std::move(draws)](gpu::CommandList& commands) {
               commands.begin_rendering(target);
               draws(commands);
               commands.end_rendering();
           },
           {});
}

void Pass::draw(std::vector<DrawCall> draws) {
    const gpu::Extent extent = target_.extent();
    const gpu::Rect whole{0, 0, extent.width, extent.height};
    draw_into_target([whole, draws = std::move(draws)](gpu::CommandList& commands) {
        gpu::Rect now = whole;
        for (const DrawCall& call : draws) {
            const gpu::Rect wanted = call.scissor.value_or(whole);
            if (wanted != now) commands.set_scissor(now = wanted);
            commands.draw(call.draw);
        }
    });
}

void Pass::draw_indirect(const gpu::Buffer& draws, uint64_t offset, const gpu::Buffer& count, uint64_t count_offset, uint32_t most) {
    draw_lists_ = {draws, count};
    draw_into_target([=](gpu::CommandList& commands) { commands.draw_indirect_count(draws, offset, count, count_offset, most); });
}

}  // namespace parhelion
