// The options of the viewer: render's, where they make sense in a window.
#include <gtest/gtest.h>

#include "base/error.h"
#include "session/render_options.h"

namespace parhelion::view_options_test {
namespace {

RenderOptions parse_view(const std::vector<std::string>& words) {
    const OptionValues values = parse_options(Command::View, words, [](const char*) -> const char* { return nullptr; });
    check_options(values);
    return read_view_options(values);
}

std::string usage_error(const std::vector<std::string>& words) {
    try {
        parse_view(words);
    } catch (const Error& error) {
        EXPECT_EQ(error.code, ErrorCode::Usage) << error.line;
        return error.line;
    }
    return "(accepted)";
}

TEST(ViewOptions, a_window_draws_without_end_unless_samples_are_given) {
    EXPECT_GE(parse_view({"a.glb"}).samples.end, 1u << 30);
    const RenderOptions options = parse_view({"a.glb", "--spp", "9", "--size", "40x30", "--renderer", "wavefront", "--aov", "albedo", "--out", "a.png"});
    EXPECT_EQ(options.samples.end, 9u);
    EXPECT_EQ(options.size.width, 40u);
    EXPECT_EQ(options.renderer, RendererKind::Wavefront);
    EXPECT_EQ(options.aovs, std::vector<std::string>{"albedo"});
    EXPECT_EQ(options.output.files.size(), 1u);
    EXPECT_EQ(options.shutter_seconds, 0);
}

TEST(ViewOptions, an_environment_may_follow_the_scene) {
    EXPECT_EQ(parse_view({"a.glb", "sky.hdr"}).environment, "sky.hdr");
    EXPECT_EQ(parse_view({"a.glb", "--env", "sky.hdr"}).environment, "sky.hdr");
    EXPECT_NE(usage_error({"a.glb", "sky.hdr", "--env", "b.hdr"}).find("given already"), std::string::npos);
    EXPECT_NE(usage_error({"a.glb", "b.hdr", "c.hdr"}).find("too many"), std::string::npos);
}

TEST(ViewOptions, what_belongs_to_a_finished_picture_alone_is_refused) {
    EXPECT_NE(usage_error({"a.glb", "--checkpoint", "f"}).find("--checkpoint"), std::string::npos);
    EXPECT_NE(usage_error({"a.glb", "--spp-range", "0-64"}).find("--spp-range"), std::string::npos);
    EXPECT_NE(usage_error({"a.glb", "--aov", "albedo,normal"}).find("one layer"), std::string::npos);
    EXPECT_NE(usage_error({"a.glb", "--aov", "depth"}).find("depth"), std::string::npos);
    EXPECT_NE(usage_error({}).find("SCENE"), std::string::npos);
}

}  // namespace
}  // namespace parhelion::view_options_test
