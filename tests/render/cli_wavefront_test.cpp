// The wavefront as the program shows it: its numbers as JSON, its passes as a listing, its forms in the bench.
#include <set>

#include <gtest/gtest.h>

#include "base/file.h"
#include "support/gpu_fixture.h"
#include "support/process.h"

namespace parhelion::testing::cli_wavefront_test {
namespace {

using Words = std::vector<std::string>;
using Json = nlohmann::json;
const Words kSmall{"render", "builtin:cornell", "--size", "24x16", "--spp", "2", "--exposure", "3", "--renderer", "wavefront"};

Words operator+(Words words, const Words& more) {
    words.insert(words.end(), more.begin(), more.end());
    return words;
}

void expect_in_order(const std::string& text, const Words& parts) {
    size_t at = 0;
    for (const std::string& part : parts) {
        const size_t found = text.find(part, at);
        ASSERT_NE(found, std::string::npos) << part << " in\n" << text.substr(at);
        at = found + part.size();
    }
}

class CliWavefront : public GpuTest {
protected:
    TemporaryFolder folder;
    std::string file(const std::string& name) const { return folder.file(name); }
};

}  // namespace

TEST_F(CliWavefront, the_wavefront_says_what_it_did_at_every_bounce) {
    const ProcessResult result = run_parhelion(kSmall + Words{"--out", file("a.exr"), "--json", "-"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const Json json = result.json(), &wavefront = json["wavefront"];
    EXPECT_EQ(json["renderer"], "wavefront");
    EXPECT_GT(json["mrays_per_s"], 0.0);
    EXPECT_GT(json["gpu_seconds"], 0.0);
    EXPECT_LE(json["trace_seconds"].get<double>(), json["gpu_seconds"].get<double>());
    uint64_t rays = 0, shadows = 0;
    double occupancy = 0;
    for (const Json& bounce : wavefront["bounces"]) {
        rays += bounce["rays"].get<uint64_t>();
        shadows += bounce["shadow_rays"].get<uint64_t>();
        occupancy += bounce["occupancy"].get<double>();
    }
    EXPECT_EQ(wavefront["bounces"][0]["rays"], 24 * 16 * 2);
    EXPECT_EQ(json["rays"]["path"], rays);
    EXPECT_EQ(json["rays"]["shadow"], shadows);
    EXPECT_NEAR(wavefront["occupancy"].get<double>(), occupancy, 1e-9);
    for (const Json& pass : json["passes"]) {
        const std::string name = pass["name"];
        EXPECT_EQ(pass["rays"], name.starts_with("wavefront/extend") ? rays : name.starts_with("wavefront/connect") ? shadows : 0) << name;
    }
    EXPECT_NE(result.err.find("% of the slots traced a ray"), std::string::npos) << result.err;
}

TEST_F(CliWavefront, the_listing_of_the_wavefront_has_its_kernels_in_order_and_a_table_of_bounces) {
    const Words words = kSmall + Words{"--max-bounces", "5", "--list-frame", "--set", "wavefront.classes=on"};
    const ProcessResult each = run_parhelion(words + Words{"--set", "wavefront.connect=each_bounce"}), once = run_parhelion(words + Words{"--set", "wavefront.connect=once"});
    expect_in_order(each.out, {"wavefront/begin", "wavefront/generate", "wavefront/extend", "wavefront/sort", "wavefront/shade", "wavefront/connect", "wavefront/finalize", "bounce", "\n     5 "});
    expect_in_order(once.out, {"wavefront/begin", "6 times:\n", "| wavefront/generate", "| wavefront/extend", "| wavefront/shade", "  wavefront/connect", "  wavefront/finalize", "bounce"});
    EXPECT_EQ(each.out.find("times:", each.out.find("wavefront/begin")), std::string::npos);
}

TEST_F(CliWavefront, the_bench_of_the_wavefront_holds_its_forms_against_the_reference) {
    const Words words{"bench", "wavefront", "--scene", "builtin:diffuse-box", "--trace", "compute", "--size", "16x16", "--spp", "1"};
    const ProcessResult result = run_parhelion(words + Words{"--json", file("w.json")});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const Json all = Json::parse(read_text_file(file("w.json"), 1 << 24));
    ASSERT_EQ(all["runs"].size(), 9u);
    EXPECT_EQ(all["runs"][0]["renderer"], "reference");
    EXPECT_EQ(all["runs"][0]["max_bounces"], 8);
    std::set<std::string> cases;
    for (const Json& run : all["runs"]) {
        cases.insert(run["case"].get<std::string>());
        EXPECT_GT(run["mpaths_per_s"], 0.0);
        EXPECT_GT(run["to_best_reference"], 0.0);
        EXPECT_EQ(run["rays"], all["runs"][0]["rays"]);
        if (run["renderer"] == "wavefront") {
            EXPECT_GT(run["replay"]["extend"]["trace_share"], 0.0);
        }
    }
    EXPECT_EQ(cases.size(), 9u);
    EXPECT_TRUE(cases.contains("builtin:diffuse-box wavefront compute once full one_kernel 16x16 1"));
    EXPECT_NE(result.out.find("once indirect classes"), std::string::npos) << result.out;
}

}  // namespace parhelion::testing::cli_wavefront_test
