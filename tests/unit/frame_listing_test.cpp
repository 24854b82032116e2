// The text of a recorded frame.
#include <gtest/gtest.h>

#include "frame/listing.h"

namespace parhelion::frame_listing_test {
namespace {

// Passes of one letter each, the n-th of n milliseconds.
std::vector<PassInfo> passes_named(std::string_view letters) {
    std::vector<PassInfo> passes;
    for (const char letter : letters) passes.push_back({.name = std::string(1, letter), .gpu_ms = double(passes.size() + 1)});
    return passes;
}

// Only numbers, bars, names and times of the listing, a space between rows.
std::string short_listing(std::string_view letters, bool with_times = false) {
    std::string out;
    const std::string listing = list_passes(passes_named(letters), with_times);
    for (size_t begin = 0, end; begin < listing.size(); begin = end + 1) {
        end = listing.find('\n', begin);
        const std::string line = listing.substr(begin, end - begin);
        if (!out.empty()) out += ' ';
        if (line.ends_with("times:")) out += line.substr(5);
        else out += std::to_string(std::stoi(line)) + line.substr(5, 3) + (with_times ? line.substr(line.rfind("; ") + 2) : "");
        while (out.ends_with(' ')) out.pop_back();
    }
    return out;
}

}  // namespace

TEST(FrameListing, a_row_names_the_pass_and_what_it_reads_and_writes) {
    const PassInfo pass{.name = "a/pass", .variant = "query", .reads = {"x", "y"}, .writes = {"z"}, .extent = "8x8", .gpu_ms = 1.5};
    EXPECT_EQ(list_passes({&pass, 1}, true), "  1  a/pass                       query      8x8        reads: x y; writes: z; 1.500 ms\n");
    const PassInfo bare{.name = "b"};
    EXPECT_EQ(list_passes({&bare, 1}, false), "  1  b                            -          -          reads: -; writes: -\n");
}

TEST(FrameListing, rows_that_come_again_and_again_are_printed_once_with_their_number_and_summed_times) {
    EXPECT_EQ(short_listing("abc"), "1a 2b 3c");
    EXPECT_EQ(short_listing("xabababy"), "1x 3 times: 2| a 3| b 8y");
    EXPECT_EQ(short_listing("aaab", true), "3 times: 1| a6.000 ms 4b  4.000 ms");
    EXPECT_EQ(short_listing("abab", true), "2 times: 1| a4.000 ms 2| b6.000 ms");
}

TEST(FrameListing, of_several_repetitions_the_one_counts_that_saves_most_rows) {
    EXPECT_EQ(short_listing("aabaab"), "2 times: 1| a 2| a 3| b");
    EXPECT_EQ(short_listing("aaaa"), "4 times: 1| a");
}

TEST(FrameListing, a_block_begins_where_the_loop_does) {
    EXPECT_EQ(short_listing("bpgspgspgspc"), "1b 2p 3 times: 3| g 4| s 5| p 12c");
}

TEST(FrameListing, passes_that_differ_in_what_they_touch_are_not_alike) {
    std::vector<PassInfo> passes = passes_named("abab");
    passes[2].writes = {"elsewhere"};
    EXPECT_EQ(list_passes(passes, false).find("times:"), std::string::npos);
}

}  // namespace parhelion::frame_listing_test
