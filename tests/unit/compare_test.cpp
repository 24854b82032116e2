// `compare` over files: sequences, limits, the exposure that both sides get, the report.
#include "session/compare.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "base/error.h"
#include "image/encode.h"
#include "session/film_state.h"
#include "support/process.h"

namespace parhelion::compare_test {
namespace {

using testing::TemporaryFolder;

image::ImageF ramp(float scale, std::optional<double> ev = 3.0) {
    image::ImageF picture = image::make_image(24, 16, {"R", "G", "B", "albedo.R", "albedo.G", "albedo.B"});
    for (size_t i = 0; i < picture.data.size(); ++i) picture.data[i] = scale * (1.0f + float(i % 24));
    if (ev) picture.attributes[kExposureAttribute] = fmt::format("{}", *ev);
    return picture;
}

class Compare : public ::testing::Test {
protected:
    TemporaryFolder folder;
    std::string write(const std::string& name, const image::ImageF& picture) const {
        image::write_exr(folder.file(name), picture, image::ExrPrecision::Float);
        return folder.file(name);
    }
};

std::string error_line(const std::function<void()>& body) {
    try {
        body();
    } catch (const Error& error) {
        return error.line;
    }
    return "(no error)";
}

}  // namespace

TEST_F(Compare, equal_pictures_have_no_error_and_a_ratio_of_one) {
    const std::string a = write("a.exr", ramp(1));
    const auto json = compare_json(compare_files(a, a, "", {.flip = 0.0, .relmse = 0.0}, {}));
    EXPECT_EQ(json["mean_ratio"], 1.0);
    for (const char* key : {"mse", "relmse", "flip", "nan_count"}) EXPECT_EQ(json[key], 0) << key;
    EXPECT_TRUE(json["exceeded"].empty());
    EXPECT_FALSE(json.contains("frames"));
}

TEST_F(Compare, a_limit_is_exceeded_only_by_more) {
    const std::string a = write("a.exr", ramp(1)), b = write("b.exr", ramp(1.1f));
    const CompareReport free = compare_files(b, a, "", {}, {});
    const double relmse = free.frames[0].result.relmse, flip = free.frames[0].result.flip.mean;
    EXPECT_NEAR(free.frames[0].result.mean_ratio.luminance, 1.1, 1e-5);
    EXPECT_TRUE(free.exceeded.empty());
    EXPECT_TRUE(compare_files(b, a, "", {.flip = flip, .relmse = relmse}, {}).exceeded.empty());
    EXPECT_EQ(compare_files(b, a, "", {.flip = flip * 0.999, .relmse = relmse}, {}).exceeded.size(), 1u);
    EXPECT_EQ(compare_files(b, a, "", {.flip = flip * 0.999, .relmse = relmse * 0.999}, {}).exceeded.size(), 2u);
}

TEST_F(Compare, broken_pixels_are_over_every_limit_and_counted) {
    image::ImageF broken = ramp(1);
    broken.data[5] = std::numeric_limits<float>::quiet_NaN();
    broken.data[7] = std::numeric_limits<float>::infinity();
    const std::string a = write("a.exr", ramp(1)), b = write("b.exr", broken);
    const CompareReport report = compare_files(b, a, "", {.relmse = 1e9}, {});
    EXPECT_EQ(compare_json(report)["nan_count"], 1);
    EXPECT_EQ(compare_json(report)["inf_count"], 1);
    ASSERT_EQ(report.exceeded.size(), 1u);
    EXPECT_NE(report.exceeded[0].find("broken pixels"), std::string::npos);
}

TEST_F(Compare, both_sides_get_the_references_exposure) {
    const std::string recorded = write("a.exr", ramp(1, 3.0)), other = write("b.exr", ramp(1, 9.0)),
                      bare = write("c.exr", ramp(1, std::nullopt));
    const ComparedFrame frame = compare_files(other, recorded, "", {}, {}).frames[0];
    EXPECT_TRUE(frame.exposure_recorded);
    EXPECT_DOUBLE_EQ(frame.result.exposure_scale, 1 / (1.2 * 8));
    EXPECT_FALSE(compare_files(recorded, bare, "", {}, {}).frames[0].exposure_recorded);
}

TEST_F(Compare, a_layer_is_compared_by_name) {
    image::ImageF changed = ramp(1);
    for (float& value : changed.plane(3)) value = 0;
    const std::string a = write("a.exr", ramp(1)), b = write("b.exr", changed);
    EXPECT_EQ(compare_files(b, a, "", {}, {}).frames[0].result.mse, 0);
    EXPECT_GT(compare_files(b, a, "albedo", {}, {}).frames[0].result.mse, 0);
    EXPECT_NE(error_line([&] { compare_files(b, a, "nothing", {}, {}); }), "(no error)");
}

TEST_F(Compare, sequences_are_paired_by_number) {
    write("t.8.exr", ramp(1));  // one digit is no match for ##
    for (const char* name : {"t.09.exr", "r.09.exr", "t.10.exr", "r.10.exr"}) write(name, ramp(1));
    write("t.0100.exr", ramp(1.5f));
    write("r.0100.exr", ramp(1));
    const CompareReport report = compare_files(folder.file("t.##.exr"), folder.file("r.##.exr"), "", {.relmse = 1e-6}, {});
    ASSERT_EQ(report.frames.size(), 3u);
    EXPECT_EQ(report.frames[0].name, "09");
    EXPECT_EQ(report.frames[2].name, "0100");
    ASSERT_EQ(report.exceeded.size(), 1u);
    EXPECT_NE(report.exceeded[0].find("1 of 3 frames are over it, worst 0100"), std::string::npos) << report.exceeded[0];
    EXPECT_NEAR(compare_json(report)["mean_ratio"].get<double>(), (1 + 1 + 1.5) / 3, 1e-4);
    EXPECT_EQ(compare_json(report)["frames"].size(), 3u);

    write("t.11.exr", ramp(1));
    EXPECT_NE(error_line([&] {
                  compare_files(folder.file("t.##.exr"), folder.file("r.##.exr"), "", {}, {});
              }).find("r.##.exr: frame 11 is missing"),
              std::string::npos);
    EXPECT_NE(error_line([&] { compare_files(folder.file("x.##.exr"), folder.file("r.##.exr"), "", {}, {}); }).find("no file matches"),
              std::string::npos);
    EXPECT_NE(error_line([&] {
                  compare_files(folder.file("t.##.exr"), folder.file("r.10.exr"), "", {}, {});
              }).find("a sequence is compared with a sequence"),
              std::string::npos);
}

TEST_F(Compare, the_report_is_a_page_with_its_pictures_beside_it) {
    const std::string a = write("a<b>&\".exr", ramp(1)), b = write("b.exr", ramp(2));
    const std::filesystem::path html = folder.path() / "report";
    compare_files(b, a, "", {.flip = 0.0}, html);
    for (const char* name : {"index.html", "test.png", "reference.png", "flip.png"})
        EXPECT_TRUE(std::filesystem::exists(html / name)) << name;
    const std::string page = testing::read_bytes(html / "index.html");
    EXPECT_NE(page.find("a&lt;b&gt;&amp;&quot;.exr"), std::string::npos);
    EXPECT_EQ(page.find("http"), std::string::npos) << "no network";
    EXPECT_NE(page.find("the limit is 0"), std::string::npos);
    EXPECT_NE(error_line([&] { compare_files(b, a, "", {}, folder.path() / "no" / "report"); }).find("the folder cannot be made"),
              std::string::npos);
}

TEST_F(Compare, different_sizes_are_refused_by_name) {
    const std::string a = write("a.exr", ramp(1)), b = write("b.exr", image::make_image(8, 8, {"R", "G", "B"}));
    EXPECT_NE(error_line([&] { compare_files(b, a, "", {}, {}); }).find("is 8x8 pixels"), std::string::npos);
}

}  // namespace parhelion::compare_test
