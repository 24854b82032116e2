#pragma once
// Cuts a job into slices (some rows, some samples of one block) that keep the GPU busy for about a set time each, so that Ctrl-C,
// progress and watchdogs are no problem. Pictures do not depend on the cut. No Vulkan.
#include <cstdint>
#include <optional>
#include <vector>

#include "base/parse.h"
#include "shared/reference.h"

namespace parhelion {

class Slicer {
public:
    static constexpr uint64_t kMostWork = 1u << 30;  // shaders count a slice's pixel-samples with 32 bits

    // `first_slice_work` is the size of the first slice in pixel-samples; the following ones grow or shrink to `target_seconds`.
    // None is larger than `most_work`, but for one sample of one row, and none has more than `most_samples`.
    Slicer(Size2 size, IndexRange samples, double target_seconds = 0.06, uint64_t first_slice_work = 1u << 15, uint64_t most_work = kMostWork, uint64_t most_samples = shared::kSamplesPerBlock);

    // The next slice, none when all is done. Samples go up; all rows of some samples come before the next samples.
    std::optional<shared::Slice> next();
    void measured(const shared::Slice& slice, double seconds);  // after each slice

    // Samples that are complete in every row, counted from 0 (not from the range's begin): the next slice begins with this one.
    uint64_t whole_samples() const { return row_ == 0 ? sample_ : pass_begin_; }
    // Samples per row, counted like whole_samples().
    std::vector<uint64_t> samples_of_rows() const;
    // Rows of the running samples are missing, and these samples end a block: rows would differ in their number of blocks.
    bool inside_block_end() const;
    uint64_t budget() const { return static_cast<uint64_t>(budget_); }  // pixel-samples of the next slice
    double done_work() const { return done_work_; }  // pixel-samples
    double total_work() const { return total_work_; }

private:
    Size2 size_;
    IndexRange samples_;
    double target_seconds_, most_work_, most_samples_;
    double budget_;                 // pixel-samples of a slice
    uint64_t sample_, pass_begin_;  // end and begin of the samples that rows are now given
    uint32_t row_ = 0;              // next row of them; 0: none is running
    double done_work_ = 0, total_work_;
};

}  // namespace parhelion
