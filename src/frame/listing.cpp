#include "frame/listing.h"

#include <algorithm>

#include <fmt/ranges.h>

#include "base/error.h"

namespace parhelion {

namespace {

std::string or_dash(const std::string& text) { return text.empty() ? "-" : text; }

// A row without number and time. What repeats stands behind a bar, what runs beside the row before it behind an ampersand.
std::string row(const PassInfo& pass, bool beside, bool repeats) {
    return fmt::format("{:<28} {:<10} {:<10} reads: {}; writes: {}", (repeats ? "| " : "") + std::string(beside ? "& " : "") + pass.name, or_dash(pass.variant), or_dash(pass.extent), or_dash(fmt::format("{}", fmt::join(pass.reads, " "))),
                       or_dash(fmt::format("{}", fmt::join(pass.writes, " "))));
}

struct Repeat {
    size_t first, length, times;
    size_t saved() const { return (times - 1) * length; }
};

// The repetition from the row `first` on that saves most rows, of blocks as short as possible; times = 1: there is none. One that stops within a
// block is taken to have begun within one: so a loop's block begins where the loop does, not with a row before it that ends blocks too.
Repeat find_repeat(std::span<const size_t> rows, size_t first) {
    constexpr size_t kLongestBlock = 64;
    Repeat best{first, 1, 1};
    for (size_t length = 1; length <= std::min(kLongestBlock, (rows.size() - first) / 2); ++length) {
        size_t end = first + length;
        while (end < rows.size() && rows[end] == rows[end - length]) ++end;
        const Repeat found{first + (end - first) % length, length, (end - first) / length};
        if (found.saved() > best.saved()) best = found;
    }
    return best;
}

}  // namespace

std::string list_passes(std::span<const PassInfo> passes, bool with_times) {
    const auto beside = [&](size_t i) { return i > 0 && passes[i].group != 0 && passes[i].group == passes[i - 1].group; };
    std::map<std::string, size_t> numbers;
    std::vector<size_t> rows;
    for (size_t i = 0; i < passes.size(); ++i) rows.push_back(numbers.try_emplace(row(passes[i], beside(i), false), numbers.size()).first->second);

    std::string out;
    const auto print = [&](size_t i, const Repeat& repeat) {
        double ms = 0;
        for (size_t n = 0; n < repeat.times; ++n) ms += passes[i + n * repeat.length].gpu_ms;
        out += fmt::format("{:>3}  {}", i + 1, row(passes[i], beside(i), repeat.times > 1)) + (with_times ? fmt::format("; {:.3f} ms\n", ms) : "\n");
    };
    for (size_t i = 0; i < passes.size();) {
        const Repeat repeat = find_repeat(rows, i);
        for (; i < repeat.first; ++i) print(i, {i, 1, 1});
        if (repeat.times > 1) out += fmt::format("     {} times:\n", repeat.times);
        for (; i < repeat.first + repeat.length; ++i) print(i, repeat);
        i = repeat.first + repeat.length * repeat.times;
    }
    return out;
}

}  // namespace parhelion
